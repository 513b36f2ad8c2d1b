#include "models/elliptical/ray_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "base/exp_of_negative.h"
#include "base/normal_quantile.h"
#include "base/pi.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float two_pi = 2 * pi_f;
constexpr float reach = 6.0f;      // in standard deviations: less than 2e-9 of the mass lies beyond
constexpr std::size_t chunk = 64;  // terms evaluated before they are summed
constexpr std::size_t lanes = 8;

// Sums as a tree in a fixed order: it vectorises without reassociation, so every compiler flag gives the same bits.
float sum_chunk(float* term, std::size_t filled) {
  const std::size_t padded = (filled + lanes - 1) / lanes * lanes;
  for (std::size_t i = filled; i < padded; ++i) term[i] = 0;
  for (std::size_t row = lanes; row < padded; row += lanes) {
    for (std::size_t i = 0; i < lanes; ++i) term[i] += term[row + i];
  }
  return padded == 0 ? 0.0f : ((term[0] + term[4]) + (term[1] + term[5])) + ((term[2] + term[6]) + (term[3] + term[7]));
}

bool is_clear(const glm::vec3& sigma_a) { return sigma_a.x == 0 && sigma_a.y == 0 && sigma_a.z == 0; }

// Adds the rays [first, last), by the distance to the nearest image, and to the next image too if the blur reaches it.
void add_density(const RayShape& rays, std::size_t first, std::size_t last, const glm::vec3& sigma_a, float x,
                 ClearAndAbsorbed& sum) {
  const float precision = 0.5f / (rays.blur_rad * rays.blur_rad);
  const bool next_image = rays.blur_rad * reach > pi_f;
  const bool clear = is_clear(sigma_a);
  for (std::size_t start = first; start < last; start += chunk) {
    const std::size_t filled = std::min(chunk, last - start);
    const float* azimuth = rays.azimuth.data() + start;
    const float* weight = rays.weight.data() + start;
    const float* path = rays.attribute.data() + start;
    alignas(32) std::array<float, chunk> blurred, term;
    for (std::size_t i = 0; i < filled; ++i) {
      float d = std::fabs(azimuth[i] - x);
      d = d > pi_f ? two_pi - d : d;
      blurred[i] = weight[i] * exp_of_negative(-d * d * precision);
    }
    if (next_image) {
      for (std::size_t i = 0; i < filled; ++i) {
        float d = std::fabs(azimuth[i] - x);
        d = d > pi_f ? d : two_pi - d;
        blurred[i] += weight[i] * exp_of_negative(-d * d * precision);
      }
    }
    if (!clear) {
      for (int c = 0; c < 3; ++c) {
        const float absorption = sigma_a[c];
        for (std::size_t i = 0; i < filled; ++i) term[i] = blurred[i] * exp_of_negative(-absorption * path[i]);
        sum.absorbed[c] += sum_chunk(term.data(), filled);
      }
    }
    sum.clear += sum_chunk(blurred.data(), filled);
  }
}

}  // namespace

ClearAndAbsorbed ray_mass(const RayShape& rays, const glm::vec3& sigma_a) {
  ClearAndAbsorbed sum;
  const bool clear = is_clear(sigma_a);
  for (std::size_t start = 0; start < rays.weight.size(); start += chunk) {
    const std::size_t filled = std::min(chunk, rays.weight.size() - start);
    const float* weight = rays.weight.data() + start;
    const float* path = rays.attribute.data() + start;
    alignas(32) std::array<float, chunk> term;
    for (int c = 0; c < 3 && !clear; ++c) {
      const float absorption = sigma_a[c];
      for (std::size_t i = 0; i < filled; ++i) term[i] = weight[i] * exp_of_negative(-absorption * path[i]);
      sum.absorbed[c] += sum_chunk(term.data(), filled);
    }
    std::copy_n(weight, filled, term.begin());
    sum.clear += sum_chunk(term.data(), filled);
  }
  if (clear) sum.absorbed = glm::vec3(sum.clear);
  return sum;
}

ClearAndAbsorbed ray_density(const RayShape& rays, const glm::vec3& sigma_a, float x) {
  ClearAndAbsorbed sum;
  const float width = reach * rays.blur_rad;
  const std::size_t count = rays.azimuth.size();
  if (!rays.sorted || width >= 0.75f * pi_f) {
    add_density(rays, 0, count, sigma_a, x, sum);
  } else {
    const auto index = [&](float azimuth) {
      return static_cast<std::size_t>(std::ranges::lower_bound(rays.azimuth, azimuth) - rays.azimuth.begin());
    };
    const float low = x - width, high = x + width;
    add_density(rays, index(low), index(high), sigma_a, x, sum);
    if (low < -pi_f) add_density(rays, index(low + two_pi), count, sigma_a, x, sum);
    if (high > pi_f) add_density(rays, 0, index(high - two_pi), sigma_a, x, sum);
  }
  const float norm = 0.398942280f / rays.blur_rad;
  sum.clear *= norm;
  sum.absorbed = is_clear(sigma_a) ? glm::vec3(sum.clear) : sum.absorbed * norm;
  return sum;
}

float draw_azimuth(const RayShape& rays, float sigma_a, float mass, float u_ray, float u_blur) {
  const float target = u_ray * mass;
  float sum = 0;
  std::size_t chosen = 0;
  for (std::size_t j = 0; j < rays.weight.size(); ++j) {
    const float weight = rays.weight[j] * exp_of_negative(-sigma_a * rays.attribute[j]);
    if (weight > 0) chosen = j;
    sum += weight;
    if (sum > target) break;
  }
  if (rays.weight.empty()) return -pi_f + two_pi * u_ray;
  return adaptive::wrap_angle(rays.azimuth[chosen] + rays.blur_rad * normal_quantile(u_blur));
}

}  // namespace tress::inline v0_2::fiber
