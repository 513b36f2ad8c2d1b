// The major axis along a strand: a rotation-minimising frame, turned at the root and by the curl (design section 3).
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tress::geometry {

/// The frame at a knot of the strand, kept as a smooth normal and the turn from it to the major axis: the turn can then
/// be interpolated over any number of revolutions between two knots.
struct KnotFrame {
  glm::vec3 normal;  ///< unit, orthogonal to the strand's tangent at the knot; rotation-minimising along the strand
  float angle;       ///< radians about the tangent from `normal` to the major axis; not wrapped
};

/// Orthonormal and right-handed: u x v = w.
struct FiberFrame {
  glm::vec3 u, v, w;  ///< tangent root to tip, major axis, minor axis
};

/// The normal that root angles are counted from: of the world axes the least aligned with the tangent (x before y
/// before z), made orthogonal to it. tangent: unit.
glm::vec3 root_normal(const glm::vec3& tangent);

/// Frames at the knots of a strand, one per point (cm, root first), by double reflection (Wang et al. 2008). linear:
/// the knots are the points, the tangent at one halves the bend; else those of the uniform cubic B-spline of the
/// points, its ends continued by reflection. The major axis leaves the root at root_angle_rad from root_normal and
/// turns by turn_rad_per_cm times the length of the polygon of knots. Points may coincide; all the same: an arbitrary
/// frame.
std::vector<KnotFrame> strand_frames(std::span<const glm::vec3> points, double root_angle_rad, double turn_rad_per_cm,
                                     bool linear = false);

/// Frame between two consecutive knots, at t in [0, 1], for the unit tangent there. Orthonormal for every input.
FiberFrame frame_between(const KnotFrame& a, const KnotFrame& b, float t, const glm::vec3& tangent);

}  // namespace tress::geometry
