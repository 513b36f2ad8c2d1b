#include "scene/model/groom_bounds.h"

#include <algorithm>

namespace tress::scene {
namespace {

void for_each_corner(const Box& box, const Similarity& place, const std::function<void(const glm::vec3&)>& visit) {
  for (int corner = 0; corner < 8; ++corner)
    visit(place.point({(corner & 1) != 0 ? box.high.x : box.low.x, (corner & 2) != 0 ? box.high.y : box.low.y,
                       (corner & 4) != 0 ? box.high.z : box.low.z}));
}

}  // namespace

std::optional<Box> box_of_points(const Groom& groom) {
  if (groom.points.empty()) return std::nullopt;
  Box box{groom.points.front(), groom.points.front()};
  for (const glm::vec3& point : groom.points) box.include(point);
  for (const StrandMoment& moment : groom.later)
    for (const glm::vec3& point : moment.points) box.include(point);
  return box;
}

void for_each_bounding_point(const Groom& groom, const std::function<void(const glm::vec3&)>& visit) {
  if (groom.instances.empty()) {
    for (const glm::vec3& point : groom.points) visit(point);
    for (const StrandMoment& moment : groom.later)
      for (const glm::vec3& point : moment.points) visit(point);
  } else if (const std::optional<Box> box = box_of_points(groom)) {
    for (const Instance& instance : groom.instances) {
      for_each_corner(*box, instance.first, visit);
      for (const Similarity& later : instance.later) for_each_corner(*box, later, visit);
    }
  }
}

void for_each_seen_point(const Groom& groom, const std::function<void(const glm::vec3&)>& visit) {
  if (groom.instances.empty())
    for_each_framed_point(groom.basis, groom.first_point, groom.points, visit);
  else if (const std::optional<Box> box = box_of_strands(groom.basis, groom.first_point, groom.points))
    for (const Instance& instance : groom.instances) for_each_corner(*box, instance.first, visit);
}

float largest_scale(const Groom& groom) {
  float largest = groom.instances.empty() ? 1 : 0;
  for (const Instance& instance : groom.instances) {
    largest = std::max(largest, instance.first.scale);
    for (const Similarity& later : instance.later) largest = std::max(largest, later.scale);
  }
  return largest;
}

}  // namespace tress::scene
