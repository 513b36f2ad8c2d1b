#include "models/elliptical/absorbed_row.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>

#include "base/pi.h"
#include "models/elliptical/absorbed_lanes.h"

namespace tress::inline v0_2::fiber {
namespace {

float side_mass(float s) { return s * static_cast<float>(std::tanh(0.5 * std::numbers::pi / s)); }

}  // namespace

RowValue AbsorbedRow::evaluate(float x, const glm::vec3& channel_weights, float u_share) const {
  RowValue value;
  const Float4 shape = uniform_of(*this) + components_behind(*this, 0, x);
  value.shape = {shape[0], shape[1], shape[2]};
  value.proposal = (1 - u_share) * glm::dot(channel_weights, value.shape) + u_share * inverse_two_pi_f;
  return value;
}

float AbsorbedRow::sample(float u, const glm::vec3& channel_weights, float u_share) const {
  return sample_mixture(*this, u, (1 - u_share) * channel_weights);
}

std::size_t absorbed_bytes(const adaptive::Mixture& fit) {
  return sizeof(AbsorbedRow) * std::max(1u, (fit.component_count + 1) / 2);
}

const AbsorbedRow* put_absorbed(const adaptive::Mixture& fit, float objective, const glm::vec3& sigma_a, void* memory) {
  const std::uint32_t behind = fit.component_count > 2 ? (fit.component_count - 1) / 2 : 0;
  auto* row = static_cast<AbsorbedRow*>(memory);
  std::uninitialized_value_construct_n(row, 1 + behind);
  row->tail = (std::bit_cast<std::uint32_t>(objective) & ~0xffu) | behind;
  std::array<double, 3> mass{}, uniform{};
  for (std::size_t c = 0; c < 3; ++c) {
    mass[c] = uniform[c] = std::max(0.0f, fit.uniform_weight) * adaptive::decayed_share(sigma_a[static_cast<int>(c)],
                                                                                        fit.uniform_attribute_mean,
                                                                                        fit.uniform_attribute_variance);
  }
  std::array<std::array<double, 3>, adaptive::Mixture::max_components> shares{};
  for (std::uint32_t d = 0; d < fit.component_count; ++d) {
    const adaptive::Component& part = fit.components[d];
    AbsorbedRow& line = row[d / 2];
    line.mu[d % 2] = part.shape.mu;
    line.inverse_left[d % 2] = 1 / part.shape.s_left;
    line.inverse_right[d % 2] = 1 / part.shape.s_right;
    for (std::size_t c = 0; c < 3; ++c) {
      const float sigma = sigma_a[static_cast<int>(c)];
      shares[d][c] = part.weight * adaptive::decayed_share(sigma, part.attribute_mean, part.attribute_variance);
      mass[c] += shares[d][c];
    }
  }
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    const bool dark = !(mass[channel] > 1e-30);  // no light is left here: the shape does not matter
    row->uniform[c] = dark ? inverse_two_pi_f : static_cast<float>(uniform[channel] / mass[channel]) * inverse_two_pi_f;
    if (dark) continue;
    for (std::uint32_t d = 0; d < fit.component_count; ++d) {
      const adaptive::SkewLogistic& shape = fit.components[d].shape;
      const float norm = 0.5f * (side_mass(shape.s_left) + side_mass(shape.s_right));  // Z
      row[d / 2].amplitude[d % 2][c] = static_cast<float>(shares[d][channel] / mass[channel]) / norm;
    }
  }
  return row;
}

}  // namespace tress::inline v0_2::fiber
