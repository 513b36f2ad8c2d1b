#include "references/models/marschner_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/pi.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float pi_f = std::numbers::pi_v<float>;
constexpr std::uint32_t inclination_nodes = 19, azimuth_nodes = 13;
constexpr std::uint32_t fewest_knots = 64, most_knots = 360;
constexpr double knots_per_width = 1.5;  // of the caustics

}  // namespace

MarschnerPaths marschner_paths(const MarschnerShape& shape, MarschnerLobe lobe, double phi_r, double theta_d,
                               double phi) {
  if (lobe == MarschnerLobe::r || lobe == MarschnerLobe::tt) {
    return MarschnerCircle(shape.eta, shape.eta, theta_d).paths(static_cast<int>(lobe), phi);
  }
  const MarschnerCircle circle = marschner_trt_circle(shape.eta, shape.eccentricity, phi_r, theta_d, phi);
  const MarschnerGlint glint = circle.glint(shape.caustics);
  MarschnerPaths paths;
  if (lobe == MarschnerLobe::glint) {
    paths.path[0] = {glint.density(phi, shape.caustics.width), glint.attenuation, glint.length,
                     std::sqrt(std::max(1 - circle.caustic_offset() * circle.caustic_offset(), 0.0))};
    paths.count = 1;
    return paths;
  }
  paths = circle.paths(2, phi);
  const double kept = glint.removal(phi, shape.caustics.width);
  for (std::size_t k = 0; k < paths.count; ++k) paths.path[k].density *= kept;
  return paths;
}

glm::vec3 marschner_density(const MarschnerPaths& paths, const glm::vec3& sigma_a) {
  glm::vec3 sum(0.0f);
  for (std::size_t k = 0; k < paths.count; ++k) {
    const MarschnerPath& path = paths.path[k];
    const auto clear = static_cast<float>(path.density * path.attenuation), length = static_cast<float>(path.length);
    for (int c = 0; c < 3; ++c) sum[c] += clear * std::exp(-sigma_a[c] * length);
  }
  return sum;
}

MarschnerTable::MarschnerTable(const MarschnerShape& shape)
    : knots_(std::clamp(static_cast<std::uint32_t>(2 * pi * knots_per_width / shape.caustics.width), fewest_knots,
                        most_knots)) {
  for (int l = 0; l < marschner_lobes; ++l) {
    const auto lobe = static_cast<MarschnerLobe>(l);
    Tables& tables = tables_[static_cast<std::size_t>(l)];
    tables.azimuth_nodes = l >= 2 && shape.eccentricity < 1 ? azimuth_nodes : 1;
    for (std::uint32_t a = 0; a < tables.azimuth_nodes; ++a) {
      for (std::uint32_t t = 0; t < inclination_nodes; ++t) {
        fill_node(shape, lobe, 0.5 * pi * a / (azimuth_nodes - 1), 0.5 * pi * t / (inclination_nodes - 1));
      }
    }
  }
}

void MarschnerTable::fill_node(const MarschnerShape& shape, MarschnerLobe lobe, double phi_r, double theta_d) {
  Tables& tables = tables_[static_cast<std::size_t>(lobe)];
  const double step = 2 * pi / knots_;
  std::vector<MarschnerPath> light;  // densities with their attenuation
  std::vector<double> value(knots_ + 1);
  CentralMoments moments;
  for (std::uint32_t k = 0; k < knots_; ++k) {
    const MarschnerPaths paths = marschner_paths(shape, lobe, phi_r, theta_d, -pi + step * k);
    for (std::size_t i = 0; i < paths.count; ++i) {
      const MarschnerPath& path = paths.path[i];
      const double density = path.density * path.attenuation;
      value[k] += density;
      moments.mass += density * step;
      moments.mean += density * step * path.length;
      light.push_back({density * step, 1, path.length, path.cos_gamma});
    }
  }
  value[knots_] = value[0];
  const double mass = moments.mass;
  if (mass > 0) moments.mean /= mass;
  // Lengths may differ little: moments about their mean.
  for (const MarschnerPath& path : light) {
    const double x = path.length - moments.mean;
    double power = path.density / mass * x;
    for (double& moment : moments.central) moment += power *= x;
  }
  tables.rule.push_back(gauss_rule(moments));
  float below = 0, before = 0;
  for (std::uint32_t k = 0; k <= knots_; ++k) {
    const double shape_here =
        mass > 1e-12 ? (1 - double{uniform_share}) * value[k] / mass : (1 - double{uniform_share}) / (2 * pi);
    const auto density = static_cast<float>(shape_here + double{uniform_share} / (2 * pi));
    if (k > 0) below += 0.5f * (before + density) * static_cast<float>(step);
    tables.density.push_back(density);
    tables.below.push_back(below);
    before = density;
  }
}

MarschnerTable::Place MarschnerTable::place(MarschnerLobe lobe, float folded_phi_r, float theta_d) const {
  const auto split = [](float x, std::uint32_t nodes, std::uint32_t& index) {
    const float scaled = std::clamp(x, 0.0f, 1.0f) * static_cast<float>(nodes - 1);
    index = std::min(static_cast<std::uint32_t>(scaled), nodes - 2);
    return scaled - static_cast<float>(index);
  };
  std::uint32_t a = 0, t = 0;
  const float theta_share = split(std::abs(theta_d) * (2 / pi_f), inclination_nodes, t);
  const bool flat = of(lobe).azimuth_nodes == 1;
  const float phi_share = flat ? 0 : split(folded_phi_r * (2 / pi_f), azimuth_nodes, a);
  const std::uint32_t first = a * inclination_nodes + t, next = flat ? first : first + inclination_nodes;
  return {{first, first + 1, next, next + 1},
          {(1 - phi_share) * (1 - theta_share), (1 - phi_share) * theta_share, phi_share * (1 - theta_share),
           phi_share * theta_share}};
}

float MarschnerTable::density(MarschnerLobe lobe, const Place& place, float phi) const {
  const Tables& tables = of(lobe);
  const float scaled = std::clamp((phi + pi_f) / (2 * pi_f), 0.0f, 1.0f) * static_cast<float>(knots_);
  const std::uint32_t k = std::min(static_cast<std::uint32_t>(scaled), knots_ - 1);
  const float x = scaled - static_cast<float>(k);
  float sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const float* value = tables.density.data() + place.node[i] * (knots_ + 1) + k;
    sum += place.share[i] * (value[0] + x * (value[1] - value[0]));
  }
  return sum;
}

float MarschnerTable::sample(MarschnerLobe lobe, const Place& place, float u_node, float u) const {
  const Tables& tables = of(lobe);
  std::size_t i = 0;
  for (float below = place.share[0]; i < 3 && u_node >= below; below += place.share[i]) ++i;
  const std::uint32_t first = place.node[i] * (knots_ + 1);
  const float* below = tables.below.data() + first;
  const float wanted = u * below[knots_];
  const auto k =
      std::min(static_cast<std::uint32_t>(std::upper_bound(below, below + knots_ + 1, wanted) - below), knots_) - 1;
  const float v0 = tables.density[first + k], v1 = tables.density[first + k + 1];
  const float step = 2 * pi_f / static_cast<float>(knots_), mass = (wanted - below[k]) / step;
  // v0 x + (v1 - v0) x^2/2 = mass, by the root that does not cancel.
  const float x = 2 * mass / (v0 + std::sqrt(std::max(v0 * v0 + 2 * (v1 - v0) * mass, 0.0f)));
  const float phi = -pi_f + (static_cast<float>(k) + std::clamp(x, 0.0f, 1.0f)) * step;
  return phi < pi_f ? phi : -pi_f;
}

std::vector<glm::vec3> MarschnerTable::energies(MarschnerLobe lobe, const glm::vec3& sigma_a) const {
  std::vector<glm::vec3> energies;
  for (const PathRule& rule : of(lobe).rule) {
    glm::vec3 energy(0.0f);
    for (std::size_t k = 0; k < path_points; ++k) {
      for (int c = 0; c < 3; ++c) {
        energy[c] += static_cast<float>(rule.weight[k] * std::exp(-static_cast<double>(sigma_a[c]) * rule.length[k]));
      }
    }
    energies.push_back(energy);
  }
  return energies;
}

std::size_t MarschnerTable::bytes() const {
  std::size_t bytes = sizeof(*this);
  for (const Tables& t : tables_) {
    bytes += t.rule.size() * sizeof(PathRule) + (t.density.size() + t.below.size()) * sizeof(float);
  }
  return bytes;
}

std::shared_ptr<const MarschnerTable> MarschnerTables::find(const MarschnerShape& shape) {
  std::shared_ptr<const MarschnerTable>& table = tables_[{shape.eta, shape.eccentricity, shape.caustics.width}];
  if (!table) table = std::make_shared<const MarschnerTable>(shape);
  return table;
}

std::size_t MarschnerTables::bytes() const {
  std::size_t bytes = 0;
  for (const auto& [key, table] : tables_) bytes += table->bytes();
  return bytes;
}

}  // namespace tress::inline v0_2::fiber
