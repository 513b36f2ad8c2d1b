// The strands of a groom as the control points of elliptical ribbons.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "intersect/strand_frames.h"
#include "scene/scene.h"

namespace tress::intersect {

/// One groom as Embree sees it. Every strand of n points has n + 2 control points and n - 1 segments; segment with
/// first control point c runs from knot c + 1 to knot c + 2. `frames` has the same indices as `control`.
struct StrandCurves {
  std::uint32_t groom = 0;         ///< index into Scene::grooms
  std::vector<glm::vec4> control;  ///< xyz, cm; w = major semi-axis, cm
  std::vector<KnotFrame> frames;
  std::vector<std::uint32_t> first_control;  ///< per segment
  std::vector<std::uint32_t> strand;         ///< per segment
  std::vector<float> eccentricity;           ///< per segment
  bool elliptical = false;                   ///< some eccentricity is below 1

  /// t in [0, 1] along the segment; tangent: unit.
  FiberFrame frame(std::uint32_t segment, float t, const glm::vec3& tangent) const;
  /// Major semi-axis on a segment, cm: the uniform cubic B-spline of the control values.
  float semi_axis(std::uint32_t segment, float t) const;
  std::size_t bytes() const;
};

/// Strands with less than two distinct points, or with a point that is not finite, have no segments.
StrandCurves strand_curves(const scene::Scene& scene, std::uint32_t groom_index);

}  // namespace tress::intersect
