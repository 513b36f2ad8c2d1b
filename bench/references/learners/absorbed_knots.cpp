#include "references/learners/absorbed_knots.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>

#include "base/pi.h"
#include "density/invert_line.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float below_one = 0.99999994f;

}  // namespace

RowValue AbsorbedKnots::evaluate(float x, const glm::vec3& channel_weights, float u_share) const {
  const float at = std::max((x + pi_f) * (static_cast<float>(count_) * inverse_two_pi_f), 0.0f);
  const std::uint32_t k = std::min(static_cast<std::uint32_t>(at), count_ - 1);
  const Float4 from = knots()[k], to = knots()[(k + 1) & (count_ - 1)];
  const Float4 shape = from + (at - static_cast<float>(k)) * (to - from);
  RowValue value;
  value.shape = {shape[0], shape[1], shape[2]};
  value.proposal = (1 - u_share) * glm::dot(channel_weights, value.shape) + u_share * inverse_two_pi_f;
  return value;
}

float AbsorbedKnots::sample(float u, const glm::vec3& channel_weights, float u_share) const {
  const float v = u / (1 - u_share);
  if (!(v < 1)) return -pi_f + 2 * pi_f * std::clamp((u - (1 - u_share)) / std::max(u_share, 1e-6f), 0.0f, 0.9999999f);
  const auto mixed = [&](const Float4& density) {
    return channel_weights.x * density[0] + channel_weights.y * density[1] + channel_weights.z * density[2];
  };
  const auto below = [&](const Block& block) {
    return channel_weights.x * block.knot[0][3] + channel_weights.y * block.knot[1][3] +
           channel_weights.z * block.knot[2][3];
  };
  const Block* block = blocks_.data();
  for (std::size_t step = blocks_.size() / 2; step != 0; step /= 2) {
    if (below(block[step]) <= v) block += step;
  }
  const auto first = static_cast<std::uint32_t>(block - blocks_.data()) * static_cast<std::uint32_t>(block_size);
  const float h = 2 * pi_f / static_cast<float>(count_);
  float left = (v - below(*block)) * (2 / h);  // twice the mass still to be passed over, in densities
  float from = mixed(knots()[first]);
  for (std::uint32_t k = first;; ++k) {
    const float to = mixed(knots()[(k + 1) & (count_ - 1)]);
    if (left < from + to || k + 1 == first + block_size) {
      const float r = from + to > 0 ? std::clamp(left / (from + to), 0.0f, below_one) : 0.5f;
      return adaptive::wrap_angle(-pi_f + h * (static_cast<float>(k) + adaptive::invert_line(from, to, r)));
    }
    left -= from + to;
    from = to;
  }
}

AbsorbedKnots::AbsorbedKnots(const adaptive::KnotDensity& table, const glm::vec3& sigma_a)
    : blocks_(table.knots().size() / block_size), count_(static_cast<std::uint32_t>(table.knots().size())) {
  const std::span<const adaptive::Knot> knots = table.knots();
  const double h = 2 * std::numbers::pi / static_cast<double>(count_);
  std::array<double, adaptive::KnotDensity::most> density{};
  for (std::size_t c = 0; c < 3; ++c) {
    const float sigma = sigma_a[static_cast<int>(c)];
    double mass = 0;
    for (std::size_t k = 0; k < count_; ++k) {
      density[k] =
          knots[k].density * adaptive::decayed_share(sigma, knots[k].attribute_mean, knots[k].attribute_variance);
      mass += h * density[k];
    }
    const bool dark = !(mass > 1e-30);  // this channel has no light left, so its shape does not matter
    double below = 0;
    for (std::size_t k = 0; k < count_; ++k) {
      density[k] = dark ? 0.5 * std::numbers::inv_pi : density[k] / mass;
      std::array<Float4, block_size>& block = blocks_[k / block_size].knot;
      block[k % block_size][c] = static_cast<float>(density[k]);
      if (k > 0) below += 0.5 * h * (density[k - 1] + density[k]);
      if (k % block_size == 0) block[c][3] = static_cast<float>(below);
    }
  }
}

}  // namespace tress::inline v0_2::fiber
