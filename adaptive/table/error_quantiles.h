// Quantiles of errors that come one by one and stay: counted by value, so that a table of any size keeps a few
// thousand.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>

namespace tress::adaptive {

/// Values are kept to 2^-7 of themselves, rounded up, within [1e-12, 1e6]. The order in which they come does not
/// matter.
class ErrorQuantiles {
 public:
  /// Finite, >= 0.
  void add(double error) {
    const auto value = static_cast<float>(std::clamp(error, 1e-12, 1e6));
    ++count_of_[(std::bit_cast<std::uint32_t>(value) + 0xffffu) & ~0xffffu];
    ++count_;
  }
  std::uint64_t count() const { return count_; }
  /// How many there are of each value, by its bits; and back.
  const std::map<std::uint32_t, std::uint64_t>& counts() const { return count_of_; }
  void add_counted(std::uint32_t bits, std::uint64_t count) {
    count_of_[bits] += count;
    count_ += count;
  }
  /// Smallest value that at least this share of them does not exceed; 0 if there is none.
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
  std::map<std::uint32_t, std::uint64_t> count_of_;  ///< by the bits of the value, which order as it does
  std::uint64_t count_ = 0;
};

}  // namespace tress::adaptive
