#include "models/tinted_row.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <new>
#include <numbers>

#include "tress/adaptive/exp_of_negative.h"

namespace tress::fiber {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr float inverse_two_pi = 0.5f * std::numbers::inv_pi_v<float>;

float side_mass(float s) { return s * static_cast<float>(std::tanh(0.5 * std::numbers::pi / s)); }

// Inverse CDF of one component, u in [0, 1): ESTIMATOR.md, E1. 2 s atanh(v T) = s ln((1 + v T)/(1 - v T)).
float sample_component(const TintedComponent& part, float u) {
  const auto truncation = [](float inverse) {  // tanh(pi / 2s)
    const float e = adaptive::exp_of_negative(-pi * inverse);
    return (1 - e) / (1 + e);
  };
  const float left = truncation(part.inverse_left), right = truncation(part.inverse_right);
  const float left_mass = left * part.inverse_right, right_mass = right * part.inverse_left;  // s T, times both 1/s
  const float p_left = left_mass / (left_mass + right_mass);
  const bool is_left = u < p_left;
  const float v = is_left ? 1 - u / p_left : std::min((u - p_left) / (1 - p_left), 1.0f);
  const float t = std::min(v * (is_left ? left : right), 0.99999994f);
  const float x = std::min(std::log((1 + t) / (1 - t)) / (is_left ? part.inverse_left : part.inverse_right), pi);
  return adaptive::wrap_angle(is_left ? part.mu - x : part.mu + x);
}

}  // namespace

double absorbed_share(double sigma_a, double path_mean, double path_variance) {
  if (sigma_a <= 0 || path_mean <= 0) return 1;
  const double spread = path_variance / path_mean;
  if (!(sigma_a * spread > 1e-6)) return std::exp(-sigma_a * path_mean);
  return std::exp(-path_mean / spread * std::log1p(sigma_a * spread));
}

RowValue TintedRow::evaluate(float x, const glm::vec3& channel_weights, float u_share) const {
  RowValue value;
  value.shape = uniform_share * inverse_two_pi;
  const TintedComponent* part = parts();
  for (std::uint32_t d = 0; d < count; ++d, ++part) {
    float offset = x - part->mu;
    offset = offset >= pi ? offset - 2 * pi : offset < -pi ? offset + 2 * pi : offset;
    const float inverse = offset < 0 ? part->inverse_left : part->inverse_right;
    const float e = adaptive::exp_of_negative(-std::fabs(offset) * inverse);
    value.shape += part->share * (e / ((1 + e) * (1 + e)) * part->inverse_norm);
  }
  value.proposal = (1 - u_share) * glm::dot(channel_weights, value.shape) + u_share * inverse_two_pi;
  return value;
}

float TintedRow::sample(float u, const glm::vec3& channel_weights, float u_share) const {
  float below = 0;  // probability of the parts already passed
  const TintedComponent* part = parts();
  for (std::uint32_t d = 0; d < count; ++d, ++part) {
    const float share = (1 - u_share) * glm::dot(channel_weights, part->share);
    if (u < below + share) return sample_component(*part, std::clamp((u - below) / share, 0.0f, 0.99999994f));
    below += share;
  }
  const float rest = std::max(1 - below, 1e-6f);
  return -pi + 2 * pi * std::clamp((u - below) / rest, 0.0f, 0.9999999f);
}

TintedRow* TintedRowPool::allocate(std::uint32_t components) {
  const std::size_t lines =
      (sizeof(TintedRow) + components * sizeof(TintedComponent) + sizeof(Line) - 1) / sizeof(Line);
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
  TintedRow* row = allocate(fit.component_count);
  row->count = fit.component_count;
  row->objective = objective;
  std::array<double, 3> mass{};
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    mass[channel] = std::max(0.0f, fit.uniform_weight) *
                    absorbed_share(sigma_a[c], fit.uniform_attribute_mean, fit.uniform_attribute_variance);
    row->uniform_share[c] = static_cast<float>(mass[channel]);
  }
  TintedComponent* components = row->parts();
  for (std::uint32_t d = 0; d < row->count; ++d) {
    const adaptive::Component& part = fit.components[d];
    const adaptive::SkewLogistic& shape = part.shape;
    components[d] = {shape.mu,          1 / shape.s_left,
                     1 / shape.s_right, 2 / (side_mass(shape.s_left) + side_mass(shape.s_right)),
                     glm::vec3(0),      0};
    for (int c = 0; c < 3; ++c) {
      const double share = part.weight * absorbed_share(sigma_a[c], part.attribute_mean, part.attribute_variance);
      components[d].share[c] = static_cast<float>(share);
      mass[static_cast<std::size_t>(c)] += share;
    }
  }
  for (int c = 0; c < 3; ++c) {
    const double total = mass[static_cast<std::size_t>(c)];
    const bool dark = !(total > 1e-30);  // no light is left in this channel: its shape does not matter
    row->uniform_share[c] = dark ? 1.0f : static_cast<float>(row->uniform_share[c] / total);
    for (std::uint32_t d = 0; d < row->count; ++d) {
      float& share = components[d].share[c];
      share = dark ? 0.0f : static_cast<float>(share / total);
    }
  }
  return row;
}

}  // namespace tress::fiber
