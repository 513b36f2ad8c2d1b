// Keys of a scene file that the command line sets.
#include "scene/read/set_keys.h"

#include <gmock/gmock.h>

#include <string>
#include <utility>
#include <vector>

#include "groom_fixture.h"
#include "scene/read/load_scene.h"
#include "scene/read/scene_file.h"

namespace tress::scene {
namespace {

using ::testing::HasSubstr;

constexpr std::string_view two_materials = R"({
  "materials": [{"name": "a", "melanin": {"eumelanin": 1}}, {"name": "b"}],
  "grooms": [{"generate": "single_fiber", "material": "b"}]})";

Result<SceneDescription> parse_set(const std::vector<std::string>& settings) {
  return parse_scene_file(std::vector<unsigned char>(two_materials.begin(), two_materials.end()), "s.json", nullptr,
                          settings);
}

std::string fault_of_setting(const std::vector<std::string>& settings) {
  const auto scene = parse_set(settings);
  return scene ? "" : scene.error().message();
}

TEST(SetKeys, SetsObjectsThatAreMissingAndElementsByIndexNameOrAll) {
  const auto scene = parse_set({"image/width=33", "/camera/motion_samples=5", "materials/*/roughness=0.3",
                                "camera/shutter/close=0.5", "camera/shutter/open=0", "materials/b/roughness=0.4",
                                "materials/1/eta=1.5", "image/view=agx", "environment={\"constant\": [1, 2, 3]}"});
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->image.width, 33);
  EXPECT_EQ(scene->image.view, image::View::agx);
  EXPECT_EQ(scene->camera.shutter.samples, 5);
  EXPECT_EQ(scene->materials[0].fiber.roughness, 0.3f);
  EXPECT_EQ(scene->materials[1].fiber.roughness, 0.4f);
  EXPECT_EQ(scene->materials[0].fiber.eta, parse_set({})->materials[0].fiber.eta);
  EXPECT_EQ(scene->materials[1].fiber.eta, 1.5f);
  EXPECT_EQ(scene->environment.constant, glm::vec3(1, 2, 3));
}

TEST(SetKeys, NullRemovesAKeyThatExcludesAnother) {
  EXPECT_THAT(fault_of_setting({"materials/a/color=[0.5,0.3,0.1]"}), HasSubstr("/materials/0"));
  EXPECT_EQ(fault_of_setting({"materials/a/melanin=null", "materials/a/color=[0.5,0.3,0.1]"}), "");
  EXPECT_EQ(fault_of_setting({"materials/a/nothing=null", "no/such/thing=null"}), "");
}

TEST(SetKeys, ErrorsNameTheSetting) {
  EXPECT_EQ(fault_of_setting({"image/width=33", "materials/*/eccentricity=3"}),
            "s.json with --set materials/*/eccentricity=3: /materials/0/eccentricity: expected 0.5..1, found 3");
  EXPECT_THAT(fault_of_setting({"image/widht=33"}), HasSubstr("s.json with --set image/widht=33: /image/widht: "));
  EXPECT_THAT(fault_of_setting({"image/widht=33"}), HasSubstr("nearest is \"width\""));
  EXPECT_EQ(
      fault_of_setting({"materials/c/eta=1.5"}),
      "s.json: --set materials/c/eta=1.5: expected *, or the index or name of one of the 2 elements of /materials, "
      "found c");
  EXPECT_EQ(
      fault_of_setting({"materials/2/eta=1.5"}),
      "s.json: --set materials/2/eta=1.5: expected *, or the index or name of one of the 2 elements of /materials, "
      "found 2");
  EXPECT_EQ(fault_of_setting({"materials/0/name/x=1"}),
            "s.json: --set materials/0/name/x=1: expected an object or an array at /materials/0/name, found \"a\"");
  EXPECT_THAT(fault_of_setting({"materials/0/name=\xff", "materials/0/name/x=1"}), HasSubstr("found \"\xef\xbf\xbd\""));
  for (const std::string text : {"image/width", "=3", "/=3", "image//width=3", "image/width/=3"}) {
    EXPECT_FALSE(parse_setting(text)) << text;
    EXPECT_EQ(fault_of_setting({text}), "s.json: --set: expected " + std::string(setting_words) + ", found " + text);
  }
}

TEST(SetKeys, AreSetInTheEnvironmentThatReplacesTheScenes) {
  Overrides overrides;
  overrides.environment_file = "no/such/\xff.exr";
  overrides.settings = {"environment/scale=0.5"};
  EXPECT_THAT(load_scene(fixture("same.hair"), overrides).error().file, HasSubstr("no/such/\xff.exr"));
  overrides.settings = {"environment/constant=[1,1,1]"};
  EXPECT_THAT(load_scene(fixture("same.hair"), overrides).error().message(), HasSubstr("/environment"));
}

TEST(SetKeys, TheIntegratorHasItsKeys) {
  const auto scene = parse_set({"integrator/max_depth=8", "integrator/roulette=throughput", "integrator/near=1.5"});
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->integrator.max_depth, 8);
  EXPECT_EQ(scene->integrator.roulette, "throughput");
  EXPECT_EQ(scene->integrator.near_pixels, 1.5f);
  EXPECT_EQ(parse_set({"integrator/near=touching"})->integrator.near, "touching");
  EXPECT_THAT(fault_of_setting({"integrator/near=nearby"}),
              HasSubstr("/integrator/near: expected one of nowhere, seen, touching, everywhere"));
  EXPECT_THAT(fault_of_setting({"integrator/max_depth=0"}), HasSubstr("expected a whole number, 1..4096"));
  EXPECT_THAT(fault_of_setting({"integrator/deep_light_depth=3"}), HasSubstr("beside \"deep_light\""));
  EXPECT_THAT(fault_of_setting({"integrator/deep_light=learned", "integrator/roulette=throughput"}),
              HasSubstr("expected traced with roulette throughput"));
}

TEST(SetKeys, ABareFileOfStrandsHasOneMaterialAndOneGroom) {
  Overrides overrides;
  overrides.settings = {"materials/0/roughness=0.31", "grooms/0/translate=[0,0,5]", "image/curve_error=0.5"};
  const auto plain = load_scene(fixture("same.hair")), set = load_scene(fixture("same.hair"), overrides);
  ASSERT_TRUE(plain) << plain.error().message();
  ASSERT_TRUE(set) << set.error().message();
  EXPECT_EQ(set->materials[0].fiber.roughness, 0.31f);
  EXPECT_EQ(set->materials[0].fiber.sigma_a, plain->materials[0].fiber.sigma_a);
  EXPECT_EQ(set->materials[0].name, plain->materials[0].name);
  EXPECT_EQ(set->image.curve_error_px, 0.5f);
  EXPECT_EQ(set->grooms[0].points[0], plain->grooms[0].points[0] + glm::vec3(0, 0, 5));
}

}  // namespace
}  // namespace tress::scene
