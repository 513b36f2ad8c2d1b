#include "tress/adaptive/traced_nodes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "base/pi.h"
#include "density/blurred_sum.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr float reach = 5.5f;                    // in sigma: less than 4e-8 of the mass lies beyond
constexpr float narrowest = 1e-5f, widest = 10;  // radians
constexpr float heaviest = 1e12f;                // so that densities and their squares are finite
constexpr float most_buckets = 1024;

// Returns 32 bits that sort as the float does.
std::uint64_t ascending_bits(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x + 0.0f);
  return (bits & 0x80000000u) != 0 ? static_cast<std::uint32_t>(~bits) : bits | 0x80000000u;
}

}  // namespace

TracedNodes::TracedNodes(std::span<const TracedRay> rays, float blur_rad)
    : blur_rad_(blur_rad > narrowest ? std::min(blur_rad, widest) : narrowest),
      precision_(0.5f / (blur_rad_ * blur_rad_)),
      peak_(0.398942280f / blur_rad_) {
  std::vector<std::uint64_t> order;  // by ascending azimuth, then by ascending index
  order.reserve(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (rays[i].weight > 0 && std::isfinite(rays[i].weight))
      order.push_back(ascending_bits(wrap_angle(rays[i].azimuth)) << 32 | i);
  }
  std::ranges::sort(order);
  azimuth_.resize(order.size() + blurred_sum_padding);
  weight_.resize(order.size() + blurred_sum_padding);
  attribute_.resize(order.size());
  double mass = 0;
  for (std::size_t j = 0; j < order.size(); ++j) {
    const TracedRay& ray = rays[order[j] & 0xffffffffu];
    azimuth_[j] = wrap_angle(ray.azimuth);
    weight_[j] = std::min(ray.weight, heaviest);
    attribute_[j] = ray.attribute;
    mass += weight_[j];
  }
  energy_ = static_cast<float>(mass);

  const auto buckets = static_cast<std::uint32_t>(std::clamp(two_pi_f / blur_rad_, 1.0f, most_buckets));
  buckets_per_rad_ = static_cast<float>(buckets) / two_pi_f;
  starts_.assign(buckets + 1, 0);
  for (const float azimuth : this->azimuth()) ++starts_[bucket_of(azimuth) + 1];
  std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());

  // The trapezoidal rule on a circle errs by the harmonics of g^2 from K = `points` on. Those are below exp(-(K
  // sigma)^2/4) of its mass, 3e-5.
  const auto points = std::max(32, static_cast<int>(std::ceil(6.5 / blur_rad_)));
  grid_.assign(static_cast<std::size_t>(points), 0.0f);
  const double mean = mass / (2 * pi);
  double sum = 0;
  for (int i = 0; i < points && size() > 0; ++i) {
    const double g = grid_[static_cast<std::size_t>(i)] = density(static_cast<float>(-pi + 2 * pi * i / points));
    sum += (g - mean) * (g - mean);
  }
  variation_ = static_cast<float>(std::max(sum * 2 * pi / points, 1e-3 / (2 * pi)));
}

std::uint32_t TracedNodes::bucket_of(float azimuth) const {
  const float at = std::max((azimuth + two_pi_f / 2) * buckets_per_rad_, 0.0f);
  return std::min(static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(starts_.size() - 2));
}

std::size_t TracedNodes::bytes() const {
  return sizeof(*this) + sizeof(float) * (azimuth_.size() + weight_.size() + attribute_.size() + grid_.size()) +
         sizeof(std::uint32_t) * starts_.size();
}

// Sums the rays from the first bucket within reach to the end of the last one: a few more than needed, but none has to
// be searched for.
float TracedNodes::density(float x) const {
  if (starts_.empty()) return 0;  // moved from
  x = wrap_angle(x);
  const float width = reach * blur_rad_;
  const int turns = static_cast<int>(1 + width * (1 / two_pi_f));
  float sum = 0;
  for (int turn = -turns; turn <= turns; ++turn) {
    const float centre = x + static_cast<float>(turn) * two_pi_f;
    const float low = centre - width, high = centre + width;
    if (high < -two_pi_f / 2 || low > two_pi_f / 2) continue;
    const std::uint32_t first = starts_[bucket_of(low)], last = starts_[bucket_of(high) + 1];
    sum += blurred_sum(azimuth_.data() + first, weight_.data() + first, last - first, centre, precision_);
  }
  return sum * peak_;
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

}  // namespace tress::inline v0_2::adaptive
