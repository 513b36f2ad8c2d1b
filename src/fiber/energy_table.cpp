#include "fiber/energy_table.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/color.h"
#include "base/exp_of_negative.h"
#include "base/float4.h"
#include "fiber/reflection.h"
#include "fiber/row_axes.h"
#include "fiber/surface_fresnel.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr int node_count = ClearEnergies::node_count;
constexpr float least_energy = 1e-3f;
constexpr auto residual = static_cast<std::size_t>(Lobe::residual);

/// Computes the energies of a lobe at all nodes under one absorption.
void absorb(const ClearEnergies& clear, Lobe lobe, float sigma_a, float* out) {
  std::fill_n(out, node_count, 0.0f);
  for (int k = 0; k < path_points; ++k) {
    const float* weight = clear.weights(lobe, k);
    const float* length = clear.lengths(lobe, k);
    for (int node = 0; node < node_count; ++node) {
      out[node] += weight[node] * exp_of_negative(-sigma_a * length[node]);
    }
  }
}

/// E_R of a smooth surface, given an interpolated ClearEnergies::let_in.
float smooth_reflection(float eta, float theta, float let_in) {
  return 1 - (1 - SurfaceFresnel(eta, theta, ReflectionFresnel::exact)(1)) * let_in;
}

/// E_R at a node.
float energy_of_reflection(const ClearEnergies& clear, const FiberParameters& fiber, int node) {
  const float rough = clear.clear(node)[0];
  if (fiber.reflection_fresnel == ReflectionFresnel::exact) return rough;
  const float theta = ClearEnergies::theta_of(node);
  return rough / smooth_reflection(fiber.eta, theta, clear.clear(node)[ClearEnergies::let_in]) *
         reflected_energy(fiber.reflection_fresnel, fiber.eta, fiber.eccentricity, theta, ClearEnergies::phi_of(node));
}

/// The four nodes around a direction, and its position between them.
struct Corners {
  int corner, beyond;  ///< index of the first node of either row; the second follows it
  float x, y;          ///< position from the first node to the second, and from the first row to the other; in [0, 1]

  Corners(float phi_r, float theta) {
    constexpr int width = ClearEnergies::azimuths, last_i = width - 1, last_j = ClearEnergies::inclinations - 1;
    constexpr float inverse_pi = std::numbers::inv_pi_v<float>;
    const float at_x = fold_azimuth(phi_r).phi * (2 * inverse_pi * static_cast<float>(last_i));
    const float at_y =
        std::clamp((theta * inverse_pi + 0.5f) * static_cast<float>(last_j), 0.0f, static_cast<float>(last_j));
    const int i = std::clamp(static_cast<int>(at_x), 0, last_i - 1),
              j = std::clamp(static_cast<int>(at_y), 0, last_j - 1);
    x = std::clamp(at_x - static_cast<float>(i), 0.0f, 1.0f);
    y = at_y - static_cast<float>(j);
    corner = j * width + i;
    beyond = corner + width;
  }
};

}  // namespace

EnergyTable::EnergyTable(std::shared_ptr<const ClearEnergies> clear, const FiberParameters& fiber)
    : clear_(std::move(clear)), colored_(node_count) {
  assert(clear_->key().eta == fiber.eta && clear_->key().eccentricity == fiber.eccentricity);
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
  const Corners at(phi_r, theta);
  const float fx = at.x, fy = at.y;
  const Float4 weight[4] = {splat((1 - fx) * (1 - fy)), splat(fx * (1 - fy)), splat((1 - fx) * fy), splat(fx * fy)};
  const auto mix = [&](const auto& at_corner, auto& out, std::size_t first) {
    store4(out, first,
           (weight[0] * load4(at_corner(at.corner), first) + weight[1] * load4(at_corner(at.corner + 1), first)) +
               (weight[2] * load4(at_corner(at.beyond), first) + weight[3] * load4(at_corner(at.beyond + 1), first)));
  };
  const auto clear = [&](int node) -> const auto& { return clear_->clear(node); };
  const auto colored = [&](int node) -> const auto& { return colored_[static_cast<std::size_t>(node)]; };
  static_assert(sizeof(LobeColors) == 18 * sizeof(float) && sizeof(ClearEnergies::Node) == 8 * sizeof(float));
  LobeEnergies energies;
  ClearEnergies::Node node;
  for (const std::size_t first : {0, 4, 8, 12, 14}) mix(colored, energies.colored, first);  // the last two overlap
  for (const std::size_t first : {0, 4}) mix(clear, node, first);
  std::copy_n(node.begin(), lobe_count, energies.clear.begin());
  energies.smooth_reflection = smooth_reflection(clear_->key().eta, theta, node[ClearEnergies::let_in]);
  return energies;
}

std::array<double, lobe_count> EnergyTable::without_gain(float phi_r, float theta, float sigma_a) const {
  const Corners at(phi_r, theta);
  const auto x = static_cast<double>(at.x), y = static_cast<double>(at.y);
  std::array<double, lobe_count> energies{};
  const auto add = [&](int node, double share) {
    energies[0] += share * static_cast<double>(clear_->clear(node)[0]);
    for (const Lobe lobe : {Lobe::tt, Lobe::trt, Lobe::trrt, Lobe::residual, Lobe::glint}) {
      if (lobe == Lobe::glint && !(clear_->key().glint_sigma > 0)) continue;
      for (int k = 0; k < path_points; ++k) {
        const float kept = clear_->weights(lobe, k)[node] * exp_of_negative(-sigma_a * clear_->lengths(lobe, k)[node]);
        energies[static_cast<std::size_t>(lobe)] += share * static_cast<double>(kept);
      }
    }
  };
  add(at.corner, (1 - x) * (1 - y));
  add(at.corner + 1, x * (1 - y));
  add(at.beyond, (1 - x) * y);
  add(at.beyond + 1, x * y);
  return energies;
}

LobeEnergies EnergyTable::at(float phi_r, float theta) const {
  LobeEnergies energies = interpolated(phi_r, theta);
  std::array<float, lobe_count> share;
  float total = 0;
  for (std::size_t lobe = 0; lobe < lobe_count; ++lobe) total += share[lobe] = luminance(energies.colored[lobe]);
  for (std::size_t lobe = 1; lobe < lobe_count; ++lobe) {
    if (lobe == residual) continue;
    if (energies.clear[lobe] >= least_energy && share[lobe] >= least_energy * total) continue;
    energies.clear[residual] += energies.clear[lobe];
    energies.colored[residual] += energies.colored[lobe];
    energies.clear[lobe] = 0;
    energies.colored[lobe] = glm::vec3(0.0f);
  }
  return energies;
}

}  // namespace tress::inline v0_2::fiber
