#include "tress/adaptive/traced_nodes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tress/adaptive/exp_of_negative.h"
#include "tress/adaptive/mixture.h"

namespace tress::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr float two_pi = 2 * std::numbers::pi_v<float>;
constexpr float reach = 6.0f;       // in sigma: what lies beyond is under 2e-9 of the mass
constexpr std::size_t chunk = 64;   // terms evaluated before they are summed
constexpr float narrowest = 1e-5f;  // radians

// Sum over [0, count) of weight exp(-(azimuth - x)^2 half_precision). The terms first, then a tree of sums: both loops
// vectorise without reassociation of floats, so every compiler flag gives the same order.
float gaussian_sum(const float* azimuth, const float* weight, std::size_t count, float x, float half_precision) {
  float total = 0;
  float term[chunk];
  for (std::size_t start = 0; start < count; start += chunk) {
    const std::size_t filled = std::min(chunk, count - start);
    const std::size_t padded = (filled + 7) / 8 * 8;
    for (std::size_t i = filled; i < padded; ++i) term[i] = 0;
    for (std::size_t i = 0; i < filled; ++i) {
      const float d = azimuth[start + i] - x;
      term[i] = weight[start + i] * exp_of_negative(-d * d * half_precision);
    }
    for (std::size_t row = 8; row < padded; row += 8) {
      for (std::size_t i = 0; i < 8; ++i) term[i] += term[row + i];
    }
    total += ((term[0] + term[4]) + (term[1] + term[5])) + ((term[2] + term[6]) + (term[3] + term[7]));
  }
  return total;
}

}  // namespace

TracedNodes::TracedNodes(std::span<const TracedRay> rays, float blur_rad) : blur_rad_(std::max(blur_rad, narrowest)) {
  struct Wrapped {
    float azimuth;
    std::size_t ray;
  };
  std::vector<Wrapped> kept;
  kept.reserve(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (rays[i].weight > 0) kept.push_back({wrap_angle(rays[i].azimuth), i});
  }
  std::ranges::sort(kept, [](const Wrapped& a, const Wrapped& b) {
    return a.azimuth != b.azimuth ? a.azimuth < b.azimuth : a.ray < b.ray;
  });
  azimuth_.reserve(kept.size());
  weight_.reserve(kept.size());
  attribute_.reserve(kept.size());
  double mass = 0;
  for (const Wrapped& one : kept) {
    azimuth_.push_back(one.azimuth);
    weight_.push_back(rays[one.ray].weight);
    attribute_.push_back(rays[one.ray].attribute);
    mass += rays[one.ray].weight;
  }
  energy_ = static_cast<float>(mass);

  // Trapezoid on a circle: exact but for the harmonics of g^2 beyond the spacing, exp(-(9)^2/4) = 2e-9 of g's own.
  const auto points = std::max(32, static_cast<int>(std::ceil(9 / blur_rad_)));
  const double mean = mass / (2 * pi);
  double sum = 0;
  for (int i = 0; i < points && !azimuth_.empty(); ++i) {
    const double g = density(static_cast<float>(-pi + 2 * pi * i / points));
    sum += (g - mean) * (g - mean);
  }
  variation_ = static_cast<float>(std::max(sum * 2 * pi / points, 1e-3 / (2 * pi)));
}

float TracedNodes::density(float x) const {
  x = wrap_angle(x);
  const float width = reach * blur_rad_;
  const float half_precision = 0.5f / (blur_rad_ * blur_rad_);
  const int turns = static_cast<int>(1 + width / two_pi);
  float sum = 0;
  for (int turn = -turns; turn <= turns; ++turn) {
    const float centre = x + static_cast<float>(turn) * two_pi;
    if (centre + width < -two_pi / 2 || centre - width > two_pi / 2) continue;
    const auto first = std::ranges::lower_bound(azimuth_, centre - width);
    const auto last = std::upper_bound(first, azimuth_.end(), centre + width);
    const auto offset = static_cast<std::size_t>(first - azimuth_.begin());
    sum += gaussian_sum(azimuth_.data() + offset, weight_.data() + offset, static_cast<std::size_t>(last - first),
                        centre, half_precision);
  }
  constexpr float inverse_sqrt_two_pi = 0.398942280f;
  return sum * inverse_sqrt_two_pi / blur_rad_;
}

float wrapped_gaussian(float x, float sigma) {
  const double s = std::max(sigma, narrowest);
  const double centre = wrap_angle(x);
  const int turns = static_cast<int>(1 + 8 * s / (2 * pi));
  double sum = 0;
  for (int turn = -turns; turn <= turns; ++turn) {
    const double d = (centre + 2 * pi * turn) / s;
    sum += std::exp(-0.5 * d * d);
  }
  return static_cast<float>(sum / (s * std::sqrt(2 * pi)));
}

}  // namespace tress::adaptive
