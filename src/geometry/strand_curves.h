// The strands of a groom as control points, or points, of elliptical ribbons.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "geometry/strand_frames.h"
#include "scene/model/scene.h"

namespace tress::geometry {

/// The data of a segment for a ray that comes near it, in one cache line: most rays come near some twenty segments,
/// anywhere in the groom.
struct alignas(64) StrandSegment {
  KnotFrame from, to;              ///< frames at its ends
  std::array<float, 4> semi_axis;  ///< major semi-axes at its control points, cm; linear strands use the first two
  std::uint32_t strand, place;     ///< place: number of segments of the strand before this one, joints not counted
  float eccentricity;
  float advance = 1;  ///< by how much the place on the strand grows from end to end: 1, or 0 in a joint

  float place_at(float t) const { return static_cast<float>(place) + t * advance; }
};

/// Frames at the ends of a segment.
struct SegmentFrames {
  KnotFrame from, to;
};

/// Straight pieces that a ribbon's segments are made of. Embree tests as many as these at once, and allows no more.
inline constexpr int least_pieces = 4, most_pieces = 16;

/// One groom in the form for Embree. A strand of n points has n - 1 segments. As a B-spline it has n + 2 control
/// points, and the segment with first control point c runs from knot c + 1 to knot c + 2. A linear strand has its n
/// points, and a segment runs from c to c + 1. An open B-spline has its n control points and n - 3 segments. A Bezier
/// segment runs from c to c + 3. Where two segments meet at an angle, a joint is between them: a segment far shorter
/// than wide that turns from one tangent to the other, so that its ribbon fills the wedge at the outer side of the
/// bend. (Linear strands have is_in_joint() instead.) For strands that move, all this is at the shutter's opening;
/// between moments, control points, radii and frames change linearly. Times are in [0, 1], 0 if nothing moves.
struct StrandCurves {
  std::uint32_t groom = 0;                   ///< index into Scene::grooms
  std::vector<glm::vec4> control;            ///< xyz, cm; w = major semi-axis, cm
  std::vector<std::uint32_t> first_control;  ///< per segment
  std::vector<StrandSegment> segments;
  std::vector<std::uint32_t> first_segment;     ///< per strand of the groom, and the number of segments
  const scene::Groom* with_presence = nullptr;  ///< the groom, if its strands have a presence; else null
  /// Semi-axes of the control points before some were widened (scene::Image::least_width_px), at the shutter's opening;
  /// empty if none was widened.
  std::vector<float> own_axis;
  bool is_sparse = false;                                  ///< whether presence() is below 1 anywhere
  bool radii_change = false;                               ///< whether they change while the shutter is open
  float least_eccentricity = 1;                            ///< the smallest of all strands
  scene::StrandBasis basis = scene::StrandBasis::bspline;  ///< basis of the groom
  /// The number of straight pieces of each segment: enough for image.curve_error_px in all but a thousandth of the
  /// segments.
  int pieces = least_pieces;

  std::vector<std::vector<glm::vec4>> later_control;     ///< at the later moments; empty if the groom does not move
  std::vector<std::vector<SegmentFrames>> later_frames;  ///< at the later moments, per segment

  std::size_t moments() const { return 1 + later_control.size(); }
  bool elliptical() const { return least_eccentricity < 1; }
  bool is_linear() const { return basis == scene::StrandBasis::linear; }

  /// t in [0, 1] along the segment; tangent: unit.
  FiberFrame frame(std::uint32_t segment, float t, const glm::vec3& tangent, float time) const;
  /// Major semi-axis on a segment, cm: interpolated as the strand is.
  float semi_axis(std::uint32_t segment, float t, float time) const;
  /// The probability that a ray hits the segment there, [0, 1]: the groom's presence times its own width over the
  /// widened one.
  float presence(std::uint32_t segment, float t) const;
  /// The point of the axis of a linear strand.
  glm::vec3 axis(std::uint32_t segment, float t, float time) const;
  /// The motion of a place on the axis, in any basis, from the opening of the shutter to its closing, cm.
  glm::vec3 way(std::uint32_t segment, float t) const;
  /// For linear strands, whose segments Embree ends in round caps. The ray with unit `direction` passes nearest to the
  /// segment's end t (0 or 1), at `position`. Returns whether it goes through the wedge that the bend leaves open
  /// between two ribbons. False at the root and the tip, which end flat.
  bool is_in_joint(std::uint32_t segment, float t, const glm::vec3& position, const glm::vec3& direction,
                   float time) const;
  std::size_t bytes() const;

 private:
  /// The strand's own semi-axes at the control points of a segment, four or two.
  float interpolated(const std::array<float, 4>& a, float t) const;
  glm::vec4 control_at(std::uint32_t index, float time) const;
};

/// Strands with less than two distinct points, with fewer than their basis needs, or with a point that is not finite at
/// any moment, have no segments. If the scene has a least width, control points are widened to it as its camera sees
/// them when the shutter opens, and at later moments by the same factors; a strand of width 0 keeps it. The
/// nearest of a groom's instances decides.
StrandCurves strand_curves(const scene::Scene& scene, std::uint32_t groom_index);

}  // namespace tress::geometry
