// A look that a scene is given later is that of a scene that was loaded with it.
#include <gtest/gtest.h>

#include <span>
#include <string>

#include "scene/read/load_scene.h"

namespace tress::scene {
namespace {

constexpr const char* text = R"({
  "environment": {"sky": {"sun": {"azimuth_deg": 30, "elevation_deg": 40, "radiance": [10, 9, 8]}}},
  "lights": [{"distant": {"direction": [0, -1, 1], "radiance": [2, 2, 2]}}],
  "materials": [{"name": "a", "color": [0.4, 0.3, 0.2], "variation": {"eccentricity": 0.05, "width": 0.1, "color": 0.2}},
                {"name": "b", "melanin": {"eumelanin": 2}}],
  "grooms": [{"generate": "straight", "strands": 40, "material": "a"},
             {"generate": "straight", "strands": 10, "material": "b"}]
})";

Result<Scene> loaded(const Overrides& overrides) {
  const std::span<const unsigned char> bytes(reinterpret_cast<const unsigned char*>(text), std::string(text).size());
  return load_scene(bytes, "test", ".", {}, overrides);
}

void expect_same(const Scene& a, const Scene& b) {
  EXPECT_EQ(a.fibers, b.fibers);
  ASSERT_EQ(a.grooms.size(), b.grooms.size());
  for (std::size_t g = 0; g < a.grooms.size(); ++g) EXPECT_EQ(a.grooms[g].choices, b.grooms[g].choices);
  ASSERT_EQ(a.lights.size(), b.lights.size());
  for (std::size_t i = 0; i < a.lights.size(); ++i) EXPECT_EQ(a.lights[i].radiance, b.lights[i].radiance);
  for (const float u : {0.1f, 0.5f, 0.9f}) {
    const Environment::Sample x = a.environment.sample(u, 1 - u), y = b.environment.sample(u, 1 - u);
    EXPECT_EQ(x.direction, y.direction);
    EXPECT_EQ(x.radiance, y.radiance);
    EXPECT_EQ(x.pdf_solid_angle, y.pdf_solid_angle);
  }
}

TEST(Look, GivenLaterIsAsIfLoadedWithIt) {
  Overrides first, second;
  first.color = glm::vec3(0.5f, 0.4f, 0.3f);
  first.eccentricity = 0.7f;
  second.melanin = {{5.0f, 0.5f}};
  second.roughness = 0.3f;
  second.tilt_deg = 1;
  second.light_scale = 2.5;
  auto scene = loaded({});
  ASSERT_TRUE(scene) << scene.error().message();
  const Unstyled unstyled{scene->materials, scene->lights, scene->environment};
  for (const Overrides& look : {first, second, Overrides{}, first}) {
    ASSERT_FALSE(restyle(unstyled, look, &*scene));
    const auto fresh = loaded(look);
    ASSERT_TRUE(fresh);
    expect_same(*scene, *fresh);
  }
  EXPECT_NEAR(scene->materials[0].fiber.eccentricity, 0.7, 1e-6);
}

/// A ramp given later, and the same ramp in the file.
TEST(Look, AColorSourceIsThatOfTheSameKeyInAFile) {
  const std::string ramp =
      R"({"ramp": [[0.2, [0.05, 0.03, 0.02]], [0.9, [0.7, 0.4, 0.2]]], "interpolation": "smooth"})";
  Overrides look;
  look.color_source = ramp;
  auto scene = loaded({});
  ASSERT_TRUE(scene);
  ASSERT_FALSE(restyle({scene->materials, scene->lights, scene->environment}, look, &*scene));
  std::string same = text;
  for (const std::string color : {R"("color": [0.4, 0.3, 0.2])", R"("melanin": {"eumelanin": 2})"})
    same.replace(same.find(color), color.size(), "\"color\": " + ramp);
  const auto fresh =
      load_scene(std::span(reinterpret_cast<const unsigned char*>(same.data()), same.size()), "test", ".", {});
  ASSERT_TRUE(fresh) << fresh.error().message();
  expect_same(*scene, *fresh);
  ASSERT_TRUE(scene->materials[1].pigment);
  EXPECT_EQ(scene->materials[1].pigment->source, fresh->materials[1].pigment->source);
  ASSERT_FALSE(
      restyle({fresh->materials, fresh->lights, fresh->environment}, {.color_source = "[0.4, 0.3, 0.2]"}, &*scene));
  EXPECT_FALSE(scene->materials[0].pigment) << "one color again";
  expect_same(*scene, *loaded({.color = glm::vec3(0.4f, 0.3f, 0.2f)}));
}

TEST(Look, LightScaleScalesAllLightAndNothingElse) {
  Overrides look;
  look.light_scale = 4;
  const auto dim = loaded({}), bright = loaded(look);
  ASSERT_TRUE(dim && bright);
  ASSERT_EQ(dim->lights.size(), 2u) << "the sun is one";
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(bright->lights[i].radiance, 4.0f * dim->lights[i].radiance);
  const glm::vec3 up(0, 0, 1);
  EXPECT_EQ(bright->environment.radiance(up), 4.0f * dim->environment.radiance(up)) << "by a power of two, exactly";
  EXPECT_NEAR(bright->environment.pdf_solid_angle(up), dim->environment.pdf_solid_angle(up),
              1e-5 * dim->environment.pdf_solid_angle(up));
  EXPECT_EQ(bright->fibers, dim->fibers);
}

TEST(Look, OutOfRangeIsRefusedByName) {
  auto scene = loaded({});
  ASSERT_TRUE(scene);
  const Unstyled unstyled{scene->materials, scene->lights, scene->environment};
  Overrides look;
  look.tilt_deg = 1e9;
  auto error = restyle(unstyled, look, &*scene);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->place, "--cuticle-tilt");
  look = {};
  look.light_scale = -1;
  error = restyle(unstyled, look, &*scene);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->place, "--light-scale");
  look = {};
  look.eccentricity = 1.0f;  // the variation would leave the range
  error = restyle(unstyled, look, &*scene);
  ASSERT_TRUE(error);
  EXPECT_NE(error->message().find("variation"), std::string::npos);
}

}  // namespace
}  // namespace tress::scene
