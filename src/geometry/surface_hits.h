// Meshes as Embree's triangles, and what a hit on one is.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "scene/model/scene.h"

namespace tress::geometry {

/// A point of a triangle and the distance that keeps rays from meeting the surface again.
struct SurfacePoint {
  glm::vec3 position;  ///< cm, correctly rounded
  glm::vec3 normal;    ///< unit, of the corners' order; +z for a triangle without area
  float offset_cm;     ///< > 0: bound of the error of a ray's distance to this plane, and of `position`
};

/// Largest absolute coordinate of a mesh at any moment, cm: what the rounding of its hits scales with.
float largest_coordinate(const scene::Mesh& mesh);

/// barycentric: weights of the second and third corner. `extent_cm`: largest_coordinate(mesh). time: of the shutter.
SurfacePoint surface_point(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third, float extent_cm,
                           float time = 0);

/// The way of a point of a mesh that moves, from the opening of the shutter to its closing, cm.
glm::vec3 surface_way(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third);

/// The normal of the mesh between the corners of a triangle, unit, towards the side of `normal`, the unit geometric
/// one, that a ray of this direction comes from: `normal` where a corner has none. One that the ray would see from
/// behind is turned until it is seen at grazing. second, third: as above.
glm::vec3 shading_normal(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third,
                         const glm::vec3& normal, const glm::vec3& ray_direction, float time = 0);

}  // namespace tress::geometry
