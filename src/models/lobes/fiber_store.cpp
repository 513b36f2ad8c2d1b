#include "models/lobes/fiber_store.h"

#include <algorithm>
#include <set>

namespace tress::inline v0_2::fiber {
namespace {

std::array<float, 3> values_of(const glm::vec3& color) { return {color.r, color.g, color.b}; }

}  // namespace

FiberId FiberStore::add(const FiberParameters& parameters) {
  const auto [id, is_new] = ids_.find_or_add(parameters);
  if (is_new) fibers_.push_back({parameters, energies_of(parameters)});
  return id;
}

std::shared_ptr<const EnergyTable> FiberStore::energies_of(const FiberParameters& parameters) {
  EnergyTableKey key{energy_key(parameters), values_of(parameters.sigma_a), {}, parameters.reflection_fresnel};
  auto gain = std::get<2>(key).begin();
  for (const glm::vec3& lobe : parameters.gain) gain = std::ranges::copy(values_of(lobe), gain).out;
  std::shared_ptr<const EnergyTable>& table = colored_energies_[key];
  if (!table) table = std::make_shared<const EnergyTable>(clear_.find(energy_key(parameters)), parameters);
  return table;
}

std::size_t FiberStore::bytes() const {
  std::size_t bytes = fibers_.size() * sizeof(FiberRecord);
  std::set<const ClearEnergies*> clear;
  for (const auto& [key, table] : colored_energies_) {
    bytes += table->bytes();
    if (clear.insert(&table->clear()).second) bytes += table->clear().bytes();
  }
  return bytes;
}

}  // namespace tress::inline v0_2::fiber
