// TRESS_TEST_SCALE=N in the environment: statistical tests draw an N-th, for sanitizers, under which they take twenty
// times as long. Tolerances that come from the draws themselves (chi-square, standard errors) need nothing; one that is
// written down for the full number is widened by the root of N.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace tress::test {

inline int scale() {
  static const int by = [] {
    const char* text = std::getenv("TRESS_TEST_SCALE");
    return text == nullptr ? 1 : std::max(1, std::atoi(text));
  }();
  return by;
}

/// `count` draws, or the N-th part of them.
inline int scaled(int count) { return std::max(1, count / scale()); }

/// What a standard error of `count` draws becomes when there are scaled(count): 1 without TRESS_TEST_SCALE.
inline double widened(int count) { return std::sqrt(static_cast<double>(count) / scaled(count)); }

}  // namespace tress::test
