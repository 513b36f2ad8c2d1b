#include "fiber/clear_energies.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fiber/cross_section.h"
#include "fiber/ray_batch.h"
#include "tress/adaptive/exp_of_negative.h"

namespace tress::fiber {
namespace {

constexpr int lanes = RayBatch::lanes;
constexpr int residual_rays = 64;
constexpr int last_residual_order = 40;
constexpr double least_left = 1e-3;  // of the residual of a batch: what then remains is continued
constexpr double decay = 0.05;       // the residual's rule is of y = e^(-decay l)

/// Sums by lane, added up in a fixed order: vectorises without reassociation.
struct LaneSum {
  double lane[lanes] = {};
  double total() const {
    double sum = 0;
    for (const double x : lane) sum += x;
    return sum;
  }
};

/// Rays of one order at a node.
struct OrderRays {
  double weight[ClearEnergies::rays_per_node];
  double path[ClearEnergies::rays_per_node];
};

CentralMoments moments_of(const OrderRays& rays) {
  constexpr int n = ClearEnergies::rays_per_node;
  LaneSum mass, first;
  for (int i = 0; i < n; i += lanes) {
    for (int k = 0; k < lanes; ++k) {
      mass.lane[k] += rays.weight[i + k];
      first.lane[k] += rays.weight[i + k] * rays.path[i + k];
    }
  }
  CentralMoments m;
  m.mass = mass.total();
  if (!(m.mass > 0)) return m;
  const double mean = m.mean = first.total() / m.mass;
  LaneSum central[4];
  for (int i = 0; i < n; i += lanes) {
    for (int k = 0; k < lanes; ++k) {
      const double x = rays.path[i + k] - mean, x2 = x * x, w2 = rays.weight[i + k] * x2;
      central[0].lane[k] += w2;
      central[1].lane[k] += w2 * x;
      central[2].lane[k] += w2 * x2;
      central[3].lane[k] += w2 * x2 * x;
    }
  }
  for (std::size_t k = 0; k < 4; ++k) m.central[k] = central[k].total() / m.mass;
  return m;
}

/// Moments 0 to 5 of y = e^(-decay l) over the light after TRRT.
std::array<double, 6> residual_moments(const CrossSection& section) {
  std::array<LaneSum, 6> sum;
  const auto add = [&sum](int lane, double weight, double y) {
    for (LaneSum& moment : sum) {
      moment.lane[lane] += weight;
      weight *= y;
    }
  };
  const auto total_left = [](const RayBatch& rays) {
    double left = 0;
    for (int i = 0; i < lanes; ++i) left += rays.left()[i];
    return left;
  };
  double left_after[last_residual_order + 1][lanes], path_after[last_residual_order + 1][lanes];
  for (int first = 0; first < residual_rays; first += lanes) {
    RayBatch rays(section, (2 * first + 1.0) / residual_rays - 1, 2.0 / residual_rays);
    int order = 0;
    const auto advance = [&] {
      rays.advance();
      ++order;
      std::copy_n(rays.left(), lanes, left_after[order]);
      std::copy_n(rays.path(), lanes, path_after[order]);
    };
    while (order < traced_orders - 1) advance();
    const double enough = least_left * total_left(rays);
    while (order < last_residual_order && total_left(rays) > enough) {
      advance();
      for (int i = 0; i < lanes; ++i) {
        const auto depth = static_cast<float>(-decay * rays.path()[i]);
        add(i, rays.weight()[i], static_cast<double>(adaptive::exp_of_negative(depth)));
      }
    }
    // What is left goes on losing light per length as it did over the second half: y^k then has the mean
    // y(l)^k r / (r + k decay).
    const int half = (order + traced_orders) / 2;
    for (int i = 0; i < lanes; ++i) {
      const double left = rays.left()[i], length = rays.path()[i] - path_after[half][i];
      if (!(left > 0)) continue;
      const double rate = length > 0 ? std::log(left_after[half][i] / left) / length : 0;
      const double y = std::exp(-decay * rays.path()[i]);
      double weight = left;
      for (std::size_t k = 0; k < sum.size(); ++k) {
        sum[k].lane[i] += k == 0 ? weight : weight * rate / (rate + static_cast<double>(k) * decay);
        weight *= y;
      }
    }
  }
  std::array<double, 6> moments;
  for (std::size_t k = 0; k < 6; ++k) moments[k] = sum[k].total();
  return moments;
}

/// The rule of y as one of lengths, its weights scaled to a mass.
PathRule residual_rule(const std::array<double, 6>& moments, double mass) {
  PathRule rule = gauss_rule(central_moments(moments));
  double sum = 0;
  for (const double weight : rule.weight) sum += weight;
  for (std::size_t k = 0; k < path_points; ++k) {
    rule.weight[k] = sum > 0 ? rule.weight[k] * (mass / sum) : k == 0 ? mass : 0;
    rule.length[k] = -std::log(std::clamp(rule.length[k], 1e-12, 1.0)) / decay;
  }
  return rule;
}

}  // namespace

EnergyKey energy_key(const FiberParameters& fiber) {
  return {fiber.eta, fiber.eccentricity, fiber.split_glint ? azimuthal_sigmas(fiber)[1] : 0};
}

ClearEnergies::ClearEnergies(const EnergyKey& key)
    : key_(key), clear_(node_count), rules_(offset(Lobe::glint, key.glint_sigma > 0 ? path_points : 0)) {
  tbb::parallel_for(tbb::blocked_range<int>(0, node_count, 16), [this](const auto& range) {
    for (int node = range.begin(); node != range.end(); ++node) trace(node);
  });
}

void ClearEnergies::set(Lobe lobe, int node, const PathRule& rule) {
  float& clear = clear_[static_cast<std::size_t>(node)][static_cast<std::size_t>(lobe)];
  for (int k = 0; k < path_points; ++k) {
    const auto weight = static_cast<float>(rule.weight[static_cast<std::size_t>(k)]);
    rules_[offset(lobe, k) + static_cast<std::size_t>(node)] = weight;
    rules_[offset(lobe, k) + static_cast<std::size_t>(node_count + node)] =
        static_cast<float>(rule.length[static_cast<std::size_t>(k)]);
    clear += weight;
  }
}

void ClearEnergies::trace(int node) {
  constexpr double last = nodes_per_axis - 1, share = 1.0 / rays_per_node;
  const double phi_r = (node % nodes_per_axis) / last * (std::numbers::pi / 2);
  const CrossSection section(static_cast<double>(key_.eta), static_cast<double>(key_.eccentricity), phi_r,
                             std::acos((node / nodes_per_axis) / last));
  const bool split = key_.glint_sigma > 0;
  OrderRays orders[traced_orders - 1];
  OrderRays glint{};
  LaneSum reflected, left;
  for (int first = 0; first < rays_per_node; first += lanes) {
    RayBatch rays(section, (2 * first + 1) * share - 1, 2 * share, split);
    for (int i = 0; i < lanes; ++i) reflected.lane[i] += rays.weight()[i];
    for (OrderRays& order : orders) {
      rays.advance();
      std::copy_n(rays.weight(), lanes, order.weight + first);
      std::copy_n(rays.path(), lanes, order.path + first);
      if (!split || &order != orders + 1) continue;
      double part[lanes];
      rays.glint_shares(static_cast<double>(key_.glint_sigma), part);
      for (int i = 0; i < lanes; ++i) {
        glint.weight[first + i] = order.weight[first + i] * part[i];
        glint.path[first + i] = order.path[first + i];
        order.weight[first + i] *= 1 - part[i];
      }
    }
    for (int i = 0; i < lanes; ++i) left.lane[i] += rays.left()[i];
  }
  clear_[static_cast<std::size_t>(node)][0] = static_cast<float>(reflected.total() * share);
  const auto set_rays = [&](Lobe lobe, const OrderRays& rays) {
    CentralMoments moments = moments_of(rays);
    moments.mass *= share;
    set(lobe, node, gauss_rule(moments));
  };
  for (int p = 1; p < traced_orders; ++p) set_rays(static_cast<Lobe>(p), orders[p - 1]);
  if (split) set_rays(Lobe::glint, glint);
  set(Lobe::residual, node, residual_rule(residual_moments(section), left.total() * share));
}

std::size_t ClearEnergies::bytes() const {
  return sizeof(*this) + clear_.capacity() * sizeof(clear_[0]) + rules_.capacity() * sizeof(float);
}

std::shared_ptr<const ClearEnergies> SharedEnergies::find(const EnergyKey& key) {
  std::shared_ptr<const ClearEnergies>& made = made_[key];
  if (made == nullptr) made = std::make_shared<const ClearEnergies>(key);
  return made;
}

}  // namespace tress::fiber
