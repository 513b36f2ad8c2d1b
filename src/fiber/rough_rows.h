// The rough fiber as a target that is known by samples: what its rows are learned from, on which nodes, and how a
// direction finds its node.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "tress/adaptive/mixture.h"
#include "tress/adaptive/sampled_target.h"
#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::fiber {

/// SliceKey::lobe of slices of the rough target; its parameters are {eta, eccentricity, roughness, tilt} and the
/// medulla's radius, scattering, asymmetry and absorption, 0 where there is none. To be changed whenever what the draws
/// of a node have in the mean changes: rows of old caches are then left alone. Other draws of the same light are no
/// reason: a row is held to draws that it has not seen.
constexpr std::uint32_t rough_slice_lobe = 16;

/// Parts of a node: R, TT, TRT and all that leaves later.
constexpr std::uint32_t rough_parts = 4;
constexpr std::uint32_t rough_part(int order) {
  return order < 3 ? static_cast<std::uint32_t>(order) : rough_parts - 1;
}

/// The place of an inclination along the axis: asinh(tan theta), Mercator's. theta within +-pi/2, at most 12 away from
/// 0.
float height_of(float theta);
/// Of the specular cone theta_i = -theta_r.
inline float specular_height(float theta_r) { return height_of(-theta_r); }
/// The inverse: theta in [-pi/2, pi/2].
float theta_of(float height);

/// Split paths without an end, at wr = (theta_r, phi_r) = (a, b), on scrambled Sobol points: h and the first three
/// facets, the rest by a stream a path. Exits of RoughPaths at
///   azimuth = phi_i - phi_r,  height = height_of(theta_i) - specular_height(theta_r),
/// the weight of clear light (less what a medulla absorbs), the way in the cortex in major semi-axes as attribute.
/// Weights have the mean of what RoughFiber::trace() gives, which absorption takes exp(-sigma_a way) of. (a, b) need
/// not be a node. draw_sets() takes less time than draw() four times. The exits of a path are the same up to rounding
/// on every instruction set, and the same bits on one, their order aside, whatever is drawn beside it. Its model name
/// is that of make_elliptical_target(), so that one service learns both. Stateless; any thread.
std::unique_ptr<adaptive::SampledTarget> make_rough_target();

/// The nodes of a fiber. axis_a: theta_r, 0 to 85 degrees in steps of 5 and 87.5, of both signs where there is a tilt.
/// axis_b: phi_r, 0 to 90 degrees in steps of 7.5; 0 alone for a round fiber.
adaptive::SliceDescription rough_slice(const FiberParameters& fiber);

/// A node, and how directions are told there.
struct RoughNode {
  std::uint32_t a = 0, b = 0;  ///< indices into the axes
  float azimuth_sign = 1;      ///< -1: the row has the azimuths mirrored
  float height_sign = 1;       ///< -1: it has the heights mirrored

  /// From directions about the fiber to places in the row and back. Radians; phi in [-pi, pi).
  float azimuth(float phi_i, float phi_r) const { return adaptive::wrap_angle(azimuth_sign * (phi_i - phi_r)); }
  float phi(float azimuth, float phi_r) const { return adaptive::wrap_angle(phi_r + azimuth_sign * azimuth); }
  float height(float theta_i, float theta_r) const {
    return height_sign * (height_of(theta_i) - specular_height(theta_r));
  }
  float theta(float height, float theta_r) const { return theta_of(height_sign * height + specular_height(theta_r)); }
};

/// Chooses nodes of a rough_slice(): on average over xi a function given at the nodes is interpolated linearly in
/// theta_r and in phi_r, folded by the symmetries of the ellipse and, without a tilt, of the cylinder. Beyond 87.5
/// degrees it is the last node. The light is moved along the axis by the specular cone of the true theta_r: RoughNode
/// takes that, not the node's. Immutable; any thread.
class RoughGrid {
 public:
  explicit RoughGrid(const adaptive::SliceDescription& slice);
  /// wr: theta within +-pi/2, phi of any turn; xi uniform in [0, 1).
  RoughNode choose(const FiberDirection& wr, float xi1, float xi2) const;
  /// Where a node is; index a * axis_b + b.
  FiberDirection direction(std::uint32_t node) const;

 private:
  std::vector<float> thetas_;
  std::uint32_t last_phi_;
};

}  // namespace tress::fiber
