// The strands of a groom as the control points, or the points, of elliptical ribbons.
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

/// What a ray that comes near a segment needs of it, in one line of the cache: most rays come near some twenty,
/// anywhere in the groom.
struct alignas(64) StrandSegment {
  KnotFrame from, to;              ///< frames at its knots
  std::array<float, 4> semi_axis;  ///< major, of its control points, cm; of linear strands the first two
  std::uint32_t strand, place;     ///< place: how many segments of the strand are before it
  float eccentricity;
};

/// Frames at the ends of a segment.
struct SegmentFrames {
  KnotFrame from, to;
};

/// One groom as Embree sees it. A strand of n points has n - 1 segments. As a B-spline it has n + 2 control points,
/// and the segment with first control point c runs from knot c + 1 to knot c + 2; linear strands have their n points,
/// and the segment runs from c to c + 1. Open B-splines have their n control points and n - 3 segments; Bezier segments
/// have theirs, and run from c to c + 3. Of strands that move all this is of the shutter's opening; between its moments
/// control points, radii and frames go straight. Times are in [0, 1], 0 where nothing moves.
struct StrandCurves {
  std::uint32_t groom = 0;                   ///< index into Scene::grooms
  std::vector<glm::vec4> control;            ///< xyz, cm; w = major semi-axis, cm
  std::vector<std::uint32_t> first_control;  ///< per segment
  std::vector<StrandSegment> segments;
  std::vector<std::uint32_t> first_segment;                ///< per strand of the groom, and the number of segments
  bool radii_change = false;                               ///< while the shutter is open
  float least_eccentricity = 1;                            ///< of any strand
  scene::StrandBasis basis = scene::StrandBasis::bspline;  ///< of the groom

  std::vector<std::vector<glm::vec4>> later_control;     ///< at the later moments; empty: the groom rests
  std::vector<std::vector<SegmentFrames>> later_frames;  ///< likewise, per segment

  std::size_t moments() const { return 1 + later_control.size(); }
  bool elliptical() const { return least_eccentricity < 1; }
  bool is_linear() const { return basis == scene::StrandBasis::linear; }

  /// t in [0, 1] along the segment; tangent: unit.
  FiberFrame frame(std::uint32_t segment, float t, const glm::vec3& tangent, float time) const;
  /// Major semi-axis on a segment, cm: interpolated as the strand is.
  float semi_axis(std::uint32_t segment, float t, float time) const;
  /// Linear strands: the point of the axis.
  glm::vec3 axis(std::uint32_t segment, float t, float time) const;
  /// The way of a place on the axis, whatever the basis, from the opening of the shutter to its closing, cm.
  glm::vec3 way(std::uint32_t segment, float t) const;
  /// Linear strands, whose segments Embree ends in round caps. Of a ray with unit `direction` that passes nearest to
  /// the segment's end t (0 or 1), at `position`: whether it goes through the wedge that the bend leaves open between
  /// two ribbons. False at the root and the tip, which end flat.
  bool is_in_joint(std::uint32_t segment, float t, const glm::vec3& position, const glm::vec3& direction,
                   float time) const;
  std::size_t bytes() const;

 private:
  glm::vec4 control_at(std::uint32_t index, float time) const;
};

/// Strands with less than two distinct points, with fewer than their basis needs, or with a point that is not finite at
/// any moment, have no segments.
StrandCurves strand_curves(const scene::Scene& scene, std::uint32_t groom_index);

}  // namespace tress::geometry
