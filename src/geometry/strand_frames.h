// The major axis along a strand: a rotation-minimising frame, turned at the root and by the curl.
#pragma once

#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "scene/model/scene.h"

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

/// Where the segments of a strand meet, and its two ends: at least two, or none where there are too few points.
struct StrandKnots {
  std::vector<glm::dvec3> position;  ///< as the points, cm
  std::vector<glm::dvec3> tangent;   ///< unit, root to tip
};

/// Knots of a strand of these points, root first. bspline: one a point, its ends continued by reflection; linear: the
/// points, the tangent at one halves the bend; so it does where two Bezier segments meet. Points may coincide: the
/// tangent is then that of a neighbour.
StrandKnots strand_knots(std::span<const glm::vec3> points, scene::StrandBasis basis);

/// Frames at the knots by double reflection (Wang et al. 2008). The major axis leaves the root at root_angle_rad from
/// root_normal and turns by turn_rad_per_cm times the length of the polygon of knots. turned_rad: how far the strand
/// has been turned about z (scene::Groom::turned_rad); the axes of root_normal turn with it, so that the frames do.
std::vector<KnotFrame> strand_frames(const StrandKnots& knots, double root_angle_rad, double turn_rad_per_cm,
                                     double turned_rad = 0);

/// The same of strand_knots().
std::vector<KnotFrame> strand_frames(std::span<const glm::vec3> points, double root_angle_rad, double turn_rad_per_cm,
                                     scene::StrandBasis basis = scene::StrandBasis::bspline, double turned_rad = 0);

/// Of the same strand at a later moment: the normal at the root, which root angles are counted from, follows the strand
/// from its first moment, `turned` as the whole has and then by the least rotation that brings its tangent to where it
/// is, so that frames between the moments are those of a strand on its way. first: its frames at the first moment,
/// whose root has the unit tangent `first_tangent`.
std::vector<KnotFrame> later_frames(const StrandKnots& knots, const KnotFrame& first, const glm::dvec3& first_tangent,
                                    const glm::dmat3& turned, double turn_rad_per_cm);

/// Turns the frames of a strand, those of strand_frames() at `knots`, so that their minor axes are those given at its
/// points (unit, or 0: none there; interpolated as the points are). A cross-section looks the same from behind: an axis
/// stands for its opposite too, and from one knot to the next it turns the shorter way. Where a knot has none, or one
/// along the tangent (within 0.001 rad), the turn goes evenly between the knots around it and rests beyond the
/// outermost ones. False, and nothing is turned, where no knot has an axis.
bool turn_to_minor_axes(const StrandKnots& knots, std::span<const glm::vec3> minor_axis, scene::StrandBasis basis,
                        std::vector<KnotFrame>* frames);

/// Frame between two consecutive knots, at t in [0, 1], for the unit tangent there. Orthonormal for every input.
FiberFrame frame_between(const KnotFrame& a, const KnotFrame& b, float t, const glm::vec3& tangent);

}  // namespace tress::geometry
