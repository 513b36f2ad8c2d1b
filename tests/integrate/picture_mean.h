// Means over a picture with their errors, for tests against values known on paper.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "integrate/renderer.h"
#include "support/scale.h"
#include "support/seed.h"

namespace tress::integrate {

/// |z| beyond this happens by chance once in 1.6 million tests (two-sided normal); seeds are fixed.
inline constexpr double z_limit = 5;

struct Mean {
  double value = 0, error = 0;  ///< standard error
};

/// Over the pixels, which are independent of each other.
inline Mean mean_of(const RenderResult& result, const std::string& name) {
  const std::vector<float>& pixels = result.picture.find(name)->pixels;
  const double n = static_cast<double>(pixels.size());
  double sum = 0, squares = 0;
  for (const float value : pixels) sum += value;
  for (const float value : pixels) squares += (value - sum / n) * (value - sum / n);
  return {sum / n, std::sqrt(squares / (n * (n - 1)))};
}

inline RenderOptions long_paths(int samples, std::uint64_t seed) {
  RenderOptions options;
  options.samples = test::scaled(samples);
  options.max_depth = 2000;
  options.roulette_depth = 4;
  options.seed = test::seed(seed);
  return options;
}

}  // namespace tress::integrate
