#include "fiber/clear_energies.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "base/pi.h"
#include "fiber/reflection.h"
#include "fiber/surface_fresnel.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr double least_mass = 1e-5;      // mass of a lobe below which the series do not determine its lengths
constexpr double longest_depth = 10;     // e^-10 of the light is left at this depth; longer lengths are clamped
constexpr double unknown_length = 10;    // length assumed for light that is only known to leave late
constexpr float largest_theta = 1.569f;  // let_in has a limit at pi/2, where no light enters

/// Converts the rule of y into a rule of lengths, with its weights scaled to a mass.
PathRule length_rule(const LengthMoments& moments, double decay, double mass) {
  PathRule rule;
  rule.weight[0] = mass;
  rule.length[0] = unknown_length;
  if (!(moments[0] > least_mass)) return rule;
  rule = gauss_rule(central_moments(moments));
  double sum = 0;
  for (const double weight : rule.weight) sum += weight;
  for (std::size_t k = 0; k < path_points; ++k) {
    rule.weight[k] *= mass / sum;
    rule.length[k] = -std::log(std::clamp(rule.length[k], std::exp(-longest_depth), 1.0)) / decay;
  }
  return rule;
}

std::vector<double> uniform_axis(int nodes, double from, double to) {
  std::vector<double> axis;
  for (int i = 0; i < nodes; ++i) axis.push_back(from + (to - from) * i / (nodes - 1));
  return axis;
}

}  // namespace

float ClearEnergies::phi_of(int node) { return static_cast<float>(node % azimuths * (pi / 2) / (azimuths - 1)); }

float ClearEnergies::theta_of(int node) {
  return static_cast<float>(node / azimuths * pi / (inclinations - 1) - pi / 2);
}

ClearEnergies::ClearEnergies(const EnergyKey& key)
    : key_(key), clear_(node_count), rules_(offset(Lobe::glint, key.glint_sigma > 0 ? path_points : 0)) {
  const std::vector<LobeMoments> moments =
      TracedEnergies(key).at(uniform_axis(azimuths, 0, pi / 2), uniform_axis(inclinations, -pi / 2, pi / 2));
  tbb::parallel_for(tbb::blocked_range<int>(0, node_count, 16), [&](const auto& range) {
    for (int node = range.begin(); node != range.end(); ++node) set(node, moments[static_cast<std::size_t>(node)]);
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

void ClearEnergies::set(int node, const LobeMoments& moments) {
  constexpr std::array named{Lobe::tt, Lobe::trt, Lobe::trrt, Lobe::glint};
  Node& clear = clear_[static_cast<std::size_t>(node)];
  const double reflected = std::clamp(moments.reflected, 0.0, 1.0);
  const auto series_of = [&](Lobe lobe) { return moments.later[static_cast<std::size_t>(lobe)][0]; };
  // GLINT is a part of TRT: noise that lowers one raises the other, so a split changes no other lobe.
  const double trt = std::max(series_of(Lobe::trt) + series_of(Lobe::glint), 0.0);
  const double glint = std::clamp(series_of(Lobe::glint), 0.0, trt);
  const auto mass_of = [&](Lobe lobe) {
    return lobe == Lobe::glint ? glint : lobe == Lobe::trt ? trt - glint : std::max(series_of(lobe), 0.0);
  };
  double sum = reflected;
  for (const Lobe lobe : named) sum += mass_of(lobe);
  const double all = key_.parts.absorption > 0 ? std::min(sum + mass_of(Lobe::residual), 1.0) : 1;
  const double share = std::min(all / sum, 1.0);  // a series may overshoot 1
  const auto set_lobe = [&](Lobe lobe, double mass) {
    set(lobe, node, length_rule(moments.later[static_cast<std::size_t>(lobe)], length_decay(lobe), mass));
  };
  clear[0] = static_cast<float>(reflected * share);
  for (const Lobe lobe : named) {
    if (lobe != Lobe::glint || key_.glint_sigma > 0) set_lobe(lobe, mass_of(lobe) * share);
  }
  set_lobe(Lobe::residual, std::max(all - sum * share, 0.0));

  const float theta = std::clamp(theta_of(node), -largest_theta, largest_theta);
  const float smooth = reflected_energy(ReflectionFresnel::exact, key_.eta, key_.eccentricity, theta, phi_of(node));
  clear[let_in] = (1 - smooth) / (1 - SurfaceFresnel(key_.eta, theta, ReflectionFresnel::exact)(1));
}

std::size_t ClearEnergies::bytes() const {
  return sizeof(*this) + clear_.capacity() * sizeof(clear_[0]) + rules_.capacity() * sizeof(float);
}

std::shared_ptr<const ClearEnergies> SharedEnergies::find(const EnergyKey& key) {
  std::shared_ptr<const ClearEnergies>& made = made_[key];
  if (made == nullptr) made = std::make_shared<const ClearEnergies>(key);
  return made;
}

}  // namespace tress::inline v0_2::fiber
