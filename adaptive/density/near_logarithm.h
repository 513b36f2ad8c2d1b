// A logarithm for codes, several times as fast as the library's.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace tress::adaptive {

/// ln x for x > 0 and not denormal, with an error of 1e-13. Each octave is cut into 256 intervals, and the logarithm of
/// an interval's middle is tabulated.
class NearLogarithm {
 public:
  NearLogarithm() {
    for (std::size_t i = 0; i < cells; ++i) {
      const double middle = 1 + (static_cast<double>(i) + 0.5) / cells;
      cells_[i] = {middle, 1 / middle, std::log(middle)};
    }
  }
  double operator()(double x) const {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const Cell& cell = cells_[bits >> 44 & (cells - 1)];
    const double m = std::bit_cast<double>((bits & 0xfffffffffffff) | 0x3ff0000000000000);
    const double r = (m - cell.middle) * cell.inverse;
    const auto octave = static_cast<double>(static_cast<std::int64_t>(bits >> 52) - 1023);
    return octave * std::numbers::ln2 + (cell.logarithm + r * (1 - r * (1.0 / 2 - r * (1.0 / 3 - r * 0.25))));
  }

 private:
  static constexpr std::size_t cells = 256;
  struct Cell {
    double middle, inverse, logarithm;
  };
  std::array<Cell, cells> cells_;
};

inline double near_log(double x) {
  static const NearLogarithm logarithm;
  return logarithm(x);
}

}  // namespace tress::adaptive
