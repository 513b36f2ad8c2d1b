// A knot table for one color: straight lines between knots in three channels, inverted under any mix of the channels.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <new>
#include <numbers>
#include <span>

#include "models/elliptical/absorbed_row.h"
#include "tress/adaptive/knot_density.h"
#include "tress/adaptive/mixture.h"

namespace tress::fiber {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr float inverse_two_pi = 0.5f * std::numbers::inv_pi_v<float>;
constexpr float below_one = 0.99999994f;
constexpr std::size_t block_size = 4;

/// All knots of a row, one after the other.
const Float4* knot_lanes(const AbsorbedRow& row) { return reinterpret_cast<const Float4*>(row.knots()); }

}  // namespace

RowValue AbsorbedRow::evaluate_knots(float x, const glm::vec3& channel_weights, float u_share) const {
  const std::uint32_t count = knot_count();
  const float at = std::max((x + pi) * (static_cast<float>(count) * inverse_two_pi), 0.0f);
  const std::uint32_t k = std::min(static_cast<std::uint32_t>(at), count - 1);
  const Float4* knot = knot_lanes(*this);
  const Float4 from = knot[k], to = knot[(k + 1) & (count - 1)];
  const Float4 shape = from + (at - static_cast<float>(k)) * (to - from);
  RowValue value;
  value.shape = {shape[0], shape[1], shape[2]};
  value.proposal = (1 - u_share) * glm::dot(channel_weights, value.shape) + u_share * inverse_two_pi;
  return value;
}

float AbsorbedRow::sample_knots(float u, const glm::vec3& channel_weights, float u_share) const {
  const float v = u / (1 - u_share);
  if (!(v < 1)) return -pi + 2 * pi * std::clamp((u - (1 - u_share)) / std::max(u_share, 1e-6f), 0.0f, 0.9999999f);
  const auto mixed = [&](const Float4& density) {
    return channel_weights.x * density[0] + channel_weights.y * density[1] + channel_weights.z * density[2];
  };
  const auto below = [&](const AbsorbedKnots& block) {
    return channel_weights.x * block.knot[0][3] + channel_weights.y * block.knot[1][3] +
           channel_weights.z * block.knot[2][3];
  };
  const std::uint32_t count = knot_count();
  const AbsorbedKnots* block = knots();
  for (std::uint32_t step = count / block_size / 2; step != 0; step /= 2) {
    if (below(block[step]) <= v) block += step;
  }
  const auto first = static_cast<std::uint32_t>(block - knots()) * static_cast<std::uint32_t>(block_size);
  const Float4* knot = knot_lanes(*this);
  const float h = 2 * pi / static_cast<float>(count);
  float left = (v - below(*block)) * (2 / h);  // twice the mass still to be passed over, in densities
  float from = mixed(knot[first]);
  std::uint32_t k = first;
  for (;; ++k) {
    const float to = mixed(knot[(k + 1) & (count - 1)]);
    if (left < from + to || k + 1 == first + block_size) {
      const float r = from + to > 0 ? std::clamp(left / (from + to), 0.0f, below_one) : 0.5f;
      return adaptive::wrap_angle(-pi + h * (static_cast<float>(k) + adaptive::invert_line(from, to, r)));
    }
    left -= from + to;
    from = to;
  }
}

std::size_t absorbed_bytes(const adaptive::KnotDensity& table) {
  return sizeof(AbsorbedRow) + table.knots().size() / block_size * sizeof(AbsorbedKnots);
}

const AbsorbedRow* put_absorbed(const adaptive::KnotDensity& table, float objective, const glm::vec3& sigma_a,
                                void* memory) {
  const std::span<const adaptive::Knot> knots = table.knots();
  const std::size_t count = knots.size();
  const std::size_t blocks = count / block_size;
  AbsorbedRow* row = new_absorbed(memory, blocks, objective,
                                  AbsorbedRow::has_knots | static_cast<std::uint32_t>(std::countr_zero(count)));
  for (std::size_t k = 0; k < blocks; ++k) new (row + 1 + k) AbsorbedKnots;
  const double h = 2 * std::numbers::pi / static_cast<double>(count);
  std::array<double, adaptive::KnotDensity::most> density{};
  for (std::size_t c = 0; c < 3; ++c) {
    const float sigma = sigma_a[static_cast<int>(c)];
    double mass = 0;
    for (std::size_t k = 0; k < count; ++k) {
      density[k] =
          knots[k].density * adaptive::decayed_share(sigma, knots[k].attribute_mean, knots[k].attribute_variance);
      mass += h * density[k];
    }
    const bool dark = !(mass > 1e-30);  // this channel has no light left, so its shape does not matter
    double below = 0;
    for (std::size_t k = 0; k < count; ++k) {
      density[k] = dark ? 0.5 * std::numbers::inv_pi : density[k] / mass;
      std::array<Float4, block_size>& block = row->knots()[k / block_size].knot;
      block[k % block_size][c] = static_cast<float>(density[k]);
      if (k > 0) below += 0.5 * h * (density[k - 1] + density[k]);
      if (k % block_size == 0) block[c][3] = static_cast<float>(below);
    }
  }
  return row;
}

}  // namespace tress::fiber
