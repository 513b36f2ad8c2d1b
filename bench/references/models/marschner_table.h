// What is tabulated of the Marschner lobes: where to sample their azimuths, and how much energy they have.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "fiber/path_rule.h"
#include "references/models/marschner_azimuth.h"

namespace tress::inline v0_2::fiber {

/// R, TT, TRT without its caustics, GLINT (the caustics, k_G = 1): indices of arrays of them.
enum class MarschnerLobe { r = 0, tt = 1, trt = 2, glint = 3 };
constexpr int marschner_lobes = 4;

/// Everything that the azimuthal part depends on beside directions and color.
struct MarschnerShape {
  double eta = 1.55, eccentricity = 0.85;
  MarschnerCaustics caustics;
};

/// N_p at one azimuth as paths: sum of density times attenuation times exp(-sigma_a length). phi_r absolute, phi
/// relative, in [-pi, pi]; theta_d within +-pi/2; radians. `removal` is in the densities of TRT.
MarschnerPaths marschner_paths(const MarschnerShape& shape, MarschnerLobe lobe, double phi_r, double theta_d,
                               double phi);

/// N_p per channel, 1/rad, sigma_a per radius.
glm::vec3 marschner_density(const MarschnerPaths& paths, const glm::vec3& sigma_a);

/// Tables over phi_r in [0, pi/2] (one node where the lobe does not depend on it) and |theta_d|, between whose nodes
/// densities and energies are interpolated linearly. Immutable after construction; any thread.
class MarschnerTable {
 public:
  explicit MarschnerTable(const MarschnerShape& shape);

  /// Nodes of one lobe about a direction: index and share, shares sum to 1.
  struct Place {
    std::array<std::uint32_t, 4> node;
    std::array<float, 4> share;
  };
  /// folded_phi_r in [0, pi/2], theta_d within +-pi/2.
  Place place(MarschnerLobe lobe, float folded_phi_r, float theta_d) const;

  /// Density of sample() at the relative azimuth phi in [-pi, pi], 1/rad: in proportion to N_p of clear hair at the
  /// nodes, with a uniform share.
  float density(MarschnerLobe lobe, const Place& place, float phi) const;
  /// u_node, u in [0, 1). In [-pi, pi).
  float sample(MarschnerLobe lobe, const Place& place, float u_node, float u) const;

  /// Energy of each node under sigma_a per radius, per channel.
  std::vector<glm::vec3> energies(MarschnerLobe lobe, const glm::vec3& sigma_a) const;
  std::size_t bytes() const;

  static constexpr float uniform_share = 0.1f;

 private:
  struct Tables {
    std::uint32_t azimuth_nodes = 1;
    std::vector<PathRule> rule;  ///< by node
    std::vector<float> density;  ///< by node and knot, mass 1
    std::vector<float> below;    ///< mass below each knot
  };
  void fill_node(const MarschnerShape& shape, MarschnerLobe lobe, double phi_r, double theta_d);
  const Tables& of(MarschnerLobe lobe) const { return tables_[static_cast<std::size_t>(lobe)]; }

  std::uint32_t knots_;  ///< intervals of the circle; knots_ + 1 values are stored
  std::array<Tables, marschner_lobes> tables_;
};

/// One table for all fibers that share its shape. One thread.
class MarschnerTables {
 public:
  std::shared_ptr<const MarschnerTable> find(const MarschnerShape& shape);
  std::size_t bytes() const;

 private:
  std::map<std::tuple<double, double, double>, std::shared_ptr<const MarschnerTable>> tables_;
};

}  // namespace tress::inline v0_2::fiber
