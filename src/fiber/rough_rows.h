// The rough fiber as a target that is known by samples: its draws, the nodes of its rows, and the choice of a node for
// a direction.
#pragma once

#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "tress/adaptive/mixture.h"
#include "tress/adaptive/sampled_target.h"
#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// SliceKey::lobe of slices of the rough target. Their parameters are {eta, eccentricity, roughness, tilt} and
/// TracedParts::values(): the medulla's radius, scattering, asymmetry and absorption, 0 without a medulla, the cortex's
/// scattering and asymmetry, and the wetness. Change this number whenever the mean of
/// a node's draws changes, so that rows of old caches are not used. Different draws with the same mean need no new
/// number, because a row is tested on draws that it has not seen.
constexpr std::uint32_t rough_slice_lobe = 16;

/// Parts of a node: R, TT, TRT and all that leaves later.
constexpr std::uint32_t rough_parts = 4;
constexpr std::uint32_t rough_part(int order) {
  return order < 3 ? static_cast<std::uint32_t>(order) : rough_parts - 1;
}

/// The position of an inclination along the axis: asinh(tan theta), as in Mercator's map. theta within +-pi/2; at most
/// 12 away from 0.
float height_of(float theta);
/// The height of the specular cone theta_i = -theta_r.
inline float specular_height(float theta_r) { return height_of(-theta_r); }
/// The inverse: theta in [-pi/2, pi/2].
float theta_of(float height);

/// Draws split paths without a length limit, at wr = (theta_r, phi_r) = (a, b). Scrambled Sobol points give h and the
/// first three facets; all further numbers come from a stream for each path. Exits of RoughPaths are at
///  azimuth = phi_i - phi_r,  height = height_of(theta_i) - specular_height(theta_r),
/// with the weight of clear light (minus what a medulla absorbs) and the path length in the cortex, in major semi-axes,
/// as attribute. Weights have the mean of RoughFiber::trace(), where absorption leaves exp(-sigma_a way) of them. (a,
/// b) need not be a node.
///
/// draw_sets() takes less time than four calls of draw(). The exits of a path are the same up to rounding on every
/// instruction set. On one instruction set they have the same bits, apart from their order, whatever else the call
/// draws. Its model name is that of make_elliptical_target(), so that one service can learn both. Stateless; any
/// thread.
std::unique_ptr<adaptive::SampledTarget> make_rough_target();

/// Steps of axis_b from one azimuth of the coarse grid to the next; 0 for a round fiber. The rounder a fiber, the less
/// it changes with the azimuth.
int coarse_azimuth_step(float eccentricity);

/// The slice of a fiber. axis_a is theta_r: 0 to 85 degrees in steps of 5, and 87.5, of both signs if there is a tilt.
/// axis_b is phi_r: 0 to 90 degrees in steps of 7.5, only 0 for a round fiber. Its one coarse grid has theta_r 0, 20,
/// 40, 50, 60, 70, 75, 80 and 87.5 degrees, of both signs if axis_a is, and every coarse_azimuth_step() of axis_b.
adaptive::SliceDescription rough_slice(const FiberParameters& fiber);

/// A node, and the conversion of directions to its coordinates.
struct RoughNode {
  std::uint32_t a = 0, b = 0;  ///< indices into the axes
  float azimuth_sign = 1;      ///< -1: the row's azimuths are mirrored
  float height_sign = 1;       ///< -1: the row's heights are mirrored

  /// Convert directions about the fiber to places in the row and back. Radians; phi in [-pi, pi).
  float azimuth(float phi_i, float phi_r) const { return adaptive::wrap_angle(azimuth_sign * (phi_i - phi_r)); }
  float phi(float azimuth, float phi_r) const { return adaptive::wrap_angle(phi_r + azimuth_sign * azimuth); }
  float height(float theta_i, float theta_r) const {
    return height_sign * (height_of(theta_i) - specular_height(theta_r));
  }
  float theta(float height, float theta_r) const { return theta_of(height_sign * height + specular_height(theta_r)); }
};

/// Chooses nodes of a rough_slice() at random, such that the expected value of a function of the node is its linear
/// interpolation in theta_r and in phi_r. Directions are folded by the symmetries of the ellipse and, without a tilt,
/// of the cylinder. Beyond 87.5 degrees it is the last node. Heights are relative to the specular cone of the true
/// theta_r, not of the node's, so RoughNode takes the true one. Immutable; any thread.
class RoughGrid {
 public:
  explicit RoughGrid(const adaptive::SliceDescription& slice);
  /// wr: theta within +-pi/2, phi any turn; xi uniform in [0, 1).
  RoughNode choose(const FiberDirection& wr, float xi1, float xi2) const;
  /// The xi1 and the xi2 at which choose() changes to another node, for theta within +-pi/2 and phi any turn.
  struct Steps {
    float xi1, xi2;  ///< [0, 1]
  };
  Steps steps(const FiberDirection& wr) const;
  /// The direction of a node; its index is a * axis_b + b.
  FiberDirection direction(std::uint32_t node) const;

 private:
  /// The index of the node below, and the way to the next one, which is 1 or more beyond the last.
  struct Along {
    std::uint32_t below;
    float past, step;
  };
  Along along_thetas(float theta) const;
  float along_phis(float folded_phi) const {
    return folded_phi * static_cast<float>(last_phi_ / (std::numbers::pi / 2));
  }

  std::vector<float> thetas_;
  std::uint32_t last_phi_;
};

}  // namespace tress::inline v0_2::fiber
