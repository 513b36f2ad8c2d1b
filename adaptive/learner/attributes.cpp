#include <algorithm>
#include <cmath>
#include <numbers>

#include "learner/learner.h"

namespace tress::adaptive {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;
constexpr std::size_t uniform_part = Mixture::max_components;
using Responsibilities = std::array<double, Mixture::max_components + 1>;

Responsibilities at_azimuth(const Mixture& mixture, float x) {
  Responsibilities shares{};
  double sum = shares[uniform_part] = mixture.uniform_weight / two_pi;
  for (std::size_t d = 0; d < mixture.component_count; ++d) {
    shares[d] = mixture.components[d].weight * mixture.components[d].shape.density(x);
    sum += shares[d];
  }
  if (!(sum > 0)) {
    shares[uniform_part] = 1;
    return shares;
  }
  for (double& share : shares) share /= sum;
  return shares;
}

// Responsibilities on a grid over the circle, blurred by the wrapped Gaussian.
std::vector<Responsibilities> blurred(const Mixture& mixture, double blur, std::size_t points) {
  std::vector<Responsibilities> sharp(points), smooth(points);
  for (std::size_t i = 0; i < points; ++i) {
    sharp[i] =
        at_azimuth(mixture, static_cast<float>((static_cast<double>(i) / static_cast<double>(points) - 0.5) * two_pi));
  }
  const double spacing = two_pi / static_cast<double>(points);
  const auto reach = static_cast<int>(std::ceil(5 * blur / spacing));
  std::vector<double> kernel(static_cast<std::size_t>(2 * reach + 1));
  double sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double d = k * spacing / blur;
    sum += kernel[static_cast<std::size_t>(k + reach)] = std::exp(-0.5 * d * d);
  }
  const auto n = static_cast<int>(points);
  for (int i = 0; i < n; ++i) {
    for (int k = -reach; k <= reach; ++k) {
      const double tap = kernel[static_cast<std::size_t>(k + reach)] / sum;
      const Responsibilities& from = sharp[static_cast<std::size_t>(((i + k) % n + n) % n)];
      for (std::size_t d = 0; d < from.size(); ++d) smooth[static_cast<std::size_t>(i)][d] += tap * from[d];
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
  // A quarter of sigma between grid points: linear interpolation errs by under .002 of a responsibility.
  const auto points = static_cast<std::size_t>(std::ceil(std::max(32.0, 4 * two_pi / nodes.blur_rad())));
  const std::vector<Responsibilities> shares = blurred(mixture, nodes.blur_rad(), points);
  std::array<Moments, Mixture::max_components + 1> moments;
  Moments all;
  for (std::size_t j = 0; j < nodes.size(); ++j) {
    const double at = (nodes.azimuth()[j] / two_pi + 0.5) * static_cast<double>(points);
    const double floor = std::floor(at);
    const double fraction = at - floor;
    const auto left = static_cast<std::size_t>(std::max(floor, 0.0)) % points;
    const Responsibilities& a = shares[left];
    const Responsibilities& b = shares[(left + 1) % points];
    const double weight = nodes.weight()[j];
    const double value = nodes.attribute()[j];
    all.add(weight, value);
    for (std::size_t d = 0; d < moments.size(); ++d) {
      moments[d].add(weight * (a[d] + fraction * (b[d] - a[d])), value);
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
