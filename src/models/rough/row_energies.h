// The energies of a row's parts, estimated from the row's own paths, relative to the energy table.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>

#include "fiber/energy_table.h"
#include "fiber/rough_rows.h"
#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::fiber {

/// The factors on energies of the table, by channel.
struct EnergyFactors {
  std::array<glm::vec3, rough_parts> part{glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(1.0f)};
  glm::vec3 whole{1.0f};  ///< on the sum of all parts; 1 if sigma_a is 0
};

/// The energies of a row's parts over those of the table at its node, without gains. At sigma_a 0 and at both
/// Ribbon::decay_rates the row estimates the energy of a part without bias: its mass times the mean decay of its knots.
/// The logarithm of the ratio to the table is interpolated in sigma_a up to the first rate and in ln sigma_a up to the
/// second. Beyond it is constant: the table has the distribution of lengths, the row the amount of light. Masses are
/// scaled to the table's sum at the node in clear hair.
///
/// The estimates from few paths are noisy, so the logarithm is weighted by n^1.5/(n^1.5 + 1400^1.5), n the row's paths,
/// or by more if the row and the table differ by more than the row's noise. Immutable; any thread.
class RowEnergies {
 public:
  RowEnergies(std::shared_ptr<const EnergyTable> table, const glm::vec3& sigma_a)
      : table_(std::move(table)), sigma_a_(sigma_a) {}
  /// Returns the factors for a row at this node, in radians, that was learned from this many paths.
  EnergyFactors at(const adaptive::DecodedRow& row, std::uint64_t paths, float theta_r, float phi_r) const;
  /// ln of the factors that make energies of the row's masses, by part, at sigma_a 0 and at both rates, whatever the
  /// color; at 0 all parts together have the table's energy. In between they are interpolated as above.
  std::array<std::array<float, 3>, rough_parts> corrections(const adaptive::DecodedRow& row, std::uint64_t paths,
                                                            float theta_r, float phi_r) const;

 private:
  struct Compared;
  Compared compare(const adaptive::DecodedRow& row, std::uint64_t paths, float theta_r, float phi_r) const;

  std::shared_ptr<const EnergyTable> table_;
  glm::vec3 sigma_a_;
};

}  // namespace tress::inline v0_2::fiber
