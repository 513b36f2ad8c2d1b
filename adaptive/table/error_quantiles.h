// Quantiles of a growing set of errors. Equal values are counted, so a table of any size keeps a few thousand values.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>

namespace tress::inline v0_2::adaptive {

/// Values are clamped to [1e-12, 1e6] and rounded up, by at most 2^-7 of themselves. Their order does not matter.
class ErrorQuantiles {
 public:
  /// error: finite, >= 0.
  void add(double error) {
    const auto value = static_cast<float>(std::clamp(error, 1e-12, 1e6));
    ++count_of_[(std::bit_cast<std::uint32_t>(value) + 0xffffu) & ~0xffffu];
    ++count_;
  }
  std::uint64_t count() const { return count_; }
  /// The number of errors of each value, by the bits of the float; add_counted() restores them.
  const std::map<std::uint32_t, std::uint64_t>& counts() const { return count_of_; }
  void add_counted(std::uint32_t bits, std::uint64_t count) {
    count_of_[bits] += count;
    count_ += count;
  }
  /// The smallest value that at least this share of the errors does not exceed; 0 if there are no errors.
  double quantile(double share) const {
    const double rank = std::max(1.0, std::ceil(share * static_cast<double>(count_)));
    std::uint64_t below = 0;
    for (const auto& [bits, count] : count_of_) {
      below += count;
      if (static_cast<double>(below) >= rank) return std::bit_cast<float>(bits);
    }
    return 0;
  }

 private:
  std::map<std::uint32_t, std::uint64_t> count_of_;  ///< by the bits of the value, which sort as the values do
  std::uint64_t count_ = 0;
};

}  // namespace tress::inline v0_2::adaptive
