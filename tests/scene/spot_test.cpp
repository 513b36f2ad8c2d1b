// Spot lights: what they send where, against what is on paper, and how they are read.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "scene/model/light.h"
#include "scene/read/scene_file.h"
#include "tress/base/random.h"

namespace tress::scene {
namespace {

constexpr double pi = std::numbers::pi;

Result<SceneDescription> parse(const std::string& lights) {
  const std::string text = R"({"lights": )" + lights + R"(, "grooms": [{"generate": "single_fiber"}]})";
  return parse_scene_file(std::vector<unsigned char>(text.begin(), text.end()), "s.json");
}

Light spot(const std::string& keys) {
  const auto scene = parse(fmt::format(R"([{{"spot": {{"center": [0, 0, 100], "look_at": [0, 0, 0], {}}}}}])", keys));
  EXPECT_TRUE(scene) << scene.error().message();
  return scene ? scene->lights[0].light : Light{};
}

/// On a plane across the axis, `aside` from it: the mean of L cos / pdf over a grid of 64 x 64 draws. Cells of a smooth
/// integrand on a grid of n err by 1/n^2.
double irradiance(const Light& light, float aside) {
  constexpr int n = 64;
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const auto u = [](int k) { return (static_cast<float>(k) + 0.5f) / n; };
      const LightSample sample = sample_light(light, {aside, 0, 0}, u(i), u(j));
      if (sample.pdf_solid_angle > 0)
        sum += double{sample.radiance.y} * double{sample.direction.z} / double{sample.pdf_solid_angle};
    }
  return sum / (n * n);
}

/// A small sphere: I cos / d^2 with I = pi r^2 L, times the share at the angle to the axis. r / d is 0.001, so that the
/// angle varies by 0.001 over the sphere, and the share within 2 % of its slope: 0.3 % of the core at most.
TEST(Spot, IrradianceOnAPlaneIsThatOfAPointWithTheShareOfTheCone) {
  const Light light = spot(R"("radius_cm": 0.1, "cone_deg": 40, "soft": 0.5, "radiance": [1, 1000, 1])");
  const double cone = 1 - std::cos(20 * pi / 180);
  const double on_axis = pi * 0.1 * 0.1 * 1000 / (100 * 100);
  for (float aside = 0; aside < 45; aside += 2.5f) {
    const double d = std::hypot(double{aside}, 100.0), cosine = 100 / d;
    const double t = std::clamp((cone - (1 - cosine)) / (0.5 * cone), 0.0, 1.0);
    const double expected = pi * 0.1 * 0.1 * 1000 / (d * d) * cosine * t * t * (3 - 2 * t);
    EXPECT_NEAR(irradiance(light, aside), expected, 0.003 * on_axis) << aside;
  }
  EXPECT_EQ(irradiance(light, 37), 0) << "the cone's edge is at 36.4 cm, its penumbra 0.1 cm wide";
}

TEST(Spot, IrradianceIsWhatWasAskedForAtItsTarget) {
  for (const double radius : {0.5, 5.0, 20.0}) {
    const Light light = spot(fmt::format(R"("radius_cm": {}, "cone_deg": 90, "irradiance": [1, 2.5, 1])", radius));
    EXPECT_NEAR(irradiance(light, 0), 2.5, 0.003) << radius;
  }
}

TEST(Spot, AHardEdgeIsOneAndANarrowConeIsExact) {
  const Light hard = spot(R"("cone_deg": 60, "soft": 0, "radiance": [1, 1, 1])");
  const auto towards = [](double degrees) {
    return glm::vec3(std::sin(degrees * pi / 180), 0, -std::cos(degrees * pi / 180));
  };
  EXPECT_EQ(spot_share(hard, towards(29.99)), 1);
  EXPECT_EQ(spot_share(hard, towards(30.01)), 0);
  const Light narrow = spot(R"("cone_deg": 0.1, "soft": 1, "radiance": [1, 1, 1])");
  EXPECT_EQ(spot_share(narrow, towards(0)), 1);
  // Half way in the cosine: at the angle over the root of 2.
  EXPECT_NEAR(spot_share(narrow, towards(0.05 / std::numbers::sqrt2)), 0.5, 0.001);
  EXPECT_EQ(spot_share(narrow, towards(0.051)), 0);
}

/// What a ray meets is what was drawn: seed 11.
TEST(Spot, ARayMeetsTheLightThatWasDrawn) {
  const Light light = spot(R"("radius_cm": 10, "cone_deg": 50, "soft": 0.7, "radiance": [3, 2, 1])");
  RandomStream random(11);
  int lit = 0;
  for (int i = 0; i < 1000; ++i) {
    const glm::vec3 point(100 * random.next() - 50, 100 * random.next() - 50, 130 * random.next() - 20);
    const LightSample drawn = sample_light(light, point, random.next(), random.next());
    if (!(drawn.pdf_solid_angle > 0)) continue;
    const LightSample met = light_along(light, point, drawn.direction);
    if (!(met.pdf_solid_angle > 0)) continue;  // at the sphere's rim, by rounding
    EXPECT_NEAR(met.radiance.x, drawn.radiance.x, 1e-5f);
    EXPECT_NEAR(met.pdf_solid_angle, drawn.pdf_solid_angle, 1e-5f * drawn.pdf_solid_angle);
    lit += drawn.radiance.x > 0 ? 1 : 0;
  }
  EXPECT_GT(lit, 100);
}

TEST(LightGroups, AreNamedInOrderAndWhatHasNoneIsOther) {
  Scene scene;
  scene.lights.resize(3);
  EXPECT_TRUE(light_groups(scene).empty());
  scene.lights[1].group = "rim";
  EXPECT_EQ(light_groups(scene), (std::vector<std::string>{"rim", "other"}));
  scene.lights[0].group = scene.lights[2].group = "key";
  scene.environment = Environment(glm::vec3(1.0f));
  scene.environment_group = "sky";
  EXPECT_EQ(light_groups(scene), (std::vector<std::string>{"sky", "key", "rim"}));
  EXPECT_EQ(group_index(light_groups(scene), "rim"), 2u);
}

TEST(LightReader, RefusesWhatASpotAndAGroupCannotBe) {
  const std::string places = R"("center": [0, 0, 9], "look_at": [0, 0, 0])";
  const std::pair<std::string, std::string> wrong[] = {
      {R"({"spot": {"center": [0, 0, 9], "radiance": [1, 1, 1]}})", "/lights/0/spot/look_at: expected this key"},
      {"{\"spot\": {" + places + "}}", "/lights/0/spot: expected "},
      {"{\"spot\": {" + places + R"(, "radiance": [1, 1, 1], "irradiance": [1, 1, 1]}})", "/lights/0/spot: expected "},
      {R"({"spot": {"center": [1, 0, 0], "look_at": [1, 0, 0], "radiance": [1, 1, 1]}})",
       "/lights/0/spot/look_at: expected a point other than center, found the same point"},
      {"{\"spot\": {" + places + R"(, "cone_deg": 0, "radiance": [1, 1, 1]}})",
       "/lights/0/spot/cone_deg: expected 0.1..180 degrees, found 0"},
      {"{\"spot\": {" + places + R"(, "soft": 2, "radiance": [1, 1, 1]}})", "/lights/0/spot/soft: expected 0..1"},
      {"{\"spot\": {" + places + R"(, "radiance": [1, 1, 1]}, "group": "key light"})",
       "/lights/0/group: expected 1 to 64 letters, digits, _ and -, found \"key light\""}};
  for (const auto& [light, why] : wrong) {
    const auto scene = parse("[" + light + "]");
    ASSERT_FALSE(scene) << light;
    EXPECT_NE(scene.error().message().find(why), std::string::npos) << scene.error().message();
  }
}

}  // namespace
}  // namespace tress::scene
