#include "fiber/energy_table.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fiber/cross_section.h"
#include "fiber/ray_batch.h"
#include "fiber/row_axes.h"

namespace tress::fiber {
namespace {

constexpr float least_energy = 1e-3f;

struct Sums {
  std::array<double, lobe_count> clear{};
  std::array<std::array<double, 3>, lobe_count> colored{};
};

LobeEnergies rounded(const Sums& sums) {
  LobeEnergies energies;
  for (std::size_t lobe = 0; lobe < lobe_count; ++lobe) {
    energies.clear[lobe] = static_cast<float>(sums.clear[lobe]);
    for (int c = 0; c < 3; ++c) {
      energies.colored[lobe][c] = static_cast<float>(sums.colored[lobe][static_cast<std::size_t>(c)]);
    }
  }
  return energies;
}

}  // namespace

float luminance(const glm::vec3& color) { return 0.2126f * color.r + 0.7152f * color.g + 0.0722f * color.b; }

LobeEnergies traced_energies(float eta, float eccentricity, const glm::vec3& sigma_a, double phi_r, double theta,
                             int rays) {
  constexpr int lanes = RayBatch::lanes;
  const CrossSection section(eta, eccentricity, phi_r, theta);
  const double share = 1.0 / rays;
  const bool gray = sigma_a.r == sigma_a.g && sigma_a.g == sigma_a.b;
  Sums sums;
  const auto add = [&](int order, const double* weight, const double* path) {
    const auto lobe = static_cast<std::size_t>(order);
    for (int i = 0; i < lanes; ++i) sums.clear[lobe] += weight[i] * share;
    for (int c = 0; c < (gray ? 1 : 3); ++c) {
      double sum = 0;
      for (int i = 0; i < lanes; ++i) {
        sum += weight[i] * static_cast<double>(std::exp(static_cast<float>(-sigma_a[c] * path[i])));
      }
      sums.colored[lobe][static_cast<std::size_t>(c)] += sum * share;
    }
  };
  constexpr auto residual = static_cast<std::size_t>(Lobe::residual);
  for (int first = 0; first < rays; first += lanes) {
    RayBatch batch(section, (2 * first + 1) * share - 1, 2 * share);
    add(0, batch.weight(), batch.path());
    for (int order = 1; order < traced_orders; ++order) {
      batch.advance();
      add(order, batch.weight(), batch.path());
    }
    for (int i = 0; i < lanes; ++i) sums.clear[residual] += batch.left()[i] * share;
  }
  // What is left after TRRT is known; its color is that of an eighth as many rays, followed to the end.
  const int followed = rays / 8;
  double mass = 0;
  std::array<double, 3> color{};
  for (int i = 0; i < followed; ++i) {
    section.trace_residual((2 * i + 1.0) / followed - 1, [&](double weight, double path) {
      mass += weight;
      for (std::size_t c = 0; c < (gray ? 1 : 3); ++c) {
        color[c] += weight * static_cast<double>(std::exp(static_cast<float>(-sigma_a[static_cast<int>(c)] * path)));
      }
    });
  }
  for (std::size_t c = 0; c < 3; ++c) {
    sums.colored[residual][c] = mass > 0 ? sums.clear[residual] * color[c] / mass : 0;
  }
  if (gray) {
    for (auto& color : sums.colored) color[1] = color[2] = color[0];
  }
  return rounded(sums);
}

EnergyTable::EnergyTable(float eta, float eccentricity, const glm::vec3& sigma_a)
    : nodes_(static_cast<std::size_t>(nodes_per_axis) * nodes_per_axis) {
  constexpr double last = nodes_per_axis - 1;
  tbb::parallel_for(tbb::blocked_range<int>(0, nodes_per_axis * nodes_per_axis, 16), [&](const auto& range) {
    for (int node = range.begin(); node != range.end(); ++node) {
      const double phi_r = (node % nodes_per_axis) / last * (std::numbers::pi / 2);
      const double theta = std::acos((node / nodes_per_axis) / last);
      nodes_[static_cast<std::size_t>(node)] = traced_energies(eta, eccentricity, sigma_a, phi_r, theta, rays_per_node);
    }
  });
}

LobeEnergies EnergyTable::interpolated(float phi_r, float theta) const {
  constexpr int last = nodes_per_axis - 1;
  const float x = fold_azimuth(phi_r).phi * (static_cast<float>(last) * 2 / std::numbers::pi_v<float>);
  const float y = std::clamp(std::cos(theta), 0.0f, 1.0f) * static_cast<float>(last);
  const int i = std::clamp(static_cast<int>(x), 0, last - 1), j = std::clamp(static_cast<int>(y), 0, last - 1);
  const float fx = std::clamp(x - static_cast<float>(i), 0.0f, 1.0f), fy = y - static_cast<float>(j);
  const float weight[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  const LobeEnergies* corner = &nodes_[static_cast<std::size_t>(j * nodes_per_axis + i)];
  const LobeEnergies* corners[4] = {corner, corner + 1, corner + nodes_per_axis, corner + nodes_per_axis + 1};
  LobeEnergies energies;
  for (std::size_t lobe = 0; lobe < lobe_count; ++lobe) {
    for (std::size_t k = 0; k < 4; ++k) {
      energies.clear[lobe] += weight[k] * corners[k]->clear[lobe];
      energies.colored[lobe] += weight[k] * corners[k]->colored[lobe];
    }
  }
  return energies;
}

LobeEnergies EnergyTable::at(float phi_r, float theta) const {
  LobeEnergies energies = interpolated(phi_r, theta);
  constexpr auto residual = static_cast<std::size_t>(Lobe::residual);
  float total = 0;
  for (const glm::vec3& color : energies.colored) total += luminance(color);
  for (std::size_t lobe = 1; lobe < residual; ++lobe) {
    if (energies.clear[lobe] >= least_energy && luminance(energies.colored[lobe]) >= least_energy * total) continue;
    energies.clear[residual] += energies.clear[lobe];
    energies.colored[residual] += energies.colored[lobe];
    energies.clear[lobe] = 0;
    energies.colored[lobe] = glm::vec3(0.0f);
  }
  return energies;
}

}  // namespace tress::fiber
