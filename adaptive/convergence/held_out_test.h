// Measures the error of a row on draws that it was not fitted to (ESTIMATOR.md, E9).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "convergence/exit_cells.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::inline v0_2::adaptive {

/// An unbiased estimate of the integral of (S - f)^2/f over all parts, at the resolution of the test's cells, and its
/// standard deviation. It uses draws that f was not fitted to, and includes the masses of the parts.
struct SampledTest {
  double chi2 = 0, deviation = 0;
  /// The value that must be within epsilon. A fit whose error is epsilon passes one test with a probability of 0.001.
  double bound() const { return chi2 + 3.1 * deviation; }
  /// A value above epsilon shows that the error is above epsilon. A fit whose error is epsilon is above it with a
  /// probability of 0.001.
  double lower() const { return chi2 - 3.1 * deviation; }
};

/// The light of a row by cells: expected by the row, and observed in the sets of paths. The sum of several rows has the
/// same form.
struct HeldOutCells {
  static constexpr std::size_t sets = 4, cells_u = 16, cells_v = 8, cells = cells_u * cells_v;

  std::vector<double> expected;                    ///< light that the row expects in each cell of a part, by part
  double mass = 0;                                 ///< total light of the row
  double paths = 0;                                ///< number of paths in each set
  std::array<std::vector<double>, sets> observed;  ///< sums of weights over `paths`, by part and cell

  SampledTest result() const;
  /// Adds the light of another row. Each row counts by its number of paths, with its mass scaled to 1.
  void add(const HeldOutCells& other);
};

/// Tests one row by sets of paths that are independent of it and of one another. Not thread-safe.
class HeldOutTest {
 public:
  static constexpr std::size_t sets = HeldOutCells::sets, cells_u = HeldOutCells::cells_u,
                               cells_v = HeldOutCells::cells_v, cells = HeldOutCells::cells;
  /// A part with less than this share of the row's mass is tested as if it had this share, because so little light
  /// cannot be judged.
  static constexpr double least_share = 1e-4;

  explicit HeldOutTest(const RibbonRow& row);

  /// Adds the exits of the paths of a set. Their parts must be below the row's number of parts.
  void add(std::size_t set, std::span<const SampledExit> exits);
  /// Exits of one part as columns, faster if neighbours are near in azimuth. `azimuth` and `height` can be read 16
  /// floats past their end. Exits whose set is not below `sets` are left out.
  struct Columns {
    std::span<const float> azimuth, height, weight;  ///< azimuths in [-pi, pi)
    std::span<const std::uint8_t> set;
    double unit;  ///< of the weights
  };
  void add(std::uint32_t part, const Columns& exits);
  /// The cells of all that was added. paths: number of paths in each set.
  HeldOutCells found(std::uint32_t paths) const;
  SampledTest result(std::uint32_t paths) const { return found(paths).result(); }

 private:
  static constexpr std::size_t at_once = 64;

  CellTables tables_;
  std::vector<double> expected_;                    ///< mass that the row expects in each cell of a part, by part
  double mass_ = 0;                                 ///< total mass of the row
  std::array<std::vector<double>, sets> observed_;  ///< sums of weights, by part and cell
};

}  // namespace tress::inline v0_2::adaptive
