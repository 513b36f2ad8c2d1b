// The major axis along a strand: a rotation-minimising frame, turned at the root and by the curl.
#pragma once

#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "scene/model/scene.h"

namespace tress::geometry {

/// The frame at a knot of the strand, as a smooth normal and the angle from it to the major axis. The angle can then be
/// interpolated over any number of revolutions between two knots.
struct KnotFrame {
  glm::vec3 normal;  ///< unit, orthogonal to the strand's tangent at the knot; rotation-minimising along the strand
  float angle;       ///< radians about the tangent from `normal` to the major axis; not wrapped
};

/// Orthonormal and right-handed: u x v = w.
struct FiberFrame {
  glm::vec3 u, v, w;  ///< tangent root to tip, major axis, minor axis
};

/// The normal from which root angles are counted: the world axis least aligned with the tangent (x before y before z),
/// made orthogonal to it. tangent: unit.
glm::vec3 root_normal(const glm::vec3& tangent);

/// The places where the segments of a strand meet, and its two ends: at least two, or none if there are too few points.
struct StrandKnots {
  std::vector<glm::dvec3> position;  ///< in the points' unit, cm
  std::vector<glm::dvec3> tangent;   ///< unit, root to tip
};

/// The knots of a strand with these points, root first. bspline: one for each point, with ends continued by reflection.
/// linear: the points. The tangent at a point of a polygon, and where two Bezier segments meet, halves the bend. If
/// points coincide, the tangent is that of a neighbour.
StrandKnots strand_knots(std::span<const glm::vec3> points, scene::StrandBasis basis);

/// Frames at the knots by double reflection (Wang et al. 2008). The major axis leaves the root at root_angle_rad from
/// root_normal and turns by turn_rad_per_cm times the length of the polygon of knots. turned_rad: the angle by which
/// the strand has been turned about z (scene::Groom::turned_rad). The axes of root_normal turn with it, so that the
/// frames turn, too.
std::vector<KnotFrame> strand_frames(const StrandKnots& knots, double root_angle_rad, double turn_rad_per_cm,
                                     double turned_rad = 0);

/// The same for strand_knots().
std::vector<KnotFrame> strand_frames(std::span<const glm::vec3> points, double root_angle_rad, double turn_rad_per_cm,
                                     scene::StrandBasis basis = scene::StrandBasis::bspline, double turned_rad = 0);

/// Frames of the same strand at a later moment. The normal at the root, from which root angles are counted, follows the
/// strand from its first moment: it turns as the whole has (`turned`), and then by the least rotation that brings its
/// tangent to its new direction. Frames interpolated between the moments are then those of a moving strand. first: its
/// frame at the root at the first moment, where the unit tangent is `first_tangent`.
std::vector<KnotFrame> later_frames(const StrandKnots& knots, const KnotFrame& first, const glm::dvec3& first_tangent,
                                    const glm::dmat3& turned, double turn_rad_per_cm);

/// Turns the frames of a strand (strand_frames() at `knots`) so that their minor axes are those given at its points
/// (unit, or 0 for none; interpolated as the points are). A cross-section looks the same from behind, so an axis also
/// stands for its opposite, and it turns the shorter way from one knot to the next. If a knot has no axis, or one along
/// the tangent (within 0.001 rad), the angle changes evenly between the knots around it and is constant beyond the
/// outermost ones. If no knot has an axis, it returns false and turns nothing.
bool turn_to_minor_axes(const StrandKnots& knots, std::span<const glm::vec3> minor_axis, scene::StrandBasis basis,
                        std::vector<KnotFrame>* frames);

/// The frame between two consecutive knots, at t in [0, 1], for the unit tangent there. Orthonormal for every input.
FiberFrame frame_between(const KnotFrame& a, const KnotFrame& b, float t, const glm::vec3& tangent);

}  // namespace tress::geometry
