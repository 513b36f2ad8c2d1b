#include "models/elliptical/fiber_store.h"

#include <algorithm>
#include <set>
#include <utility>

#include "models/elliptical/vertex_trace.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::fiber {
namespace {

std::array<float, 3> values_of(const glm::vec3& color) { return {color.r, color.g, color.b}; }

}  // namespace

FiberId FiberStore::add(const FiberParameters& parameters) {
  const auto [id, is_new] = ids_.find_or_add(parameters);
  if (!is_new) return id;

  FiberRecord fiber;
  fiber.parameters = parameters;
  fiber.widths = LobeWidths(parameters);
  const std::array<float, 3> sigmas = azimuthal_sigmas(parameters);
  fiber.sigma = {sigmas[0], sigmas[1], sigmas[2], sigmas[1]};
  fiber.energies = energies_of(parameters);
  fiber.answers_by_rows = service_ != nullptr;
  const std::array<int, 4> slice_lobes{1, parameters.split_glint ? trt_rest_slice : 2, 3, glint_slice};
  for (std::size_t i = 0; i < row_lobes.size(); ++i) {
    fiber.vertex_rays = std::max(fiber.vertex_rays, vertex_ray_count(fiber.sigma[i]));
    // Four degrees turned into radians may round below the limit and are still on the grid.
    fiber.proposes_only[i] = fiber.sigma[i] < smallest_grid_sigma * (1 - 1e-5f);
    fiber.answers_by_rows = fiber.answers_by_rows && !fiber.proposes_only[i];
    if (service_ == nullptr || (row_lobes[i] == Lobe::glint && !parameters.split_glint)) continue;
    fiber.rows[i] = rows_of(slice_lobes[i], std::max(fiber.sigma[i], smallest_grid_sigma), parameters);
  }
  fibers_.push_back(std::move(fiber));
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

std::shared_ptr<const ColoredRows> FiberStore::rows_of(int slice_lobe, float sigma_rad,
                                                       const FiberParameters& parameters) {
  std::shared_ptr<const SliceRows>& slice = slices_[{slice_lobe, parameters.eta, parameters.eccentricity, sigma_rad}];
  if (!slice) {
    slice = std::make_shared<const SliceRows>(
        *service_, elliptical_slice(slice_lobe, parameters.eta, parameters.eccentricity, sigma_rad));
  }
  std::shared_ptr<const ColoredRows>& shared = colored_rows_[{slice->slice, values_of(parameters.sigma_a)}];
  if (!shared) shared = std::make_shared<const ColoredRows>(*service_, slice, parameters.sigma_a);
  return shared;
}

std::size_t FiberStore::bytes() const {
  std::size_t bytes = fibers_.size() * sizeof(FiberRecord);
  std::set<const ClearEnergies*> clear;
  for (const auto& [key, table] : colored_energies_) {
    bytes += table->bytes();
    if (clear.insert(&table->clear()).second) bytes += table->clear().bytes();
  }
  for (const auto& [key, rows] : colored_rows_) bytes += rows->bytes();
  return bytes;
}

}  // namespace tress::fiber
