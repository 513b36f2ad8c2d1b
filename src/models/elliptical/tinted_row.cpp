#include "models/elliptical/tinted_row.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <memory>
#include <new>
#include <numbers>

namespace tress::fiber {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr float inverse_two_pi = 0.5f * std::numbers::inv_pi_v<float>;

float side_mass(float s) { return s * static_cast<float>(std::tanh(0.5 * std::numbers::pi / s)); }

constexpr std::uint32_t lanes = 4;

// Inverse CDF of one component, u in [0, 1): ESTIMATOR.md, E1. 2 s atanh(v T) = s ln((1 + v T)/(1 - v T)).
float sample_component(float mu, float inverse_left, float inverse_right, float u) {
  const Float4 e = exp_of_negative(-pi * Float4{inverse_left, inverse_right, 0, 0});
  const Float4 truncation = (1 - e) / (1 + e);            // tanh(pi / 2s)
  const float left_mass = truncation[0] * inverse_right;  // s T, times both 1/s
  const float right_mass = truncation[1] * inverse_left;
  const float p_left = left_mass / (left_mass + right_mass);
  const bool is_left = u < p_left;
  const float v = is_left ? 1 - u / p_left : std::min((u - p_left) / (1 - p_left), 1.0f);
  const float t = std::min(v * (is_left ? truncation[0] : truncation[1]), 0.99999994f);
  const float x = std::min(std::log((1 + t) / (1 - t)) / (is_left ? inverse_left : inverse_right), pi);
  return adaptive::wrap_angle(is_left ? mu - x : mu + x);
}

}  // namespace

double absorbed_share(double sigma_a, double path_mean, double path_variance) {
  if (sigma_a <= 0 || path_mean <= 0) return 1;
  const double spread = path_variance / path_mean;
  if (!(sigma_a * spread > 1e-6)) return std::exp(-sigma_a * path_mean);
  return std::exp(-path_mean / spread * std::log1p(sigma_a * spread));
}

RowValue TintedRow::evaluate(float x, const glm::vec3& channel_weights, float u_share) const {
  if (knot_count != 0) return evaluate_knots(x, channel_weights, u_share);
  Float4 red = splat(0), green = red, blue = red;
  const TintedParts* part = parts();
  for (std::uint32_t d = 0; d < count; d += lanes, ++part) {
    // The way round the circle that is shorter, negated, and whether it leads to the left.
    const Float4 offset = x - part->mu, straight = -abs4(offset), round = -2 * pi - straight;
    const Int4 is_left = (offset < 0.0f) ^ (straight < round);
    const Float4 e = exp_of_negative(max4(straight, round) * (is_left ? part->inverse_left : part->inverse_right));
    const Float4 bell = e / ((1 + e) * (1 + e));
    red += bell * part->amplitude[0];
    green += bell * part->amplitude[1];
    blue += bell * part->amplitude[2];
  }
  const Float4 shape =
      sums4(red, green, blue) + inverse_two_pi * Float4{uniform_share.x, uniform_share.y, uniform_share.z, 0};
  RowValue value;
  value.shape = {shape[0], shape[1], shape[2]};
  value.proposal = (1 - u_share) * glm::dot(channel_weights, value.shape) + u_share * inverse_two_pi;
  return value;
}

float TintedRow::sample(float u, const glm::vec3& channel_weights, float u_share) const {
  if (knot_count != 0) return sample_knots(u, channel_weights, u_share);
  float below = 0;  // probability of the components already passed
  const glm::vec3 mix = (1 - u_share) * channel_weights;
  const TintedParts* part = parts();
  for (std::uint32_t d = 0; d < count; d += lanes, ++part) {
    const Float4 shares =
        part->norm * (mix.x * part->amplitude[0] + mix.y * part->amplitude[1] + mix.z * part->amplitude[2]);
    for (std::uint32_t k = 0; k < std::min(count - d, lanes); ++k) {
      const float share = shares[k];
      if (u < below + share) {
        return sample_component(part->mu[k], part->inverse_left[k], part->inverse_right[k],
                                std::clamp((u - below) / share, 0.0f, 0.99999994f));
      }
      below += share;
    }
  }
  const float rest = std::max(1 - below, 1e-6f);
  return -pi + 2 * pi * std::clamp((u - below) / rest, 0.0f, 0.9999999f);
}

TintedRow* TintedRowPool::allocate(std::size_t bytes_behind) {
  const std::size_t lines = (sizeof(TintedRow) + bytes_behind) / sizeof(Line);
  const std::scoped_lock lock(mutex_);
  if (used_lines_ + lines > chunk_lines) {
    chunks_.push_back(std::make_unique<Line[]>(chunk_lines));
    used_lines_ = 0;
  }
  Line* block = chunks_.back().get() + used_lines_;
  used_lines_ += lines;
  return new (block) TintedRow;
}

std::size_t TintedRowPool::bytes() const {
  const std::scoped_lock lock(mutex_);
  return chunks_.size() * chunk_lines * sizeof(Line);
}

const TintedRow* TintedRowPool::make(const adaptive::Mixture& fit, float objective, const glm::vec3& sigma_a) {
  const std::size_t blocks = (fit.component_count + lanes - 1) / lanes;
  TintedRow* row = allocate(blocks * sizeof(TintedParts));
  std::uninitialized_fill_n(row->parts(), blocks, TintedParts{});
  row->count = fit.component_count;
  row->objective = objective;
  std::array<double, 3> mass{};
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    mass[channel] = std::max(0.0f, fit.uniform_weight) *
                    absorbed_share(sigma_a[c], fit.uniform_attribute_mean, fit.uniform_attribute_variance);
    row->uniform_share[c] = static_cast<float>(mass[channel]);
  }
  std::array<std::array<double, 3>, adaptive::Mixture::max_components> shares{};
  for (std::uint32_t d = 0; d < row->count; ++d) {
    const adaptive::Component& part = fit.components[d];
    TintedParts& parts = row->parts()[d / lanes];
    const std::uint32_t k = d % lanes;
    parts.mu[k] = part.shape.mu;
    parts.inverse_left[k] = 1 / part.shape.s_left;
    parts.inverse_right[k] = 1 / part.shape.s_right;
    parts.norm[k] = 0.5f * (side_mass(part.shape.s_left) + side_mass(part.shape.s_right));
    for (std::size_t c = 0; c < 3; ++c) {
      const float sigma = sigma_a[static_cast<int>(c)];
      shares[d][c] = part.weight * absorbed_share(sigma, part.attribute_mean, part.attribute_variance);
      mass[c] += shares[d][c];
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const bool dark = !(mass[c] > 1e-30);  // no light is left in this channel: its shape does not matter
    float& uniform = row->uniform_share[static_cast<int>(c)];
    uniform = dark ? 1.0f : static_cast<float>(uniform / mass[c]);
    if (dark) continue;
    for (std::uint32_t d = 0; d < row->count; ++d) {
      TintedParts& parts = row->parts()[d / lanes];
      const std::uint32_t k = d % lanes;
      parts.amplitude[c][k] = static_cast<float>(shares[d][c] / mass[c]) / parts.norm[k];
    }
  }
  return row;
}

}  // namespace tress::fiber
