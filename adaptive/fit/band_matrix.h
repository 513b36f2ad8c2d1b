// Linear equations of knots in a row.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "tress/adaptive/ribbon.h"

namespace tress::adaptive {

/// A positive definite band matrix by its lower half, five off the diagonal: knots of three numbers, neighbours
/// coupled.
class BandMatrix {
 public:
  static constexpr std::size_t reach = 6, most = 3 * Ribbon::main_knots;
  explicit BandMatrix(std::size_t size) : size_(size) {}

  /// Row i and column j <= i, of at most reach - 1 apart.
  double& at(std::size_t i, std::size_t j) { return rows_[i][i - j]; }
  std::size_t size() const { return size_; }

  /// Solves in place by L D L^T; on the diagonal stand the inverses of D then. A pivot that is none leaves its entry 0.
  void solve(std::array<double, most>& right) {
    for (std::size_t i = 0; i < size_; ++i) {
      const std::size_t first = i + 1 > reach ? i + 1 - reach : 0;
      double pivot = at(i, i);
      for (std::size_t j = first; j < i; ++j) {  // the row of L D first, then of L
        double sum = at(i, j);
        for (std::size_t k = first; k < j; ++k) sum -= at(i, k) * at(j, k);
        at(i, j) = sum;
      }
      for (std::size_t j = first; j < i; ++j) {
        const double factor = at(i, j) * at(j, j);
        pivot -= factor * at(i, j);
        at(i, j) = factor;
        right[i] -= factor * right[j];
      }
      at(i, i) = pivot > 0 ? 1 / pivot : 0;
    }
    for (std::size_t i = size_; i-- > 0;) {
      right[i] *= at(i, i);
      for (std::size_t j = i + 1; j < std::min(i + reach, size_); ++j) right[i] -= at(j, i) * right[j];
    }
  }

 private:
  std::size_t size_;
  std::array<std::array<double, reach>, most> rows_{};  ///< rows_[i][d] stands at (i, i - d)
};
using BandSteps = std::array<double, BandMatrix::most>;

}  // namespace tress::adaptive
