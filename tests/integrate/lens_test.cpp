// Depth of field and what the camera sees beside hair: lights, mattes, meshes that are not there for it.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <string>

#include "integrate/camera_rays.h"
#include "integrate/white_fiber.h"
#include "tress/base/random.h"

namespace tress::integrate {
namespace {

const std::vector<float>& pixels_of(const RenderResult& result, const std::string& name) {
  const image::Channel* found = result.picture.find(name);
  EXPECT_TRUE(found) << name;
  return found->pixels;
}

RenderOptions some_samples(int samples) {
  RenderOptions options;
  options.samples = samples;
  options.max_depth = 20;
  options.seed = 3;
  return options;
}

RenderResult result_of(const scene::Scene& scene, int samples = 8) {
  WhiteFiber model;
  return render_with(scene, model, {model.add_fiber(lossless_shares())}, some_samples(samples));
}

scene::Camera with_lens(int blades) {
  scene::Camera camera;
  camera.lens_radius_cm = 2;
  camera.focus_cm = 60;
  camera.blades = blades;
  camera.blade_rotation_rad = 0.3f;
  return camera;
}

/// Where the rays of a pixel leave, in lens radii: inside the polygon, with the second moments of a uniform one, 1/4 of
/// a disk and (2 + cos(2 pi / n)) / 12 of n corners; and all of them through the same point of the plane in focus.
TEST(Lens, IsDrawnUniformlyAndSharpInThePlaneInFocus) {
  constexpr int draws = 20000;
  for (const int blades : {0, 3, 5, 8}) {
    const CameraRays rays(with_lens(blades), {});
    RandomStream random(1);
    double x = 0, z = 0, xx = 0, zz = 0, xz = 0;
    const double step = 2 * std::numbers::pi / std::max(blades, 3);
    for (int i = 0; i < draws; ++i) {
      const float u = random.next(), v = random.next();
      const geometry::Ray ray = rays.ray(256, 100, {0.5f, 0.5f}, {u, v});
      const glm::vec3 lens = (ray.origin - glm::vec3(0, -60, 0)) / 2.0f;
      EXPECT_NEAR(lens.y, 0, 1e-6f);
      EXPECT_LE(std::hypot(lens.x, lens.z), 1.00001);
      if (blades > 0) {
        const double turn = std::atan2(double{lens.z}, double{lens.x}) - static_cast<double>(0.3f);
        const double from_edge = std::remainder(turn - step / 2, step);  // to the middle of an edge
        EXPECT_LE(std::hypot(lens.x, lens.z) * std::cos(from_edge), std::cos(step / 2) + 1e-5);
      }
      const glm::vec3 sharp = ray.origin + ray.direction * (-ray.origin.y / ray.direction.y);
      const geometry::Ray middle = rays.ray(256, 100, {0.5f, 0.5f}, {0.5f, 0.5f});
      if (blades == 0) {
        const glm::vec3 same = middle.origin + middle.direction * (-middle.origin.y / middle.direction.y);
        EXPECT_LT(glm::distance(sharp, same), 1e-4f);
      }
      x += lens.x, z += lens.z, xx += lens.x * lens.x, zz += lens.z * lens.z, xz += lens.x * lens.z;
    }
    const double moment = blades == 0 ? 0.25 : (2 + std::cos(step)) / 12;
    // 5 standard errors of a mean of values within 1.
    const double error = 5 / std::sqrt(double{draws}) * 0.5;
    EXPECT_NEAR(x / draws, 0, error) << blades;
    EXPECT_NEAR(z / draws, 0, error) << blades;
    EXPECT_NEAR(xx / draws, moment, error) << blades;
    EXPECT_NEAR(zz / draws, moment, error) << blades;
    EXPECT_NEAR(xz / draws, 0, error) << blades;
  }
}

scene::Light ball(const glm::vec3& center, float radius_cm, const glm::vec3& radiance) {
  scene::Light light;
  light.kind = scene::Light::Kind::sphere;
  light.center = center;
  light.radius_cm = radius_cm;
  light.radiance = radiance;
  light.visible = true;
  return light;
}

/// A picture of one ball before nothing: hair is out of view.
scene::Scene ball_alone(float depth_cm) {
  scene::Scene scene = tangle(1, 64, 64);
  for (glm::vec3& point : scene.grooms[0].points) point.z += 1000;
  scene.camera.eye = {0, 0, 0};
  scene.camera.look_at = {0, 60, 0};
  scene.camera.vertical_fov_deg = 10;
  scene.environment = scene::Environment(glm::vec3(0.0f));
  scene.lights = {ball({0, depth_cm, 0}, 0.008f * depth_cm, glm::vec3(1.0f))};
  return scene;
}

struct Spread {
  double light = 0, x = 0, y = 0, xx = 0, yy = 0;  ///< of the picture; means in pixels
};
Spread spread_of(const std::vector<float>& pixels) {
  Spread s;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const double x = static_cast<double>(i % 64), y = static_cast<double>(i / 64), light = pixels[i];
    s.light += light, s.x += light * x, s.y += light * y, s.xx += light * x * x, s.yy += light * y * y;
  }
  s.x /= s.light, s.y /= s.light;
  s.xx = s.xx / s.light - s.x * s.x;
  s.yy = s.yy / s.light - s.y * s.y;
  return s;
}

/// Thin lens: a point at depth D is a disk of the radius R = r f |D - F| / (D F) on the sensor at distance f, which is
/// r |D - F| / (D F) over the size of a pixel at distance 1. The second moment of a disk is R^2 / 4 along each axis;
/// the ball's own disk and the filter, a tent of variance 1/6, add theirs. Some 3,500 of the rays meet the ball, whose
/// second moment is then good to 1.7 %: 8 % are 4.7 standard errors, at a fixed seed.
TEST(Lens, BlursAPointToTheCircleOfAThinLens) {
  const double pixel = 2 * std::tan(5 * std::numbers::pi / 180) / 64;
  const auto in_focus = spread_of(pixels_of(result_of(ball_alone(60), 128), "emission.R"));
  for (const double depth : {30.0, 90.0, 200.0}) {
    scene::Scene scene = ball_alone(static_cast<float>(depth));
    scene.camera.lens_radius_cm = 0.9f;
    scene.camera.focus_cm = 60;
    const RenderResult result = result_of(scene, 128);
    const Spread spread = spread_of(pixels_of(result, "emission.R"));
    const double radius = 0.9 * std::abs(depth - 60) / (depth * 60) / pixel, own = 0.008 / pixel;
    const double expected = radius * radius / 4 + own * own / 4 + 1.0 / 6;
    EXPECT_NEAR(spread.xx, expected, 0.08 * expected) << depth;
    EXPECT_NEAR(spread.yy, expected, 0.08 * expected) << depth;
    EXPECT_NEAR(spread.x, 31.5, 0.5);
    EXPECT_NEAR(spread.light, in_focus.light, 0.1 * in_focus.light) << "blur moves light, and makes none";
  }
  // In focus the lens changes nothing but what is before and behind.
  scene::Scene sharp = ball_alone(60);
  sharp.camera.lens_radius_cm = 0.9f;
  sharp.camera.focus_cm = 60;
  EXPECT_NEAR(spread_of(pixels_of(result_of(sharp, 128), "emission.R")).xx, in_focus.xx, 0.08 * in_focus.xx);
}

/// A bright point behind the focus is a picture of the lens, upright; before it, upside down.
TEST(Lens, AHighlightHasTheCornersOfTheBlades) {
  for (const auto& [depth, side] : {std::pair(200.0f, 1.0), std::pair(36.0f, -1.0)}) {
    scene::Scene scene = ball_alone(depth);
    scene.camera.lens_radius_cm = 1.6f;
    scene.camera.focus_cm = 60;
    scene.camera.blades = 3;  // a corner to the right: more than half of the triangle's width is right of its middle
    const std::vector<float> pixels = pixels_of(result_of(scene, 64), "emission.R");
    const double middle = spread_of(pixels).x;
    double cubes = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i)
      cubes += static_cast<double>(pixels[i]) * std::pow(static_cast<double>(i % 64) - middle, 3);
    EXPECT_GT(side * cubes, 0) << depth;
  }
}

/// Rays of an orthographic camera are parallel: a thing is as large at any distance.
TEST(Camera, OrthographicSizesDoNotDependOnDepth) {
  for (const float depth : {20.0f, 2000.0f}) {
    scene::Scene scene = ball_alone(60);
    scene.lights = {ball({1, depth, 0}, 2, glm::vec3(1.0f))};
    scene.camera.orthographic_height_cm = 8;
    const Spread spread = spread_of(pixels_of(result_of(scene, 16), "emission.R"));
    EXPECT_NEAR(spread.light, std::numbers::pi * 4 * 64, 0.02 * std::numbers::pi * 4 * 64);  // 8 pixels a cm
    EXPECT_NEAR(spread.x, 31.5 + 8, 0.1);
  }
}

/// Two triangles across y, from x = left on, facing either side.
scene::Mesh wall(float left, float y) {
  scene::Mesh mesh;
  mesh.positions = {{left, y, -9}, {9, y, -9}, {9, y, 9}, {left, y, 9}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.albedo = glm::vec3(0.5f);
  return mesh;
}

scene::Light card(float y, const glm::vec3& radiance) {
  scene::Light light;
  light.kind = scene::Light::Kind::rectangle;
  light.center = {0, y, 0};
  light.edge_u = {20, 0, 0};
  light.edge_v = {0, 0, 20};  // shines towards u x v = -y
  light.radiance = radiance;
  return light;
}

TEST(Camera, SeesAVisibleLightWithExactlyItsRadianceFromTheSideThatItShinesTo) {
  scene::Scene scene = tangle(60, 24, 24);
  const glm::vec3 radiance(3, 0.7f, 11);
  for (const bool transparent : {false, true}) {
    scene.image.transparent = transparent;
    scene.lights = {card(5, radiance)};  // behind the hair, all over the picture
    EXPECT_EQ(result_of(scene).picture.find("emission.R"), nullptr) << "a light is not seen by default";
    scene.lights[0].visible = true;
    const RenderResult behind = result_of(scene);
    for (std::size_t i = 0; i < 24 * 24; ++i) {
      EXPECT_EQ(pixels_of(behind, "A")[i], 1);
      const float seen = 1 - pixels_of(behind, "coverage")[i];
      EXPECT_NEAR(pixels_of(behind, "emission.R")[i], 3 * seen, 1e-5f);
      EXPECT_NEAR(pixels_of(behind, "emission.B")[i], 11 * seen, 1e-5f);
      EXPECT_EQ(pixels_of(behind, "background.R")[i], 0);
      if (seen == 1) {
        EXPECT_EQ(pixels_of(behind, "G")[i], 0.7f);
      }
    }
    scene.lights = {card(-3, radiance)};  // before the hair: it is all that is seen
    scene.lights[0].visible = true;
    const RenderResult before = result_of(scene);
    for (const float value : pixels_of(before, "G")) EXPECT_EQ(value, 0.7f);
    scene.lights[0].edge_u *= -1;  // from behind it is not there
    const RenderResult from_behind = result_of(scene);
    for (const float value : pixels_of(from_behind, "emission.G")) EXPECT_EQ(value, 0);
    EXPECT_EQ(pixels_of(from_behind, "coverage"), pixels_of(behind, "coverage"));
  }
}

TEST(Camera, AMatteHidesWhatIsBehindItHasNoAlphaAndLightsLikeTheMeshItIs) {
  scene::Scene scene = tangle(60, 24, 24);
  scene.meshes = {wall(0, 2)};  // behind the right half
  for (const bool transparent : {false, true}) {
    scene.image.transparent = transparent;
    scene.meshes[0].holdout = false;
    const RenderResult plain = result_of(scene);
    scene.meshes[0].holdout = true;
    const RenderResult matte = result_of(scene);
    int held_out = 0, hair = 0;
    double lit[2] = {0, 0};
    for (std::size_t i = 0; i < 24 * 24; ++i) {
      EXPECT_EQ(pixels_of(matte, "surface.G")[i], 0);
      const float covered = pixels_of(matte, "coverage")[i];
      if (i % 24 > 13 && covered == 0) {
        for (const char* name : {"R", "G", "B", "A", "background.G", "Z"})
          EXPECT_EQ(pixels_of(matte, name)[i], 0) << name;
        ++held_out;
      }
      if (i % 24 < 10 && !transparent) {
        EXPECT_EQ(pixels_of(matte, "A")[i], 1);
      }
      lit[0] += static_cast<double>(pixels_of(plain, "TRT.B")[i]);
      lit[1] += static_cast<double>(pixels_of(matte, "TRT.B")[i]);
      hair += covered > 0 ? 1 : 0;
    }
    EXPECT_GT(held_out, 50);
    EXPECT_GT(hair, 50);
    EXPECT_NEAR(lit[1], lit[0], 0.05 * lit[0]) << "some 200 pixels of 8 samples: 2 % of noise each";
  }
  // Before the hair it leaves nothing of it.
  scene.meshes = {wall(-9, -2)};
  scene.meshes[0].holdout = true;
  const RenderResult none = result_of(scene);
  for (const char* name : {"R", "A", "coverage", "background.R", "variance.R"})
    for (const float value : pixels_of(none, name)) EXPECT_EQ(value, 0) << name;
}

TEST(Camera, DoesNotSeeAMeshThatIsInvisibleWhichShadesTheHairAllTheSame) {
  scene::Scene scene = tangle(60, 24, 24);
  const RenderResult alone = result_of(scene);
  scene.meshes = {wall(-9, -2)};  // between the camera and the hair
  scene.meshes[0].albedo = glm::vec3(0.0f);
  scene.meshes[0].visibility.camera = false;
  const RenderResult shaded = result_of(scene);
  EXPECT_EQ(pixels_of(alone, "coverage"), pixels_of(shaded, "coverage"));
  EXPECT_EQ(pixels_of(alone, "Z"), pixels_of(shaded, "Z"));
  double before = 0, after = 0;
  for (std::size_t i = 0; i < 24 * 24; ++i) {
    before += static_cast<double>(pixels_of(alone, "TRT.B")[i]);
    after += static_cast<double>(pixels_of(shaded, "TRT.B")[i]);
  }
  EXPECT_LT(after, 0.8 * before) << "a black wall takes nearly half of the light";
}

/// A red sky and a green light: what each brings is a channel of its own, in hair that is white.
TEST(LightGroups, HaveALayerEachAddUpToBeautyAndChangeNothing) {
  scene::Scene scene = tangle(60, 24, 24);
  scene.environment = scene::Environment(glm::vec3(1, 0, 0));
  scene.lights = {card(5, {0, 2, 0}), card(-8, {0, 0, 1.5f})};
  scene.lights[1].edge_u *= -1;  // from the camera's side
  scene.lights[1].visible = scene.lights[0].visible = true;
  scene.meshes = {wall(0.3f, 2)};
  for (const bool transparent : {false, true}) {
    scene.image.transparent = transparent;
    scene.environment_group = scene.lights[0].group = "";
    scene.lights[1].group = "";
    const RenderResult plain = result_of(scene);
    EXPECT_EQ(plain.picture.find("light.other.R"), nullptr);
    scene.environment_group = "sky";
    scene.lights[0].group = "key";
    const RenderResult grouped = result_of(scene);
    for (const image::Channel& one : plain.picture.channels)
      EXPECT_EQ(one.pixels, pixels_of(grouped, one.name)) << one.name;
    double brightest = 0;
    for (std::size_t i = 0; i < 24 * 24; ++i) {
      const auto near = [&](float a, float b) { EXPECT_NEAR(a, b, 1e-5f * (std::abs(b) + 0.01f)); };
      near(pixels_of(grouped, "light.sky.R")[i], pixels_of(grouped, "R")[i]);
      near(pixels_of(grouped, "light.key.G")[i], pixels_of(grouped, "G")[i]);
      near(pixels_of(grouped, "light.other.B")[i], pixels_of(grouped, "B")[i]);
      for (const char* name : {"light.sky.G", "light.sky.B", "light.key.R", "light.other.G"})
        EXPECT_EQ(pixels_of(grouped, name)[i], 0);
      brightest = std::max(brightest, static_cast<double>(pixels_of(grouped, "light.other.B")[i]));
    }
    EXPECT_GT(brightest, 0.1);
  }
}

}  // namespace
}  // namespace tress::integrate
