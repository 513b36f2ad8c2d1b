#include "models/rough/rough_fibers.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "models/rough/colored_decays.h"
#include "models/rough/rough_row.h"
#include "models/rough/row_energies.h"

namespace tress::fiber {
namespace {

/// The form of a row under one absorption.
class ColoredForm final : public adaptive::RowForm {
 public:
  ColoredForm(std::shared_ptr<const RoughGrid> grid, std::shared_ptr<const EnergyTable> table, const glm::vec3& sigma_a)
      : grid_(std::move(grid)), energies_(std::move(table), sigma_a), decays_(sigma_a) {}
  std::size_t bytes(const adaptive::RowView&) const override { return sizeof(RoughRow); }
  void write(const adaptive::RowView& row, void* memory) const override {
    const FiberDirection at = grid_->direction(row.node);
    const adaptive::DecodedRow decoded(*row.ribbons);
    const EnergyFactors energies = energies_.at(decoded, row.paths, at.theta, at.phi);
    put_rough_row(decoded, row.objective, row.paths, decays_, energies, memory);
  }

 private:
  std::shared_ptr<const RoughGrid> grid_;
  RowEnergies energies_;
  ColoredDecays decays_;
};

}  // namespace

FiberId RoughFibers::add(const FiberParameters& parameters) {
  FiberParameters exact = parameters;
  exact.reflection_fresnel = ReflectionFresnel::exact;
  if (service_ != nullptr && !service_->add_slice(rough_slice(exact))) return no_fiber;
  const FiberId id = store_.add(exact);
  if (id < rows_.size()) return id;
  traced_.add(exact);
  rows_.push_back(service_ != nullptr ? rows_of(exact, store_[id].energies) : RoughRows{});
  rows_.back().balance = TracedFibers::balance(exact, *store_[id].energies, offset());
  return id;
}

RoughRows RoughFibers::rows_of(const FiberParameters& parameters, const std::shared_ptr<const EnergyTable>& energies) {
  const adaptive::SliceDescription description = rough_slice(parameters);
  const adaptive::SliceId slice = service_->add_slice(description).value();
  std::shared_ptr<const RoughGrid>& grid = grids_[slice];
  if (!grid) grid = std::make_shared<const RoughGrid>(description);
  const glm::vec3& sigma_a = parameters.sigma_a;
  const adaptive::FormedRows*& formed = formed_[{slice, {sigma_a.x, sigma_a.y, sigma_a.z}}];
  if (formed == nullptr) {
    formed =
        service_
            ->add_form(slice, std::make_shared<ColoredForm>(grid, energies, sigma_a), {sigma_a.x, sigma_a.y, sigma_a.z})
            .value();
  }
  RoughRows rows{grid, formed};
  const auto inverse = [](float gain) { return gain > 0 ? 1 / gain : 0.0f; };
  std::ranges::transform(parameters.gain, rows.inverse_gain.begin(), [&](const glm::vec3& gain) {
    return Float4{inverse(gain.x), inverse(gain.y), inverse(gain.z), 1};
  });
  return rows;
}

}  // namespace tress::fiber
