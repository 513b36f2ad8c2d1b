// The points that tell where strands are and how large: the same for the same strands, whatever they were written as.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "scene/model/scene.h"

namespace tress::scene {

/// Appends points whose convex hull has the curve of one strand. Of B-splines they are the ends of the curve and the
/// control points between them, not those that stand beyond the ends; so they are of Bezier segments that join as a
/// uniform B-spline does. Of other Bezier segments and of polygons they are their points. Strands that are too short
/// for a segment: their points.
void append_framed_points(StrandBasis basis, std::span<const glm::vec3> strand, std::vector<glm::vec3>* out);

/// Calls visit(point) for the framed points of all strands. first_point: as in Groom.
template <class Visit>
void for_each_framed_point(StrandBasis basis, std::span<const std::uint32_t> first_point,
                           std::span<const glm::vec3> points, Visit&& visit) {
  if (basis == StrandBasis::linear || basis == StrandBasis::bspline) {
    for (const glm::vec3& point : points) visit(point);
    return;
  }
  std::vector<glm::vec3> framed;
  for (std::size_t s = 0; s + 1 < first_point.size(); ++s) {
    framed.clear();
    append_framed_points(basis, points.subspan(first_point[s], first_point[s + 1] - first_point[s]), &framed);
    for (const glm::vec3& point : framed) visit(point);
  }
}

struct Box {
  glm::vec3 low{0.0f}, high{0.0f};

  void include(const glm::vec3& point);
  float longest_side() const;
};

/// Of the framed points; nothing where there are none.
std::optional<Box> box_of_strands(StrandBasis basis, std::span<const std::uint32_t> first_point,
                                  std::span<const glm::vec3> points);

}  // namespace tress::scene
