// How far a row is from draws that it does not know (ESTIMATOR.md, E9).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "convergence/exit_cells.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::adaptive {

/// An unbiased estimate of the integral of (S - f)^2/f over all parts at the resolution of the test's cells, the masses
/// of the parts included, with its standard deviation, from draws that f does not know.
struct SampledTest {
  double chi2 = 0, deviation = 0;
  /// What a row is held to: a fit at epsilon passes one test with a probability of 0.001.
  double bound() const { return chi2 + 3.1 * deviation; }
};

/// The light of a row by cells: what the row expects there, and what sets of paths have brought. The sum of several
/// rows has the same form.
struct HeldOutCells {
  static constexpr std::size_t sets = 4, cells_u = 16, cells_v = 8, cells = cells_u * cells_v;

  std::vector<double> expected;                    ///< light of a cell, by part
  double mass = 0;                                 ///< of the row
  double paths = 0;                                ///< of a set
  std::array<std::vector<double>, sets> observed;  ///< sums of weights over `paths`, by part and cell

  SampledTest result() const;
  /// Adds the light of another row: each path counts alike, and each row has a mass of 1.
  void add(const HeldOutCells& other);
};

/// The test of one row by sets of paths that are independent of it and of one another. One thread.
class HeldOutTest {
 public:
  static constexpr std::size_t sets = HeldOutCells::sets, cells_u = HeldOutCells::cells_u,
                               cells_v = HeldOutCells::cells_v, cells = HeldOutCells::cells;
  /// A part of less than this share of the row's mass is tested as if it had it: of so little nothing is known.
  static constexpr double least_share = 1e-4;

  explicit HeldOutTest(const RibbonRow& row);

  /// The exits of the paths of a set; parts below the row's.
  void add(std::size_t set, std::span<const SampledExit> exits);
  /// What was added, where each set had so many paths.
  HeldOutCells found(std::uint32_t paths) const;
  SampledTest result(std::uint32_t paths) const { return found(paths).result(); }

 private:
  CellTables tables_;
  std::vector<double> expected_;                    ///< mass of a cell, by part
  double mass_ = 0;                                 ///< of the row
  std::array<std::vector<double>, sets> observed_;  ///< sums of weights, by part and cell
};

}  // namespace tress::adaptive
