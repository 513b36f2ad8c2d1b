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
  for (std::size_t g = 0; g < a.grooms.size(); ++g) EXPECT_EQ(a.grooms[g].fiber, b.grooms[g].fiber);
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
