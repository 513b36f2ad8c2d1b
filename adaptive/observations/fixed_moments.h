// Count, sum and sum of squares that threads add to in any order with the same result.
#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>

namespace tress::inline v0_2::adaptive {

/// The values of FixedMoments as doubles. variance is the unbiased one, 0 for fewer than two values.
struct Moments {
  std::uint64_t count = 0;
  double mean = 0;
  double mean_square = 0;
  double variance() const {
    if (count < 2) return 0;
    const double n = static_cast<double>(count);
    return std::fmax(0.0, (mean_square - mean * mean) * (n / (n - 1)));
  }
};

/// Moments of values in [0, 2^MaximumBits] as integers in units of 2^(MaximumBits - 40), because integer sums are
/// associative and float sums are not. Squares are exact, in two words. It holds at least 2^23 values. add() may be
/// called by any thread.
template <int MaximumBits>
class FixedMoments {
 public:
  void add(double value) {
    const double largest = std::ldexp(1.0, MaximumBits);
    const double kept = value > 0 ? std::fmin(value, largest) : 0.0;  // NaN counts as 0
    const auto fixed = static_cast<std::uint64_t>(kept * std::ldexp(1.0, 40 - MaximumBits) + 0.5);
    const std::uint64_t high = fixed >> 20, low = fixed & 0xfffffu;
    // fixed^2 = high^2 2^40 + (2 high low 2^20 + low^2): the bracket is below 2^62, split at 2^40.
    const std::uint64_t rest = ((high * low) << 21) + low * low;
    count_.fetch_add(1, std::memory_order_relaxed);
    sum_.fetch_add(fixed, std::memory_order_relaxed);
    square_high_.fetch_add(high * high + (rest >> 40), std::memory_order_relaxed);
    square_low_.fetch_add(rest & ((std::uint64_t{1} << 40) - 1), std::memory_order_relaxed);
  }

  std::uint64_t count() const { return count_.load(std::memory_order_relaxed); }

  Moments moments() const {
    Moments result;
    result.count = count();
    if (result.count == 0) return result;
    const double n = static_cast<double>(result.count);
    const double high = static_cast<double>(square_high_.load(std::memory_order_relaxed));
    const double low = static_cast<double>(square_low_.load(std::memory_order_relaxed));
    result.mean = std::ldexp(static_cast<double>(sum_.load(std::memory_order_relaxed)) / n, MaximumBits - 40);
    result.mean_square = std::ldexp((std::ldexp(high, 40) + low) / n, 2 * (MaximumBits - 40));
    return result;
  }

  /// All words of the state, to save and to restore it. Must not run at the same time as add().
  using Words = std::array<std::uint64_t, 4>;
  Words words() const {
    return {count(), sum_.load(std::memory_order_relaxed), square_high_.load(std::memory_order_relaxed),
            square_low_.load(std::memory_order_relaxed)};
  }
  void set_words(const Words& words) {
    count_.store(words[0], std::memory_order_relaxed);
    sum_.store(words[1], std::memory_order_relaxed);
    square_high_.store(words[2], std::memory_order_relaxed);
    square_low_.store(words[3], std::memory_order_relaxed);
  }

  /// Must not run at the same time as add().
  void clear() {
    for (std::atomic<std::uint64_t>* word : {&count_, &sum_, &square_high_, &square_low_}) {
      word->store(0, std::memory_order_relaxed);
    }
  }

 private:
  std::atomic<std::uint64_t> count_{0}, sum_{0}, square_high_{0}, square_low_{0};
};

}  // namespace tress::inline v0_2::adaptive
