// Strands that are there for a share of the rays: alpha, shadows and furnaces whose means are known on paper.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

/// One strand along x through (0, 0, z), as wide as told.
scene::Groom strand_along_x(float z, float radius_cm) {
  scene::Groom groom;
  groom.basis = scene::StrandBasis::linear;
  groom.first_point = {0, 2};
  groom.points = {{-50, 0, z}, {50, 0, z}};
  groom.radius_cm = {radius_cm, radius_cm};
  return groom;
}

void give_presence(float presence, scene::Scene* scene) {
  scene->materials.resize(1);
  scene->materials[0].fiber.eccentricity = 1;
  scene->materials[0].presence = scene::Source{.value = glm::vec3(presence)};
  scene::assign_fibers(scene);
}

TEST(StrandPresence, IsTheAlphaBeforeNothing) {
  scene::Scene scene;
  scene.camera.eye = {0, -6, 0};
  scene.image.width = scene.image.height = 16;
  scene.image.transparent = true;
  scene.grooms = {strand_along_x(0, 20)};
  scene.environment = scene::Environment(glm::vec3(1.0f));
  give_presence(0.5f, &scene);
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  const RenderResult result = render_with(scene, model, fibers, long_paths(64, 41), 2);
  for (const char* name : {"A", "coverage"}) {
    const Mean alpha = mean_of(result, name);
    EXPECT_LE(std::abs(alpha.value - 0.5), z_limit * alpha.error + 1e-6) << name;
    EXPECT_LT(alpha.error, 0.004) << "samples are stratified: 64 independent ones of 256 pixels have as much";
  }
  const Mean light = mean_of(result, "G");  // lossless in a surround of 1, premultiplied
  EXPECT_LT(std::abs(light.value - 0.5), z_limit * light.error);
}

// 3 presences x 3 counts x 3 colors at |z| < 5.
TEST(StrandPresence, LeavesFurnacesOfLosslessFibersAtOne) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  for (const float presence : {0.1f, 0.5f, 0.9f}) {
    scene::Scene scene = tangle(60, 16, 16);
    scene.environment = scene::Environment(glm::vec3(1.0f));
    give_presence(presence, &scene);
    for (const auto& [lights, bcsdfs] : {std::pair(0, 1), std::pair(2, 1), std::pair(1, 3)}) {
      RenderOptions options = long_paths(64, 42);
      options.light_samples = lights;
      options.bcsdf_samples = bcsdfs;
      const RenderResult result = render_with(scene, model, fibers, options, 2);
      for (const char* color : {"R", "G", "B"}) {
        const Mean mean = mean_of(result, color);
        EXPECT_LT(std::abs(mean.value - 1), z_limit * mean.error + 1e-6) << presence << lights << bcsdfs << color;
        EXPECT_LT(mean.error, 0.02);
      }
    }
  }
}

// A black strand before a ball of light, which it hides from the floor but for what is not there of it.
TEST(StrandPresence, LetsTheRestOfTheLightThrough) {
  scene::Scene scene;
  scene.environment = scene::Environment(glm::vec3(0.0f));
  scene.camera.eye = {3, -4, 1};
  scene.camera.vertical_fov_deg = 0.1f;
  scene.image.width = scene.image.height = 16;
  scene::Mesh floor;
  floor.positions = {{-100, -100, 0}, {100, -100, 0}, {100, 100, 0}, {-100, 100, 0}};
  floor.triangles = {{0, 1, 2}, {0, 2, 3}};
  floor.albedo = glm::vec3(0.5f);
  scene.meshes = {floor};
  scene::Light ball;
  ball.kind = scene::Light::Kind::sphere;
  ball.center = {0, 0, 5};
  ball.radius_cm = 1;
  scene.lights = {ball};
  scene.grooms = {strand_along_x(3, 0.8f)};
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber({})};
  for (const float presence : {0.0f, 0.25f, 0.7f, 1.0f}) {
    give_presence(presence, &scene);
    for (const int lights : {0, 1, 4}) {
      RenderOptions options = long_paths(256, 43);
      options.light_samples = lights;
      const Mean mean = mean_of(render_with(scene, model, fibers, options, 2), "R");
      const double expected = (1 - double{presence}) * 0.5 / 25;
      EXPECT_LE(std::abs(mean.value - expected), z_limit * mean.error + 5e-4 * expected) << presence << " " << lights;
      EXPECT_LE(mean.error, 0.1 * expected);
    }
  }
}

TEST(StrandPresence, IsTheSameToTheBitWithAnyNumberOfThreadsAndAbsentWhereItIsOne) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  scene::Scene scene = tangle(60, 40, 33);
  const RenderOptions options = long_paths(8, 44);
  const auto picture_of = [&](float presence, int threads) {
    give_presence(presence, &scene);
    return render_with(scene, model, fibers, options, threads).picture;
  };
  const auto identical = [](const image::Picture& a, const image::Picture& b) {
    return image::compare(a, b, "a", "b")->identical;
  };
  const image::Picture half = picture_of(0.5f, 1), whole = picture_of(1, 1);
  EXPECT_TRUE(identical(half, picture_of(0.5f, 2)));
  EXPECT_FALSE(identical(half, whole));
  scene.materials[0].presence.reset();
  scene::assign_fibers(&scene);
  EXPECT_TRUE(identical(whole, render_with(scene, model, fibers, options, 2).picture));
  EXPECT_TRUE(scene.grooms[0].presence.empty());
}

}  // namespace
}  // namespace tress::integrate
