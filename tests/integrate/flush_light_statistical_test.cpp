// Lights that lie in a mesh, a ten-thousandth of the scene before it, and as far behind it.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/ext/matrix_double3x3.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <sstream>

#include "integrate/light_sampler.h"
#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double gap = 1e-4;  ///< 0.1 mm in a scene of a meter

/// Where a scene of unit size stands.
struct Place {
  double scale = 1;
  bool turned = false;
  glm::dvec3 middle{0.0};  ///< in units of the scene

  glm::dmat3 axes() const {
    if (!turned) return glm::dmat3(1.0);
    const glm::dvec3 z = glm::normalize(glm::dvec3(0.3, -0.5, 0.7)), x = glm::normalize(glm::cross({0.1, 1, 0}, z));
    return {x, glm::cross(z, x), z};
  }
  glm::vec3 direction(const glm::dvec3& v) const { return glm::vec3(axes() * v); }
  glm::vec3 edge(const glm::dvec3& v) const { return glm::vec3(scale * (axes() * v)); }
  glm::vec3 point(const glm::dvec3& v) const { return glm::vec3(scale * (axes() * v + middle)); }
  std::string name() const {
    std::ostringstream text;
    text << "scale " << scale << (turned ? " turned" : "") << " at " << middle.x << ' ';
    return text.str();
  }
};

/// 7 sizes, from a hundredth of a millimeter to a hundred meters; three of them far from the origin.
std::vector<Place> places() {
  std::vector<Place> all;
  for (const double scale : {1e-3, 1.0, 1e2, 1e4}) all.push_back({scale, scale > 1 && scale < 1e4});
  all.push_back({1e-3, true, {10, -7, 3}});
  all.push_back({1e2, false, {-10, 4, 9}});
  all.push_back({1e4, true, {10, 10, 10}});
  return all;
}

scene::Mesh square(const Place& place, double size, double height) {
  scene::Mesh mesh;
  for (const glm::dvec2 corner : {glm::dvec2(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
    mesh.positions.push_back(place.point({size * corner.x, size * corner.y, height}));
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.albedo = glm::vec3(1.0f);
  return mesh;
}

/// A white floor in the dark, of which the camera sees next to a point.
scene::Scene floor_spot(const Place& place) {
  scene::Scene scene;
  scene.environment = scene::Environment(glm::vec3(0.0f));
  scene.camera.eye = place.point({0.3, -0.4, 0.3});
  scene.camera.look_at = place.point(glm::dvec3(0.0));
  scene.camera.vertical_fov_deg = 0.1f;
  scene.image.width = scene.image.height = 24;
  scene.meshes = {square(place, 1, 0)};
  return scene;
}

constexpr double half_width = 0.4, half_depth = 0.3, radius = 0.25;

/// Over the spot, shining down.
scene::Light panel(const Place& place, double height) {
  scene::Light light;
  light.kind = scene::Light::Kind::rectangle;
  light.center = place.point({0, 0, height});
  light.edge_u = place.edge({half_width, 0, 0});
  light.edge_v = place.edge({0, -half_depth, 0});
  return light;
}

scene::Light ball(const Place& place, double height) {
  scene::Light light;
  light.kind = scene::Light::Kind::sphere;
  light.center = place.point({0, 0, height});
  light.radius_cm = static_cast<float>(place.scale * radius);
  return light;
}

/// Radiance of the spot under a panel of radiance 1 (Howell, configuration factor B-3), or a ball.
double under_panel(double height) {
  const double x = half_width / height, y = half_depth / height, p = std::sqrt(1 + x * x), q = std::sqrt(1 + y * y);
  return 2 / pi * (x / p * std::atan(y / p) + y / q * std::atan(x / q));
}
double under_ball(double height) { return radius * radius / (height * height); }

/// By light samples and without; 0 is 0 to the bit. Of a spot that is not a point, and is rounded to floats, 1e-3.
void expect_radiance(const scene::Scene& scene, double expected, const std::string& what) {
  WhiteFiber model;
  for (const int lights : {0, 1}) {
    RenderOptions options = long_paths(lights == 0 ? 32 : 8, 41);
    options.light_samples = lights;
    options.shadow_roulette = false;  // a wall under even light has no noise to spare for it
    options.max_depth = 1;
    const Mean mean = mean_of(render_with(scene, model, {}, options, 2), "surface.G");
    EXPECT_LE(std::abs(mean.value - expected), z_limit * mean.error + 1e-3 * expected)
        << what << (lights == 0 ? " met" : " drawn") << ", error " << mean.error;
    if (expected > 0) {
      EXPECT_LT(mean.error, (lights == 0 ? 0.05 : 0.01) * expected) << what << ": the test would see nothing";
    } else {
      EXPECT_EQ(mean.value, 0) << what << (lights == 0 ? " met" : " drawn");
    }
  }
}

// 7 places x 5 bright scenes x 2 ways at |z| < 5: one false alarm in 24,000 runs; the seed is fixed. Shadow rays that
// end at the light itself leave a flush panel a tenth to nine tenths of its light, a twentieth of the bound 0.96.
TEST(FlushLight, a_mesh_in_its_surface_does_not_shade_it) {
  for (const Place& place : places()) {
    scene::Scene scene = floor_spot(place);
    scene.meshes.push_back(square(place, 1.5, 1));
    scene.lights = {panel(place, 1)};
    expect_radiance(scene, under_panel(1), place.name() + "panel, flush");
    scene.lights = {panel(place, 1 - gap)};
    expect_radiance(scene, under_panel(1 - gap), place.name() + "panel, before");
    scene.lights = {ball(place, 1 - radius)};
    expect_radiance(scene, under_ball(1 - radius), place.name() + "ball, touching");
    scene.lights = {ball(place, 1 - radius + gap)};
    expect_radiance(scene, under_ball(1 - radius + gap), place.name() + "ball, through by a little");
    scene.lights = {ball(place, 1)};  // what is seen of it from its axis is before its middle
    expect_radiance(scene, under_ball(1), place.name() + "ball, half through");
  }
}

TEST(FlushLight, a_mesh_before_it_shades_it) {
  for (const Place& place : places()) {
    scene::Scene scene = floor_spot(place);
    scene.meshes.push_back(square(place, 1.5, 1));
    scene.lights = {panel(place, 1 + gap)};
    expect_radiance(scene, 0, place.name() + "panel, behind");
    scene.lights = {ball(place, 1 + radius + gap)};
    expect_radiance(scene, 0, place.name() + "ball, behind");
    // Flush with one mesh and hidden by another, which is as near to the light, or to where the rays start.
    scene.lights = {panel(place, 1)};
    for (const double height : {1 - gap, 0.5, 2e-2}) {
      scene.meshes.push_back(square(place, 0.5, height));
      // The camera looks beneath it.
      if (height < 0.1) scene.camera.eye = place.point({0, -0.9, 4e-3});
      expect_radiance(scene, 0, place.name() + "panel, hidden");
      scene.meshes.pop_back();
    }
  }
}

/// The distances between what is distinguished, and what a shadow ray of another light looks like: untouched.
TEST(FlushLight, the_bound_is_small_and_of_lights_that_touch_meshes_alone) {
  for (const Place& place : places()) {
    scene::Scene scene = floor_spot(place);
    scene.meshes.push_back(square(place, 1.5, 1));
    const glm::vec3 spot = place.point(glm::dvec3(0.0));
    for (const auto& light : {panel(place, 1), ball(place, 1 - radius), ball(place, 1)}) {
      const double bound = LightClearance(light, scene, SceneSize(scene)).bound_cm(spot, place.scale);
      EXPECT_GT(bound, 0) << place.name();
      EXPECT_LT(bound, 0.5 * gap * place.scale) << place.name();
    }
    for (const auto& light : {panel(place, 0.9), ball(place, 0.5), ball(place, 2)}) {
      const LightClearance clearance(light, scene, SceneSize(scene));
      EXPECT_EQ(clearance.bound_cm(spot, place.scale), 0) << place.name();
      const glm::vec3 up = place.direction({0, 0, 1});
      const LightClearance::Segment shadow = clearance.shadow(spot, up, 0.75f);
      EXPECT_EQ(shadow.direction, up);
      EXPECT_EQ(shadow.distance_cm, 0.75f);
    }
  }
  const scene::Scene scene = floor_spot({});
  EXPECT_EQ(LightClearance(scene::Light{}, scene, SceneSize(scene)).bound_cm(glm::vec3(1.0f), 1e30), 0);
}

}  // namespace
}  // namespace tress::integrate
