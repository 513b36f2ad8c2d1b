// Lights and surfaces against values known on paper, and estimators that must agree about them.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"
#include "support/scale.h"

namespace tress::integrate {
namespace {

constexpr double pi = std::numbers::pi;
const glm::vec3 albedo{0.5f, 0.25f, 1.0f};

scene::Light distant(const glm::vec3& direction, float half_angle, float radiance) {
  scene::Light light;
  light.kind = scene::Light::Kind::distant;
  light.direction = glm::normalize(direction);
  light.half_angle_rad = half_angle;
  light.radiance = glm::vec3(radiance);
  return light;
}

scene::Light sphere(const glm::vec3& center, float radius, float radiance) {
  scene::Light light;
  light.kind = scene::Light::Kind::sphere;
  light.center = center;
  light.radius_cm = radius;
  light.radiance = glm::vec3(radiance);
  return light;
}

/// Over the origin at `height`, shining down; half edges a along x, b along y.
scene::Light panel(float height, float a, float b, float radiance) {
  scene::Light light;
  light.kind = scene::Light::Kind::rectangle;
  light.center = {0, 0, height};
  light.edge_u = {a, 0, 0};
  light.edge_v = {0, -b, 0};
  light.radiance = glm::vec3(radiance);
  return light;
}

/// A level square of half side `size` about (x, 0, z).
scene::Mesh square(float size, float x, float z) {
  scene::Mesh mesh;
  mesh.positions = {{x - size, -size, z}, {x + size, -size, z}, {x + size, size, z}, {x - size, size, z}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.albedo = albedo;
  return mesh;
}

/// A matte floor in the dark, of which the camera sees a spot of less than 0.02 cm about the origin.
scene::Scene floor_spot() {
  scene::Scene scene;
  scene.environment = scene::Environment(glm::vec3(0.0f));
  scene.camera.eye = {3, -4, 3};
  scene.camera.vertical_fov_deg = 0.1f;
  scene.image.width = scene.image.height = 24;
  scene.meshes = {square(100, 0, 0)};
  return scene;
}

/// Irradiance of a panel on the level spot under its middle: four rectangles with a corner over the spot (Howell,
/// configuration factor B-3).
double panel_irradiance(double height, double a, double b, double radiance) {
  const double x = a / height, y = b / height, p = std::sqrt(1 + x * x), q = std::sqrt(1 + y * y);
  return 4 * radiance * 0.5 * (x / p * std::atan(y / p) + y / q * std::atan(x / q));
}

/// Sample counts (light, BCSDF) that must all give one mean.
const std::vector<std::pair<int, int>> counts{{0, 1}, {1, 1}, {4, 1}, {1, 3}};

void expect_irradiance(const scene::Scene& scene, double irradiance, int samples, const std::string& what) {
  WhiteFiber model;
  for (const auto& [lights, bcsdfs] : counts) {
    RenderOptions options = long_paths(samples, 21);
    options.light_samples = lights;
    options.bcsdf_samples = bcsdfs;
    const RenderResult result = render_with(scene, model, {}, options, 2);
    const char* colors[] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
      const Mean mean = mean_of(result, std::string("surface.") + colors[c]);
      const double expected = irradiance * static_cast<double>(albedo[c]) / pi;
      // 5e-4: the spot is not a point.
      EXPECT_LT(std::abs(mean.value - expected), z_limit * mean.error + 5e-4 * expected)
          << what << " " << colors[c] << " " << lights << " " << bcsdfs;
      EXPECT_LT(mean.error, 0.05 * expected * test::widened(samples)) << what << ": the test would see nothing";
      EXPECT_EQ(mean_of(result, colors[c]).value, mean.value);
    }
    EXPECT_EQ(mean_of(result, "coverage").value, 1);
  }
}

// 5 lights x 4 counts x 3 colors at |z| < 5: one false alarm in 29,000 runs; the seed is fixed.
TEST(MatteFloor, has_the_irradiance_of_every_light) {
  scene::Scene scene = floor_spot();
  // A cone wholly above the horizon: pi sin^2 cos.
  const double cone = pi * std::pow(std::sin(0.3), 2) * 4 * 0.8;
  scene.lights = {distant({3, 0, 4}, 0.3f, 4)};
  expect_irradiance(scene, cone, 32, "distant");
  // A sphere wholly above the horizon: pi (r/d)^2 cos.
  const double ball = pi * 4 / 25.0 * 2 * 0.6;
  scene.lights = {sphere({0, 4, 3}, 2, 2)};
  expect_irradiance(scene, ball, 32, "sphere");
  const double above = panel_irradiance(2, 3, 1, 1.5);
  scene.lights = {panel(2, 3, 1, 1.5f)};
  expect_irradiance(scene, above, 32, "panel");
  scene.environment = scene::Environment(glm::vec3(0.7f));
  scene.lights = {};
  expect_irradiance(scene, pi * 0.7f, 32, "environment");
  // Together, black ones among them; none shades another.
  scene.lights = {distant({3, 0, 4}, 0.3f, 4), sphere({0, 4, 3}, 2, 2), panel(2, 3, 1, 1.5f),
                  sphere({1, 1, 1}, 0.5f, 0)};
  expect_irradiance(scene, cone + ball + above + pi * 0.7f, 32, "all");
}

TEST(MatteFloor, is_shaded_by_what_is_before_a_light_and_not_by_what_is_behind) {
  WhiteFiber model;
  for (const float height : {2.0f, 8.0f}) {  // of a blocker; the light is 4 to 6 cm up
    scene::Scene scene = floor_spot();
    scene.camera.eye = {3, -4, 1};
    scene.lights = {sphere({0, 0, 5}, 1, 1)};
    scene.meshes.push_back(square(1.5f, 0, height));
    scene.meshes.back().albedo = glm::vec3(0.0f);
    for (const int lights : {0, 4}) {
      RenderOptions options = long_paths(64, 22);
      options.light_samples = lights;
      const Mean mean = mean_of(render_with(scene, model, {}, options, 2), "R");
      const double expected = height < 4 ? 0 : 0.5 / 25;
      EXPECT_LE(std::abs(mean.value - expected), z_limit * mean.error + 5e-4 * expected) << height << " " << lights;
    }
  }
}

TEST(Light, is_not_seen_by_the_camera) {
  scene::Scene scene = floor_spot();
  scene.meshes.clear();
  scene.lights = {sphere({0, 0, 0}, 1, 5), distant({-3, 4, -3}, 0.5f, 5)};
  WhiteFiber model;
  const RenderResult result = render_with(scene, model, {}, long_paths(2, 23));
  for (const char* name : {"R", "coverage", "background.R", "surface.R"})
    EXPECT_EQ(mean_of(result, name).value, 0) << name;
}

TEST(OneFiber, scatters_a_lights_share_of_the_sphere) {
  // White fibers return albedo times the integral of radiance over the sphere of directions, over 4 pi.
  scene::Scene scene;
  scene.environment = scene::Environment(glm::vec3(0.0f));
  scene.camera.eye = {0, -6, 0};
  scene.camera.vertical_fov_deg = 0.2f;
  scene.image.width = scene.image.height = 24;
  scene.materials.resize(1);
  scene.grooms.resize(1);
  scene.grooms[0].first_point = {0, 2};
  scene.grooms[0].points = {{0, 0, -9}, {0, 0, 9}};
  scene.grooms[0].radius_cm = {0.5f, 0.5f};
  scene::assign_fibers(&scene);
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  scene.lights = {distant({1, -2, 1}, 0.4f, 3), sphere({0, -4, 3}, 1, 10)};
  const double expected = 0.5 * (1 - std::cos(0.4)) * 3 + 0.5 * (1 - std::sqrt(1 - 1 / 25.0)) * 10;
  for (const auto& [lights, bcsdfs] : counts) {
    RenderOptions options = long_paths(128, 24);
    options.light_samples = lights;
    options.bcsdf_samples = bcsdfs;
    const Mean mean = mean_of(render_with(scene, model, fibers, options, 2), "R");
    // 1e-3: the spot is 0.02 cm high, 5 cm from the sphere.
    EXPECT_LT(std::abs(mean.value - expected), z_limit * mean.error + 1e-3 * expected) << lights << " " << bcsdfs;
    EXPECT_LT(mean.error, 0.05 * expected * test::widened(128));
  }
}

/// A cube of half side 1/4 in a tangle.
scene::Scene tangle_with_a_cube() {
  scene::Scene scene = tangle(150, 40, 40);
  scene.camera.vertical_fov_deg = 8;
  scene::Mesh cube;
  for (int corner = 0; corner < 8; ++corner) {
    cube.positions.emplace_back(corner & 1 ? 0.25f : -0.25f, corner & 2 ? 0.25f : -0.25f, corner & 4 ? 0.25f : -0.25f);
  }
  cube.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 7, 5}, {4, 6, 7}, {0, 5, 1}, {0, 4, 5},
                    {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  cube.albedo = glm::vec3(1.0f);
  scene.meshes = {cube};
  return scene;
}

TEST(Furnace, of_lossless_fibers_about_a_white_cube_is_one) {
  WhiteFiber model;
  model.matched = 0.9f;  // weights up to 1.04: hundreds of hits multiply them
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  const scene::Scene scene = tangle_with_a_cube();
  for (const auto& [lights, bcsdfs] : counts) {
    RenderOptions options = long_paths(12, 25);
    options.light_samples = lights;
    options.bcsdf_samples = bcsdfs;
    const RenderResult result = render_with(scene, model, fibers, options, 2);
    EXPECT_GT(mean_of(result, "surface.R").value, 0.01) << "the cube is seen";
    for (const char* color : {"R", "G", "B"}) {
      const Mean mean = mean_of(result, color);
      EXPECT_LT(mean.error, 0.02 * test::widened(12));
      EXPECT_LT(std::abs(mean.value - 1), z_limit * mean.error) << color << " " << lights << " " << bcsdfs;
    }
  }
}

TEST(LightSamples, of_any_number_give_one_mean) {
  // A sphere in the middle of the hair, a narrow distant light, a panel and a dim environment: 0, 1 and 4 light samples
  // in three colors, each pair at |z| < 5: one false alarm in 190,000 runs; seeds are fixed.
  fiber::LobeColors shares = lossless_shares();
  for (glm::vec3& lobe : shares) lobe *= 0.8f;
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(shares)};
  scene::Scene scene = tangle_with_a_cube();
  scene.environment = scene::Environment(glm::vec3(0.1f));
  scene.lights = {sphere({0.3f, -0.3f, 0.4f}, 0.15f, 20), distant({1, -2, 1}, 0.2f, 8), panel(2, 0.5f, 1, 3)};
  std::vector<RenderResult> results;
  for (const int lights : {0, 1, 4}) {
    RenderOptions options = long_paths(lights == 0 ? 64 : 16, static_cast<std::uint64_t>(26 + lights));
    options.light_samples = lights;
    results.push_back(render_with(scene, model, fibers, options, 2));
  }
  for (const char* color : {"R", "G", "B"}) {
    for (std::size_t i = 0; i < results.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Mean a = mean_of(results[i], color), b = mean_of(results[j], color);
        // The picture's own variation is in both errors: the true rate is lower.
        EXPECT_LT(std::abs(a.value - b.value), z_limit * std::hypot(a.error, b.error)) << color << " " << i << " " << j;
        EXPECT_LT(a.error, 0.08 * a.value * test::widened(16));
      }
    }
  }
}

}  // namespace
}  // namespace tress::integrate
