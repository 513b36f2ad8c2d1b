#include "models/rough/rough_fibers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <new>
#include <utility>

#include "models/rough/colored_decays.h"
#include "models/rough/rough_row.h"
#include "models/rough/row_energies.h"
#include "models/rough/uncolored_row.h"

namespace tress::inline v0_2::fiber {
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

/// The form of a row whose color is given where it is read.
class UncoloredForm final : public adaptive::RowForm {
 public:
  UncoloredForm(std::shared_ptr<const RoughGrid> grid, std::shared_ptr<const EnergyTable> table)
      : grid_(std::move(grid)), energies_(std::move(table), glm::vec3(0.0f)) {}
  std::size_t bytes(const adaptive::RowView&) const override { return sizeof(UncoloredRow); }
  void write(const adaptive::RowView& row, void* memory) const override {
    const FiberDirection at = grid_->direction(row.node);
    const adaptive::DecodedRow decoded(*row.ribbons);
    put_uncolored_row(decoded, energies_.corrections(decoded, row.paths, at.theta, at.phi), *new (memory) UncoloredRow);
  }

 private:
  std::shared_ptr<const RoughGrid> grid_;
  RowEnergies energies_;
};

/// Fibers that differ by no more share coarse rows. The margins are for rounding.
constexpr float similar_eccentricity = 0.0101f, similar_roughness = 1.101f;

/// Whether coarse rows of the one fiber are nearer to the other's scattering than a coarse row of 512 paths is to its
/// own (bench/README.md, calibration). The keys are those of rough_slice().
bool are_similar(const adaptive::SliceKey& a, const adaptive::SliceKey& b) {
  const auto& own = a.parameters;
  const auto& other = b.parameters;
  return own[0] == other[0] && std::equal(own.begin() + 3, own.end(), other.begin() + 3) &&
         coarse_azimuth_step(own[1]) == coarse_azimuth_step(other[1]) &&
         std::abs(own[1] - other[1]) <= similar_eccentricity &&
         std::max(own[2], other[2]) <= similar_roughness * std::min(own[2], other[2]);
}

}  // namespace

FiberId RoughFibers::add(const FiberParameters& parameters) {
  FiberParameters exact = parameters;
  exact.reflection_fresnel = ReflectionFresnel::exact;
  if (service_ != nullptr) {
    const adaptive::SliceDescription slice = slice_of(exact);
    if (!service_->add_slice(slice)) return no_fiber;
    const bool is_known = std::ranges::find(with_coarse_rows_, slice.key) != with_coarse_rows_.end();
    if (!slice.coarse_rows_of && !is_known) with_coarse_rows_.push_back(slice.key);
  }
  const FiberId id = store_.add(exact);
  if (id < rows_.size()) return id;
  traced_.add(exact);
  rows_.push_back(service_ != nullptr ? rows_of(exact, store_[id].energies) : RoughRows{});
  const EnergyTable& energies = *store_[id].energies;
  rows_.back().balance = TracedFibers::balance(exact, energies, Offset::any);
  rows_.back().near_balance = TracedFibers::balance(exact, energies, Offset::known);
  return id;
}

adaptive::SliceDescription RoughFibers::slice_of(const FiberParameters& fiber) const {
  adaptive::SliceDescription slice = rough_slice(fiber);
  const auto found = std::ranges::find_if(
      with_coarse_rows_, [&](const adaptive::SliceKey& other) { return are_similar(slice.key, other); });
  if (found != with_coarse_rows_.end() && *found != slice.key) slice.coarse_rows_of = *found;
  return slice;
}

RoughRows RoughFibers::rows_of(const FiberParameters& parameters, const std::shared_ptr<const EnergyTable>& energies) {
  const adaptive::SliceDescription description = slice_of(parameters);
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
  const adaptive::FormedRows*& uncolored = uncolored_[slice];
  if (uncolored == nullptr)
    uncolored = service_->add_form(slice, std::make_shared<UncoloredForm>(grid, energies)).value();
  RoughRows rows{grid, formed, uncolored};
  const auto inverse = [](float gain) { return gain > 0 ? 1 / gain : 0.0f; };
  std::ranges::transform(parameters.gain, rows.inverse_gain.begin(), [&](const glm::vec3& gain) {
    return Float4{inverse(gain.x), inverse(gain.y), inverse(gain.z), 1};
  });
  return rows;
}

}  // namespace tress::inline v0_2::fiber
