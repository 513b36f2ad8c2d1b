#include "fiber/energy_table.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "fiber/quarter_sine.h"
#include "fiber/reflection.h"
#include "fiber/row_axes.h"
#include "tress/adaptive/exp_of_negative.h"

namespace tress::fiber {
namespace {

constexpr int node_count = ClearEnergies::node_count;
constexpr float least_energy = 1e-3f;
constexpr auto residual = static_cast<std::size_t>(Lobe::residual);

/// Energies of a lobe at all nodes under one absorption.
void absorb(const ClearEnergies& clear, Lobe lobe, float sigma_a, float* out) {
  std::fill_n(out, node_count, 0.0f);
  for (int k = 0; k < path_points; ++k) {
    const float* weight = clear.weights(lobe, k);
    const float* length = clear.lengths(lobe, k);
    for (int node = 0; node < node_count; ++node) {
      out[node] += weight[node] * adaptive::exp_of_negative(-sigma_a * length[node]);
    }
  }
}

/// E_R at a node: that of the rays where Fresnel is exact.
float energy_of_reflection(const ClearEnergies& clear, const FiberParameters& fiber, int node) {
  if (fiber.reflection_fresnel == ReflectionFresnel::exact) return clear.clear(node)[0];
  constexpr int width = ClearEnergies::nodes_per_axis;
  constexpr float last = width - 1;
  const float phi_r = static_cast<float>(node % width) / last * half_pi;
  const float theta = std::acos(static_cast<float>(node / width) / last);
  return reflected_energy(fiber.reflection_fresnel, fiber.eta, fiber.eccentricity, theta, phi_r);
}

}  // namespace

float luminance(const glm::vec3& color) { return 0.2126f * color.r + 0.7152f * color.g + 0.0722f * color.b; }

EnergyTable::EnergyTable(std::shared_ptr<const ClearEnergies> clear, const FiberParameters& fiber)
    : clear_(std::move(clear)), colored_(node_count) {
  assert(clear_->key() == energy_key(fiber));
  for (int node = 0; node < node_count; ++node) {
    colored_[static_cast<std::size_t>(node)][0] = energy_of_reflection(*clear_, fiber, node) * fiber.gain[0];
  }
  std::vector<float> energy(node_count);
  for (const Lobe lobe : {Lobe::tt, Lobe::trt, Lobe::trrt, Lobe::residual, Lobe::glint}) {
    if (lobe == Lobe::glint && !(clear_->key().glint_sigma > 0)) continue;
    const auto l = static_cast<std::size_t>(lobe);
    for (int c = 0; c < 3; ++c) {
      if (c == 0 || fiber.sigma_a[c] != fiber.sigma_a[c - 1]) absorb(*clear_, lobe, fiber.sigma_a[c], energy.data());
      for (std::size_t node = 0; node < node_count; ++node) colored_[node][l][c] = energy[node] * fiber.gain[l][c];
    }
  }
}

LobeEnergies EnergyTable::interpolated(float phi_r, float theta) const {
  constexpr int last = ClearEnergies::nodes_per_axis - 1;
  const float x = fold_azimuth(phi_r).phi * (static_cast<float>(last) * 2 / std::numbers::pi_v<float>);
  const float y = std::min(quarter_cosine(theta), 1.0f) * static_cast<float>(last);
  const int i = std::clamp(static_cast<int>(x), 0, last - 1), j = std::clamp(static_cast<int>(y), 0, last - 1);
  const float fx = std::clamp(x - static_cast<float>(i), 0.0f, 1.0f), fy = y - static_cast<float>(j);
  const float weight[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  const int corner = j * (last + 1) + i;
  const int corners[4] = {corner, corner + 1, corner + last + 1, corner + last + 2};
  LobeEnergies energies;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::array<float, lobe_count>& clear = clear_->clear(corners[k]);
    const LobeColors& colored = colored_[static_cast<std::size_t>(corners[k])];
    for (std::size_t lobe = 0; lobe < lobe_count; ++lobe) {
      energies.clear[lobe] += weight[k] * clear[lobe];
      energies.colored[lobe] += weight[k] * colored[lobe];
    }
  }
  return energies;
}

LobeEnergies EnergyTable::at(float phi_r, float theta) const {
  LobeEnergies energies = interpolated(phi_r, theta);
  float total = 0;
  for (const glm::vec3& color : energies.colored) total += luminance(color);
  for (std::size_t lobe = 1; lobe < lobe_count; ++lobe) {
    if (lobe == residual) continue;
    if (energies.clear[lobe] >= least_energy && luminance(energies.colored[lobe]) >= least_energy * total) continue;
    energies.clear[residual] += energies.clear[lobe];
    energies.colored[residual] += energies.colored[lobe];
    energies.clear[lobe] = 0;
    energies.colored[lobe] = glm::vec3(0.0f);
  }
  return energies;
}

}  // namespace tress::fiber
