#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/pi.h"
#include "fit/fit_mixture.h"
#include "fit/kernels.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double reach = 4;             // of the blur, in sigma: 6e-5 of it lies beyond
constexpr double points_per_sigma = 4;  // linear interpolation errs by less than 0.004 of a responsibility

/// Functions at equally spaced azimuths from -pi on, one function after the other.
struct Curves {
  std::size_t points = 0, parts = 0;
  std::vector<double> values;
  double* of(std::size_t part) { return values.data() + part * points; }
  const double* of(std::size_t part) const { return values.data() + part * points; }
};

/// Returns the shares of each component, then of the uniform part. points: a multiple of kernel_lanes.
Curves responsibilities(const Mixture& mixture, std::size_t points) {
  Curves shares{points, mixture.component_count + std::size_t{1}, {}};
  shares.values.resize(shares.parts * points);
  std::vector<double> azimuth(points), sum(points, mixture.uniform_weight / two_pi);
  for (std::size_t i = 0; i < points; ++i) {
    azimuth[i] = (static_cast<double>(i) / static_cast<double>(points) - 0.5) * two_pi;
  }
  const std::size_t uniform_part = mixture.component_count;
  std::copy(sum.begin(), sum.end(), shares.of(uniform_part));
  for (std::size_t d = 0; d < uniform_part; ++d) {
    const Component& part = mixture.components[d];
    const Shape shape(part.shape.mu, part.shape.s_left, part.shape.s_right);
    add_density(shape, part.weight, azimuth.data(), points, shares.of(d));
    for (std::size_t i = 0; i < points; ++i) sum[i] += shares.of(d)[i];
  }
  for (std::size_t i = 0; i < points; ++i) {
    if (!(sum[i] > 0)) shares.of(uniform_part)[i] = sum[i] = 1;
    sum[i] = 1 / sum[i];
  }
  for (std::size_t d = 0; d < shares.parts; ++d) {
    for (std::size_t i = 0; i < points; ++i) shares.of(d)[i] *= sum[i];
  }
  return shares;
}

/// Returns the curves blurred by the wrapped Gaussian of standard deviation `blur`.
Curves blurred(const Curves& sharp, double blur) {
  const double spacing = two_pi / static_cast<double>(sharp.points);
  const auto taps = static_cast<std::size_t>(std::ceil(reach * blur / spacing));
  std::vector<double> kernel(2 * taps + 1);
  double sum = 0;
  for (std::size_t k = 0; k < kernel.size(); ++k) {
    const double d = (static_cast<double>(k) - static_cast<double>(taps)) * spacing / blur;
    sum += kernel[k] = std::exp(-0.5 * d * d);
  }
  for (double& tap : kernel) tap /= sum;
  Curves smooth{sharp.points, sharp.parts, std::vector<double>(sharp.values.size())};
  std::vector<double> unrolled(sharp.points + 2 * taps);  // one curve, continued beyond -pi and pi
  for (std::size_t part = 0; part < sharp.parts; ++part) {
    for (std::size_t i = 0; i < unrolled.size(); ++i) {
      unrolled[i] = sharp.of(part)[(i + sharp.points * (1 + taps / sharp.points) - taps) % sharp.points];
    }
    blur_row(unrolled.data(), kernel.data(), kernel.size(), smooth.of(part), sharp.points);
  }
  return smooth;
}

struct AttributeMoments {
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
  const auto points =
      padded_size(static_cast<std::size_t>(std::ceil(std::max(32.0, points_per_sigma * two_pi / nodes.blur_rad()))));
  // Summing a blurred share over rays is the same as summing the share over blurred rays. That takes only three curves:
  // the sums of weight, weight x attribute and weight x attribute^2 at each azimuth.
  Curves rays{points, 3, std::vector<double>(3 * points)};
  AttributeMoments all;
  for (std::size_t j = 0; j < nodes.size(); ++j) {
    const double at = (nodes.azimuth()[j] / two_pi + 0.5) * static_cast<double>(points);
    const auto left = static_cast<std::size_t>(std::max(at, 0.0));
    const double fraction = at - static_cast<double>(left);
    const std::size_t a = left < points ? left : left - points, b = a + 1 < points ? a + 1 : 0;
    const double weight = nodes.weight()[j];
    const double value = nodes.attribute()[j];
    all.add(weight, value);
    double power = weight;
    for (std::size_t m = 0; m < rays.parts; ++m, power *= value) {
      rays.of(m)[a] += power * (1 - fraction);
      rays.of(m)[b] += power * fraction;
    }
  }
  rays = blurred(rays, nodes.blur_rad());
  const Curves shares = responsibilities(mixture, points);
  const std::size_t uniform_part = mixture.component_count;
  std::array<AttributeMoments, Mixture::max_components + 1> moments;
  for (std::size_t d = 0; d < shares.parts; ++d) {
    const double* share = shares.of(d);
    for (std::size_t i = 0; i < points; ++i) {
      moments[d].mass += share[i] * rays.of(0)[i];
      moments[d].first += share[i] * rays.of(1)[i];
      moments[d].second += share[i] * rays.of(2)[i];
    }
  }
  const auto known = [&](std::size_t d) { return moments[d].mass > 1e-9 * all.mass ? moments[d] : all; };
  for (std::size_t d = 0; d < mixture.component_count && all.mass > 0; ++d) {
    mixture.components[d].attribute_mean = static_cast<float>(known(d).mean());
    mixture.components[d].attribute_variance = static_cast<float>(known(d).variance());
  }
  if (all.mass > 0) {
    mixture.uniform_attribute_mean = static_cast<float>(known(uniform_part).mean());
    mixture.uniform_attribute_variance = static_cast<float>(known(uniform_part).variance());
  }
}

}  // namespace tress::inline v0_2::adaptive
