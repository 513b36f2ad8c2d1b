// Where a groom and its instances are.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <optional>

#include "scene/model/framed_points.h"
#include "scene/model/scene.h"

namespace tress::scene {

/// The bounding box of all points, in the groom's coordinates, at every moment of the shutter; empty without points.
std::optional<Box> box_of_points(const Groom& groom);

/// Calls visit(point) for points of the scene in whose convex hull the points of all instances lie, at every moment of
/// the shutter: the points themselves, or the corners of each instance's box.
void for_each_bounding_point(const Groom& groom, const std::function<void(const glm::vec3&)>& visit);

/// Calls visit(point) for the points that a camera which sees all strands must see when the shutter opens: framed
/// points without those of stray strands, or the corners of the box of each instance's.
void for_each_seen_point(const Groom& groom, const std::function<void(const glm::vec3&)>& visit);

/// The largest scale of the groom's instances, at any moment of the shutter; 1 without any.
float largest_scale(const Groom& groom);

}  // namespace tress::scene
