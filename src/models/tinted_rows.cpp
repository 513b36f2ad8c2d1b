#include "models/tinted_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "tress/adaptive/exp_of_negative.h"

namespace tress::fiber {
namespace {
constexpr float pi = std::numbers::pi_v<float>;
constexpr float inverse_two_pi = 0.5f * std::numbers::inv_pi_v<float>;

float side_mass(float s) { return s * static_cast<float>(std::tanh(0.5 * std::numbers::pi / s)); }
}  // namespace

double absorbed_share(double sigma_a, double path_mean, double path_variance) {
  if (sigma_a <= 0 || path_mean <= 0) return 1;
  const double spread = path_variance / path_mean;
  if (!(sigma_a * spread > 1e-6)) return std::exp(-sigma_a * path_mean);
  return std::exp(-path_mean / spread * std::log1p(sigma_a * spread));
}

void TintedRows::set(std::uint32_t node, const adaptive::Mixture& fit, const glm::vec3& sigma_a) {
  TintedRow row;
  row.first = static_cast<std::uint32_t>(components_.size());
  std::array<double, 3> mass{};
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    mass[channel] = std::max(0.0f, fit.uniform_weight) *
                    absorbed_share(sigma_a[c], fit.uniform_attribute_mean, fit.uniform_attribute_variance);
    row.uniform_share[c] = static_cast<float>(mass[channel]);
  }
  for (const adaptive::Component& part : fit.parts()) {
    const adaptive::SkewLogistic& shape = part.shape;
    TintedComponent component{shape.mu,          1 / shape.s_left,
                              1 / shape.s_right, 2 / (side_mass(shape.s_left) + side_mass(shape.s_right)),
                              glm::vec3(0),      0};
    for (int c = 0; c < 3; ++c) {
      const double share = part.weight * absorbed_share(sigma_a[c], part.attribute_mean, part.attribute_variance);
      component.share[c] = static_cast<float>(share);
      mass[static_cast<std::size_t>(c)] += share;
    }
    components_.push_back(component);
    ++row.count;
  }
  for (int c = 0; c < 3; ++c) {
    const double total = mass[static_cast<std::size_t>(c)];
    const bool dark = !(total > 1e-30);  // no light is left in this channel: its shape does not matter
    row.uniform_share[c] = dark ? 1.0f : static_cast<float>(row.uniform_share[c] / total);
    for (std::uint32_t d = 0; d < row.count; ++d) {
      float& share = components_[row.first + d].share[c];
      share = dark ? 0.0f : static_cast<float>(share / total);
    }
  }
  slot_[node] = static_cast<std::uint32_t>(rows_.size());
  rows_.push_back(row);
}

RowValue TintedRows::evaluate(std::uint32_t node, float x, const glm::vec3& channel_weights,
                              float uniform_share) const {
  const TintedRow& row = rows_[slot_[node]];
  RowValue value;
  value.shape = row.uniform_share * inverse_two_pi;
  const TintedComponent* part = components_.data() + row.first;
  for (std::uint32_t d = 0; d < row.count; ++d, ++part) {
    float offset = x - part->mu;
    offset = offset >= pi ? offset - 2 * pi : offset < -pi ? offset + 2 * pi : offset;
    const float inverse = offset < 0 ? part->inverse_left : part->inverse_right;
    const float e = adaptive::exp_of_negative(-std::fabs(offset) * inverse);
    value.shape += part->share * (e / ((1 + e) * (1 + e)) * part->inverse_norm);
  }
  value.proposal = (1 - uniform_share) * glm::dot(channel_weights, value.shape) + uniform_share * inverse_two_pi;
  return value;
}

float TintedRows::sample(std::uint32_t node, float u, const glm::vec3& channel_weights, float uniform_share) const {
  const TintedRow& row = rows_[slot_[node]];
  float below = 0;  // probability of the parts already passed
  for (std::uint32_t d = 0; d < row.count; ++d) {
    const TintedComponent& part = components_[row.first + d];
    const float share = (1 - uniform_share) * glm::dot(channel_weights, part.share);
    if (u < below + share) {
      const adaptive::SkewLogistic shape{part.mu, 1 / part.inverse_left, 1 / part.inverse_right};
      return shape.sample(std::clamp((u - below) / share, 0.0f, 0.99999994f));
    }
    below += share;
  }
  const float rest = std::max(1 - below, 1e-6f);
  return -pi + 2 * pi * std::clamp((u - below) / rest, 0.0f, 0.9999999f);
}

}  // namespace tress::fiber
