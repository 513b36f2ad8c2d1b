// Meshes as Embree's triangles, and the hits on them.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "scene/model/scene.h"

namespace tress::geometry {

/// A point of a triangle, and the distance that keeps rays from hitting the same surface again.
struct SurfacePoint {
  glm::vec3 position;  ///< cm, correctly rounded
  glm::vec3 normal;    ///< unit, by the order of the corners; +z for a triangle without area
  float offset_cm;     ///< > 0: bound of the error of a ray's distance to this plane, and of `position`
};

/// Largest absolute coordinate of a mesh at any moment, cm; rounding errors of its hits scale with it.
float largest_coordinate(const scene::Mesh& mesh);

/// barycentric: weights of the second and third corner. `extent_cm`: largest_coordinate(mesh). time: within the
/// shutter.
SurfacePoint surface_point(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third, float extent_cm,
                           float time = 0);

/// The motion of a point of a mesh, from the opening of the shutter to its closing, cm.
glm::vec3 surface_way(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third);

/// The normal of the mesh interpolated between the corners of a triangle, unit. It is on the side of `normal`, the unit
/// geometric one, from which a ray of this direction comes; it is `normal` if a corner has none. A normal that faces
/// away from the ray is turned until the ray grazes. second, third: as above.
glm::vec3 shading_normal(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third,
                         const glm::vec3& normal, const glm::vec3& ray_direction, float time = 0);

/// The way from a point of a triangle to the smooth surface that the normals of its corners stand for, cm (Hanika 2021,
/// "Hacking the Shadow Terminator"). It is 0 unless the surface is convex there as seen from the side of `normal`:
/// every corner below the tangent planes of the others.
glm::vec3 way_to_smooth(const scene::Mesh& mesh, std::uint32_t triangle, float second, float third,
                        const glm::vec3& normal, float time = 0);

}  // namespace tress::geometry
