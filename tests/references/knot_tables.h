// Knot tables for tests.
#pragma once

#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "references/learners/knot_density.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {

/// `count` knots of mass `energy`: most of them small, some of them 0, neighbouring peaks among them.
inline KnotDensity rough_table(std::size_t count, float energy, std::uint64_t seed) {
  RandomStream random(seed, count);
  std::vector<Knot> knots(count);
  double sum = 0;
  for (Knot& knot : knots) {
    const float u = random.next();
    knot = {u < 0.2f ? 0.0f : u * u * u * 10, 1 + random.next(), 0.25f * random.next()};
    sum += static_cast<double>(knot.density);
  }
  const double scale = energy * static_cast<double>(count) / (2 * std::numbers::pi) / sum;
  for (Knot& knot : knots) knot.density = static_cast<float>(knot.density * scale);
  return KnotDensity(std::move(knots));
}

}  // namespace tress::inline v0_2::adaptive
