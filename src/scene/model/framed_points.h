// The points that give position and size of strands: equal for equal strands, whatever their representation.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "scene/model/scene.h"

namespace tress::scene {

/// Appends points whose convex hull contains the curve of one strand. For B-splines they are the ends of the curve and
/// the control points between them, without those beyond the ends; the same holds for Bezier segments that join as a
/// uniform B-spline. For other Bezier segments and for polygons they are the points themselves, and also for strands
/// that are too short for a segment.
void append_framed_points(StrandBasis basis, std::span<const glm::vec3> strand, std::vector<glm::vec3>* out);

/// The strands that lie far from all others, by rising index. Such a strand has a point that is outside the middle four
/// fifths of the strands, along an axis, by more than ten times their extent. Empty if these would be more than a tenth
/// of all, or if there are fewer than five strands. One or two broken strands must not decide how large a groom is.
std::vector<std::uint32_t> stray_strands(std::span<const std::uint32_t> first_point, std::span<const glm::vec3> points);

/// Calls visit(point) for the framed points of all strands except strays. first_point: as in Groom.
template <class Visit>
void for_each_framed_point(StrandBasis basis, std::span<const std::uint32_t> first_point,
                           std::span<const glm::vec3> points, Visit&& visit) {
  const std::vector<std::uint32_t> stray = stray_strands(first_point, points);
  auto next = stray.begin();
  std::vector<glm::vec3> framed;
  for (std::size_t s = 0; s + 1 < first_point.size(); ++s) {
    if (next != stray.end() && *next == s) {
      ++next;
      continue;
    }
    const auto strand = points.subspan(first_point[s], first_point[s + 1] - first_point[s]);
    const bool are_points = basis == StrandBasis::linear || basis == StrandBasis::bspline;
    framed.clear();
    if (!are_points) append_framed_points(basis, strand, &framed);
    for (const glm::vec3& point : are_points ? strand : std::span<const glm::vec3>(framed)) visit(point);
  }
}

struct Box {
  glm::vec3 low{0.0f}, high{0.0f};

  void include(const glm::vec3& point);
  float longest_side() const;
};

/// The bounding box of the framed points, without those of stray strands; empty without points.
std::optional<Box> box_of_strands(StrandBasis basis, std::span<const std::uint32_t> first_point,
                                  std::span<const glm::vec3> points);

}  // namespace tress::scene
