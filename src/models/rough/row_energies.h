// What the draws that taught a row say of the energies of its parts, beside the energy table.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>

#include "fiber/energy_table.h"
#include "fiber/rough_rows.h"
#include "tress/adaptive/ribbon.h"

namespace tress::fiber {

/// By channel, what energies of the table are to be multiplied by.
struct EnergyFactors {
  std::array<glm::vec3, rough_parts> part{glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(1.0f)};
  glm::vec3 whole{1.0f};  ///< of the sum of all parts; 1 where sigma_a is 0
};

/// The energies of a row's parts over those of the table at its node, without gains. At sigma_a 0 and at both of
/// Ribbon::decay_rates the row knows the energy of a part without bias: its mass times the mean decay of its knots.
/// The logarithm of their ratio to the table's there is interpolated, in sigma_a up to the first rate, in ln sigma_a
/// to the second, and kept beyond it: the table knows how lengths are distributed, the row how much light there is.
/// Masses are scaled to what the table has at the node in clear hair. A row of few paths knows little of either: that
/// logarithm is weighed by n^1.5/(n^1.5 + 1400^1.5), n its paths, and more where the row and the table differ by more
/// than the row's noise. Immutable; any thread.
class RowEnergies {
 public:
  RowEnergies(std::shared_ptr<const EnergyTable> table, const glm::vec3& sigma_a)
      : table_(std::move(table)), sigma_a_(sigma_a) {}
  /// Of a row at this node, radians, that so many paths have taught.
  EnergyFactors at(const adaptive::DecodedRow& row, std::uint64_t paths, float theta_r, float phi_r) const;

 private:
  std::shared_ptr<const EnergyTable> table_;
  glm::vec3 sigma_a_;
};

}  // namespace tress::fiber
