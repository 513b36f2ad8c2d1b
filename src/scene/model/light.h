// Lights besides the environment: samples towards them from a point, and hits by rays that were drawn by other means.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <limits>
#include <string>
#include <vector>

#include "scene/model/scene.h"

namespace tress::scene {

/// The distance of a distant light, cm: beyond everything.
constexpr float distant_cm = 1e30f;

/// A direction from a point towards a light.
struct LightSample {
  glm::vec3 direction{0, 0, 1};  ///< unit, world
  float distance = 0;            ///< cm along it to the light, <= distant_cm: anything nearer shadows it
  glm::vec3 radiance{0.0f};      ///< linear RGB that would arrive unshadowed
  float pdf_solid_angle = 0;     ///< 1/sr; 0: no light reaches the point, and the other members are undefined
};

/// Draws a direction towards `light` from `point` (cm); u1, u2 uniform in [0, 1). The density is uniform over the solid
/// angle of the light at the point. For a distant light, a sphere or a spot, that is a cone; inside a sphere, which
/// shines inwards too, it is all directions. For a rectangle it is the spherical rectangle (Urena, Fajardo, King 2013);
/// one of less than 1e-6 sr is drawn by area. Every member is finite for every input, NaN included.
/// Pure; any thread.
LightSample sample_light(const LightShape& light, const glm::vec3& point, float u1, float u2);

/// The light that a ray meets. `pdf_solid_angle` is the density with which sample_light() draws the ray's direction
/// from its origin; it is 0 if the ray misses the light or max_distance ends it before. Pass infinity for a ray that
/// met nothing: only then is a distant light counted. `direction` need not have unit length; `distance` is in cm all
/// the same. Lights do not hide each other. Pure; any thread; finite like sample_light().
LightSample light_along(const LightShape& light, const glm::vec3& origin, const glm::vec3& direction,
                        float max_distance = std::numeric_limits<float>::infinity());

/// A light at time [0, 1] of the shutter: linear from each moment to the next, number by number; directions are made
/// unit and edges square again. If half a turn leaves no direction, that of the moment before is kept.
LightShape light_during(const Light& light, float time);

/// Convert a direction of the environment, at a time of the shutter, to a direction of the world, and back for a
/// look-up.
glm::vec3 turned_with_environment(const Scene& scene, const glm::vec3& direction, float time);
glm::vec3 turned_to_environment(const Scene& scene, const glm::vec3& direction, float time);

/// The direction towards azimuth and elevation, radians. Azimuth 0 is -y (the side of a framed camera); it grows
/// counter-clockwise from above, so that +x is at pi/2. Elevation is from the horizon.
glm::vec3 direction_towards(double azimuth_rad, double elevation_rad);

/// The share of its radiance that a spot sends into a unit direction: 1 within `core`, 0 beyond `cone`, t^2 (3 - 2 t)
/// between them, t linear in the cosine. The same as a spot of pbrt and of Blender (soft edge: `blend`).
double spot_share(const LightShape& light, const glm::vec3& direction);

/// The radiance of a spot of `radius_cm` that gives `irradiance` on a plane across its axis at `distance_cm`, where it
/// is full: E d^2 / (pi r^2), or E / pi within the sphere.
glm::vec3 spot_radiance(const glm::vec3& irradiance, double radius_cm, double distance_cm);

/// The groups of a scene that have layers: names in the order of the environment, then the lights; last `other_lights`
/// for those without a group. Empty if nothing has a group.
constexpr const char* other_lights = "other";
std::vector<std::string> light_groups(const Scene& scene);
/// The index of a name in light_groups(); that of `other_lights` for an empty name, 0 if there are no groups.
std::size_t group_index(const std::vector<std::string>& groups, const std::string& name);
constexpr std::size_t most_light_groups = 16;  ///< most groups of a scene, including `other_lights`
/// Whether it consists of 1 to 64 letters, digits, _ and -.
bool is_group_name(const std::string& name);

/// The radiance of a distant light that gives `irradiance` on a plane across its direction: E / (pi sin^2 half_angle).
glm::vec3 distant_radiance(const glm::vec3& irradiance, double half_angle_rad);

}  // namespace tress::scene
