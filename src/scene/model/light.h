// Lights beside the environment: drawn from a point, and met by a ray that was drawn by other means.
#pragma once

#include <glm/vec3.hpp>
#include <limits>

#include "scene/model/scene.h"

namespace tress::scene {

/// Where a distant light is said to be, cm: past everything.
constexpr float distant_cm = 1e30f;

/// A direction from a point towards a light.
struct LightSample {
  glm::vec3 direction{0, 0, 1};  ///< unit, world
  float distance = 0;            ///< cm along it to the light, <= distant_cm: what lies before it shadows
  glm::vec3 radiance{0.0f};      ///< linear RGB that would arrive unshadowed
  float pdf_solid_angle = 0;     ///< 1/sr; 0: no light reaches the point, the other members say nothing
};

/// Draws a direction towards `light` from `point` (cm); u1, u2 uniform in [0, 1). The density is uniform over the solid
/// angle that the light takes at the point: the cone of a distant light or sphere (all directions inside a sphere,
/// which shines inwards too), the spherical rectangle (Urena, Fajardo, King 2013) of a rectangle; a rectangle of less
/// than 1e-6 sr is drawn by area. Every member is finite for every input, NaN included. Pure; any thread.
LightSample sample_light(const Light& light, const glm::vec3& point, float u1, float u2);

/// What a ray meets of a light: `pdf_solid_angle` is that with which sample_light() draws its direction from its
/// origin, 0 where the ray misses the light or max_distance ends it before. Pass infinity for a ray that met nothing:
/// only then a distant light counts. `direction` need not be of unit length, `distance` is in cm all the same.
/// Lights do not hide each other. Pure; any thread; finite like sample_light().
LightSample light_along(const Light& light, const glm::vec3& origin, const glm::vec3& direction,
                        float max_distance = std::numeric_limits<float>::infinity());

/// Towards azimuth and elevation, radians: azimuth 0 is -y (the side of a framed camera), counter-clockwise from
/// above, so that +x is at pi/2; elevation from the horizon.
glm::vec3 direction_towards(double azimuth_rad, double elevation_rad);

/// Radiance of a distant light that gives `irradiance` on a plane across its direction: E / (pi sin^2 half_angle).
glm::vec3 distant_radiance(const glm::vec3& irradiance, double half_angle_rad);

}  // namespace tress::scene
