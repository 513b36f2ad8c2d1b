// Lights that illuminate some objects, lights that some objects do not block, and objects that some rays do not meet.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

scene::Light panel(float height_cm, float half_cm, float radiance) {
  scene::Light light;
  light.kind = scene::Light::Kind::rectangle;
  light.center = {0, 0, height_cm};
  light.edge_u = {half_cm, 0, 0};
  light.edge_v = {0, -half_cm, 0};  // shines down
  light.radiance = glm::vec3(radiance);
  return light;
}

scene::Mesh square(const char* name, float half_cm, float z, float albedo) {
  scene::Mesh mesh;
  mesh.object = name;
  mesh.positions = {{-half_cm, -half_cm, z}, {half_cm, -half_cm, z}, {half_cm, half_cm, z}, {-half_cm, half_cm, z}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.albedo = glm::vec3(albedo);
  return mesh;
}

/// White hair over a floor, seen from above its edge. Between it and a panel there is a dark card, which the camera
/// does not see.
scene::Scene hair_floor_and_card() {
  scene::Scene scene = tangle(40, 24, 24);
  scene.camera.eye = {0, -5, 3};
  scene.environment = scene::Environment(glm::vec3(0.0f));
  scene.grooms[0].object = "hair";
  scene.meshes = {square("floor", 3, -1, 0.8f), square("card", 0.5f, 1.5f, 0.1f)};
  scene.meshes[1].visibility.camera = false;
  scene.lights = {panel(4, 1.5f, 3)};
  return scene;
}

RenderResult rendered(const scene::Scene& scene, int max_depth, int light_samples = 1, int bcsdf_samples = 1,
                      int samples = 4) {
  WhiteFiber model;
  RenderOptions options;
  options.samples = samples;
  options.max_depth = max_depth;
  options.light_samples = light_samples;
  options.bcsdf_samples = bcsdf_samples;
  options.roulette = Roulette::throughput;
  options.shadow_roulette = false;  // it would draw other numbers where there is other light
  options.seed = 5;
  return render_with(scene, model, {model.add_fiber(lossless_shares())}, options);
}

const std::vector<float>& green(const RenderResult& result) { return result.picture.find("G")->pixels; }

double sum_of(const std::vector<float>& pixels) {
  double sum = 0;
  for (const float pixel : pixels) sum += static_cast<double>(pixel);
  return sum;
}

/// Up to rounding: pixels are sums of up to 50 floats, in different orders.
void expect_same(const std::vector<float>& a, const std::vector<float>& b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-5f * (std::abs(b[i]) + 0.01f)) << what;
}

/// Numbers of light and BCSDF samples.
const std::vector<std::pair<int, int>> counts{{0, 1}, {1, 1}, {4, 1}, {1, 3}};

/// The same light, once for the hair and once for all but the hair. Each path has the same numbers in all pictures, so
/// that first hits agree path by path.
TEST(LightLinks, ToPartsOfASceneAddUpAtTheFirstHit) {
  for (const auto& [lights, bcsdfs] : counts) {
    scene::Scene scene = hair_floor_and_card();
    const std::vector<float> whole = green(rendered(scene, 1, lights, bcsdfs));
    scene.lights[0].links.lit = {true, {"hair"}};
    const RenderResult of_hair = rendered(scene, 1, lights, bcsdfs);
    scene.lights[0].links.lit = {false, {"hair"}};
    const RenderResult of_floor = rendered(scene, 1, lights, bcsdfs);
    std::vector<float> sum = green(of_hair);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += green(of_floor)[i];
    expect_same(sum, whole, "sum");
    EXPECT_EQ(sum_of(of_hair.picture.find("surface.G")->pixels), 0);
    EXPECT_EQ(sum_of(of_floor.picture.find("TRT.G")->pixels), 0);
    EXPECT_GT(sum_of(green(of_hair)), 0.01 * sum_of(whole));
    EXPECT_GT(sum_of(green(of_floor)), 0.01 * sum_of(whole));
  }
}

/// All depths, beside an environment for the other objects, so that the lights are drawn by other chances at each
/// object. Four means at |z| < 5. The three pictures share numbers, which makes their difference smaller than that of
/// independent ones.
TEST(LightLinks, ToPartsOfASceneAddUpAtAllDepthsInTheMean) {
  for (const auto& [lights, bcsdfs] : counts) {
    scene::Scene scene = hair_floor_and_card();
    scene.environment = scene::Environment(glm::vec3(0.3f));
    scene.environment_visible = false;  // its backdrop would be in both parts
    const auto mean = [&, lights = lights, bcsdfs = bcsdfs] {
      return mean_of(rendered(scene, 200, lights, bcsdfs, 32), "G");
    };
    const Mean whole = mean();
    scene.lights[0].links.lit = {true, {"hair"}};
    scene.environment_links.lit = {false, {"hair", "card"}};
    const Mean first = mean();
    scene.lights[0].links.lit = {false, {"hair"}};
    scene.environment_links.lit = {true, {"hair", "card"}};
    const Mean second = mean();
    const double error = std::sqrt(whole.error * whole.error + first.error * first.error + second.error * second.error);
    EXPECT_LT(std::abs(first.value + second.value - whole.value), z_limit * error) << lights << " " << bcsdfs;
    EXPECT_LT(error, 0.12 * whole.value) << "the test would see nothing";
    EXPECT_GT(first.value, 0.1 * whole.value);
    EXPECT_GT(second.value, 0.1 * whole.value);
  }
}

/// The card casts no shadow in the light: at the first hit there is as much light as without it, whatever draws it.
TEST(LightLinks, WhatIsExcludedFromShadowsBlocksNothing) {
  for (const bool by_object : {false, true}) {
    for (const auto& [lights, bcsdfs] : counts) {
      scene::Scene scene = hair_floor_and_card();
      const double shaded = sum_of(green(rendered(scene, 1, lights, bcsdfs)));
      if (by_object)
        scene.meshes[1].visibility.shadow = false;
      else
        scene.lights[0].links.blocking = {false, {"card"}};
      const std::vector<float> lit = green(rendered(scene, 1, lights, bcsdfs));
      scene.meshes.pop_back();
      expect_same(lit, green(rendered(scene, 1, lights, bcsdfs)), "without a card");
      EXPECT_GT(sum_of(lit), 1.02 * shaded);
      scene = hair_floor_and_card();
      scene.lights[0].links.blocking = {true, {"card"}};  // neither hair nor floor shades the hair
      EXPECT_LT(sum_of(green(rendered(scene, 1, lights, bcsdfs))), sum_of(lit));
    }
  }
}

/// The same of the environment and of a distant light, which a ray sees only where it meets nothing else.
TEST(LightLinks, OfLightsAtInfinityPassWhatIsExcluded) {
  for (const bool distant : {false, true}) {
    for (const auto& [lights, bcsdfs] : counts) {
      scene::Scene scene = hair_floor_and_card();
      scene.lights.clear();
      if (distant) {
        scene.lights.resize(1);
        scene.lights[0].half_angle_rad = 0.7f;
        scene.lights[0].links.blocking = {false, {"card"}};
      } else {
        scene.environment = scene::Environment(glm::vec3(1.0f));
        scene.environment_links.blocking = {false, {"card"}};
      }
      const std::vector<float> lit = green(rendered(scene, 1, lights, bcsdfs));
      scene.meshes.pop_back();
      expect_same(lit, green(rendered(scene, 1, lights, bcsdfs)), "without a card");
    }
  }
}

/// A card that scattered rays pass: it still blocks lights as it did, for light samples and for the lights that those
/// rays meet.
TEST(Visibility, OfIndirectRaysLeavesShadowsAsTheyAre) {
  for (const auto& [lights, bcsdfs] : counts) {
    scene::Scene scene = hair_floor_and_card();
    const std::vector<float> plain = green(rendered(scene, 1, lights, bcsdfs));
    const double all = mean_of(rendered(scene, 50, lights, bcsdfs), "G").value;
    scene.meshes[1].visibility.indirect = false;
    expect_same(green(rendered(scene, 1, lights, bcsdfs)), plain, "first hit");
    const Mean other = mean_of(rendered(scene, 50, lights, bcsdfs), "G");
    EXPECT_NEAR(other.value, all, 0.1 * all) << "a dark card reflects little";
  }
}

TEST(Visibility, OfNoRayIsTheSceneWithoutTheObject) {
  scene::Scene scene = hair_floor_and_card();
  for (const bool hair : {false, true}) {
    scene::Scene without = hair_floor_and_card(), with = without;
    if (hair) {
      with.grooms[0].visibility = {.camera = false, .shadow = false, .indirect = false};
      for (glm::vec3& point : without.grooms[0].points) point.x += 1000;
    } else {
      with.meshes[1].visibility = {.camera = false, .shadow = false, .indirect = false};
      without.meshes.pop_back();
    }
    expect_same(green(rendered(with, 50)), green(rendered(without, 50)), hair ? "hair" : "card");
  }
}

/// No sample is spent on a light that an object does not get.
TEST(LightLinks, ToOtherObjectsAddNoNoise) {
  for (const auto& [lights, bcsdfs] : counts) {
    scene::Scene scene = hair_floor_and_card();
    const std::vector<float> alone = green(rendered(scene, 1, lights, bcsdfs));
    scene.lights.insert(scene.lights.begin(), panel(5, 2, 40));
    scene.lights[0].links.lit = {true, {"card"}};  // which the camera does not see
    expect_same(green(rendered(scene, 1, lights, bcsdfs)), alone, "alone");
  }
}

TEST(LightLinks, ThatNameNothingChangeNoBit) {
  scene::Scene scene = hair_floor_and_card();
  scene.environment = scene::Environment(glm::vec3(0.3f));
  const RenderResult plain = rendered(scene, 50);
  scene.lights[0].links = {{true, {"hair", "floor", "card"}}, {false, {}}};
  scene.environment_links = {{false, {}}, {true, {"card", "floor", "hair"}}};
  EXPECT_EQ(green(rendered(scene, 50)), green(plain));
}

}  // namespace
}  // namespace tress::integrate
