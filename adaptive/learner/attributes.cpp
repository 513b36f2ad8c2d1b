#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "learner/learner.h"

namespace tress::adaptive {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;
constexpr double reach = 4;             // of the blur in sigma: 6e-5 of it lies beyond
constexpr double points_per_sigma = 4;  // linear interpolation between them errs by under .004 of a responsibility

/// Shares of each component, then of the uniform part, at equally spaced azimuths from -pi on: one part after the
/// other.
struct Shares {
  std::size_t points = 0, parts = 0;
  std::vector<float> values;
  float* of(std::size_t part) { return values.data() + part * points; }
  const float* of(std::size_t part) const { return values.data() + part * points; }
};

Shares responsibilities(const Mixture& mixture, std::size_t points) {
  Shares shares{points, mixture.component_count + std::size_t{1}, {}};
  shares.values.resize(shares.parts * points);
  const std::size_t uniform_part = mixture.component_count;
  for (std::size_t i = 0; i < points; ++i) {
    const auto x = static_cast<float>((static_cast<double>(i) / static_cast<double>(points) - 0.5) * two_pi);
    float sum = shares.of(uniform_part)[i] = mixture.uniform_weight / static_cast<float>(two_pi);
    for (std::size_t d = 0; d < uniform_part; ++d) {
      sum += shares.of(d)[i] = mixture.components[d].weight * mixture.components[d].shape.density(x);
    }
    if (!(sum > 0)) shares.of(uniform_part)[i] = sum = 1;
    for (std::size_t d = 0; d < shares.parts; ++d) shares.of(d)[i] /= sum;
  }
  return shares;
}

/// The same blurred by the wrapped Gaussian of standard deviation `blur`. Whole rows are added, so that the sums
/// vectorise.
Shares blurred(const Shares& sharp, double blur) {
  const double spacing = two_pi / static_cast<double>(sharp.points);
  const auto taps = static_cast<std::size_t>(std::ceil(reach * blur / spacing));
  std::vector<float> kernel(2 * taps + 1);
  float sum = 0;
  for (std::size_t k = 0; k < kernel.size(); ++k) {
    const double d = (static_cast<double>(k) - static_cast<double>(taps)) * spacing / blur;
    sum += kernel[k] = static_cast<float>(std::exp(-0.5 * d * d));
  }
  Shares smooth{sharp.points, sharp.parts, std::vector<float>(sharp.values.size())};
  std::vector<float> unrolled(sharp.points + 2 * taps);  // one part, with what lies beyond -pi and pi
  for (std::size_t part = 0; part < sharp.parts; ++part) {
    for (std::size_t i = 0; i < unrolled.size(); ++i) {
      unrolled[i] = sharp.of(part)[(i + sharp.points * (1 + taps / sharp.points) - taps) % sharp.points];
    }
    float* out = smooth.of(part);
    for (std::size_t k = 0; k < kernel.size(); ++k) {
      const float tap = kernel[k] / sum;
      for (std::size_t i = 0; i < sharp.points; ++i) out[i] += tap * unrolled[i + k];
    }
  }
  return smooth;
}

struct Moments {
  double mass = 0, first = 0, second = 0;
  void add(double weight, double value) {
    mass += weight;
    first += weight * value;
    second += weight * value * value;
  }
  double mean() const { return first / mass; }
  double variance() const { return std::max(0.0, second / mass - mean() * mean()); }
};

}  // namespace

void assign_attributes(Mixture& mixture, const TracedNodes& nodes) {
  const auto points = static_cast<std::size_t>(std::ceil(std::max(32.0, points_per_sigma * two_pi / nodes.blur_rad())));
  const Shares shares = blurred(responsibilities(mixture, points), nodes.blur_rad());
  const std::size_t uniform_part = mixture.component_count;
  std::array<Moments, Mixture::max_components + 1> moments;
  Moments all;
  for (std::size_t j = 0; j < nodes.size(); ++j) {
    const double at = (nodes.azimuth()[j] / two_pi + 0.5) * static_cast<double>(points);
    const auto left = static_cast<std::size_t>(std::max(at, 0.0));
    const double fraction = at - static_cast<double>(left);
    const std::size_t a = left % points, b = (left + 1) % points;
    const double weight = nodes.weight()[j];
    const double value = nodes.attribute()[j];
    all.add(weight, value);
    for (std::size_t d = 0; d < shares.parts; ++d) {
      const double from = shares.of(d)[a], to = shares.of(d)[b];
      moments[d].add(weight * (from + fraction * (to - from)), value);
    }
  }
  const auto told = [&](std::size_t d) { return moments[d].mass > 1e-9 * all.mass ? moments[d] : all; };
  for (std::size_t d = 0; d < mixture.component_count && all.mass > 0; ++d) {
    mixture.components[d].attribute_mean = static_cast<float>(told(d).mean());
    mixture.components[d].attribute_variance = static_cast<float>(told(d).variance());
  }
  if (all.mass > 0) {
    mixture.uniform_attribute_mean = static_cast<float>(told(uniform_part).mean());
    mixture.uniform_attribute_variance = static_cast<float>(told(uniform_part).variance());
  }
}

}  // namespace tress::adaptive
