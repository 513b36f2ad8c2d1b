#include "scene/read/scene_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <numbers>

#include "scene/model/hair_colors.h"
#include "scene/read/grooms/given_basis.h"
#include "scene/read/load_scene.h"
#include "tress/fiber/lock_color.h"
#include "tress/fiber/principled_hair.h"

namespace tress::scene {
namespace {

std::string message(const std::string& text) {
  const std::vector<unsigned char> bytes(text.begin(), text.end());
  const auto scene = parse_scene_file(bytes, "s.json");
  return scene ? "" : scene.error().message();
}

const std::string groom = R"("grooms": [{"generate": "single_fiber"}])";

TEST(SceneFile, NamesThePathAndTheExpectation) {
  EXPECT_EQ(message("{" + groom + "}"), "");
  EXPECT_EQ(message(R"({"materials": [{"eccentricity": 3}], )" + groom + "}"),
            "s.json: /materials/0/eccentricity: expected 0.5..1, found 3");
  EXPECT_NE(message(R"({"materials": [{"rougness": 0.3}], )" + groom + "}").find("nearest is \"roughness\""),
            std::string::npos);
  const std::pair<std::string, std::string> wrong[] = {
      {R"({)", "byte"},
      {"", "byte"},
      {"[]", "s.json: /: expected an object"},
      {R"({"grooms": []})", "/grooms"},
      {R"({"grooms": [{"generate": "afro"}]})", "/grooms/0/generate"},
      {R"({"grooms": [{"generate": "straight", "strands": 1e12}]})", "/grooms/0/strands"},
      {R"({"grooms": [{"generate": "straight", "strands": -1}]})", "/grooms/0/strands"},
      {R"({"expected": {"radiance": [1, 1, -1]}, )" + groom + "}", "/expected/radiance/2"},
      {R"({"materials": [{"variation": {"eccentricity": 0.3}}], )" + groom + "}",
       "/materials/0/variation/eccentricity"},
      {R"({"materials": [{"medulla": {"scattering": 3}}], )" + groom + "}", "/materials/0/medulla"},
      {R"({"materials": [{"cortex": {"asymmetry": 0.5}}], )" + groom + "}", "/materials/0/cortex"},
      {R"({"materials": [{"cortex": {"scattering": 21}}], )" + groom + "}", "/materials/0/cortex/scattering"},
      {R"({"materials": [{"wetness": 1.5}], )" + groom + "}", "/materials/0/wetness"},
      {R"({"materials": [{"medulla": {"radius": 0.5, "asymmetry": 1}}], )" + groom + "}",
       "/materials/0/medulla/asymmetry"},
      {R"({"materials": [{"color": "red"}], )" + groom + "}", "/materials/0/color"},
      {R"({"materials": [{"color": "file"}], )" + groom + "}", "/grooms/0/material"},
      {R"({"grooms": [{"generate": "straight", "length_cm": 1e999}]})", "s.json"},
      {R"({"grooms": [{"generate": "straight", "file": "a.hair"}]})", "/grooms/0"},
      {R"({"grooms": [{"generate": "straight", "material": "x"}]})", "/grooms/0/material"},
      {R"({"grooms": [{"generate": "straight", "basis": "cubic"}]})",
       "s.json: /grooms/0/basis: expected one of bspline, linear, catmull_rom, clamped_catmull_rom, open_bspline, "
       "open_catmull_rom, bezier, hermite, found \"cubic\""},
      {R"({"grooms": [{"generate": "straight", "basis": true}]})", "/grooms/0/basis"},
      {R"({"image": {"width": 0}, )" + groom + "}", "/image/width"},
      {R"({"image": {"width": 65536, "height": 65536}, )" + groom + "}", "/image"},
      {R"({"camera": {"eye": [0, 0, null]}, )" + groom + "}", "/camera/eye/2"},
      {R"({"camera": {"eye": [0, 0, 1], "look_at": [0, 0, 0], "up": [0, 0, 1]}, )" + groom + "}", "/camera/up"},
      {R"({"environment": {"constant": [-1, 0, 0]}, )" + groom + "}", "/environment/constant/0"},
      {R"({"materials": [{"color": [1, 1, 1]}], )" + groom + "}", "/materials/0/color/0"},
      {R"({"materials": [{"longitudinal_lambda_deg": {"R": 0}}], )" + groom + "}",
       "/materials/0/longitudinal_lambda_deg/R"}};
  for (const auto& [text, place] : wrong) EXPECT_NE(message(text).find(place), std::string::npos) << message(text);
}

SceneDescription parsed(const std::string& text) {
  const std::vector<unsigned char> bytes(text.begin(), text.end());
  const auto scene = parse_scene_file(bytes, "s.json");
  EXPECT_TRUE(scene) << scene.error().message();
  return scene ? *scene : SceneDescription{};
}

TEST(SceneFile, ReadsLights) {
  const auto scene = parsed(R"({"lights": [
    {"distant": {"azimuth_deg": 90, "elevation_deg": 0, "angle_deg": 2, "irradiance": [3, 2, 1]}},
    {"sphere": {"center": [1, 2, 3], "radius_cm": 4, "radiance": [5, 6, 7]}},
    {"rectangle": {"center": [0, 0, 10], "look_at": [0, 0, 0], "width_cm": 6, "height_cm": 2, "radiance": [1, 1, 1]}},
    {"rectangle": {"center": [0, -9, 0], "look_at": [0, 0, 0], "width_cm": 6, "height_cm": 2, "radiance": [1, 1, 1]}}
    ], )" + groom + "}");
  ASSERT_EQ(scene.lights.size(), 4u);
  EXPECT_NEAR(scene.lights[0].light.direction.x, 1, 1e-6);
  EXPECT_NEAR(scene.lights[0].light.half_angle_rad, std::numbers::pi / 180, 1e-8);
  EXPECT_NEAR(scene.lights[0].light.radiance.g, 2 / (std::numbers::pi * std::pow(std::sin(std::numbers::pi / 180), 2)),
              1e-3);
  EXPECT_EQ(scene.lights[1].light.radius_cm, 4);
  const auto& level = scene.lights[2].light;  // a ceiling: its height runs along y
  EXPECT_NEAR(glm::cross(level.edge_u, level.edge_v).z, -3, 1e-5);
  EXPECT_NEAR(std::abs(level.edge_v.y), 1, 1e-6);
  const auto& front = scene.lights[3].light;
  EXPECT_NEAR(glm::cross(front.edge_u, front.edge_v).y, 3, 1e-5);
  EXPECT_NEAR(std::abs(front.edge_v.z), 1, 1e-6);
  const std::pair<std::string, std::string> wrong[] = {
      {R"({})", "/lights/0: expected one of distant, sphere, rectangle, spot, found none"},
      {R"({"sphere": {}, "distant": {}})", "/lights/0: expected at most one of"},
      {R"({"distant": {"direction": [0, 0, 0], "radiance": [1, 1, 1]}})", "/lights/0/distant/direction"},
      {R"({"distant": {"direction": [0, 0, 1]}})", "/lights/0/distant: expected one of radiance, irradiance"},
      {R"({"distant": {"radiance": [1, 1, 1]}})", "/lights/0/distant: expected direction, or azimuth_deg"},
      {R"({"sphere": {"center": [0, 0, 0], "radiance": [1, 1, 1]}})", "/lights/0/sphere/radius_cm: expected this key"},
      {R"({"sphere": {"center": [0, 0, 0], "radius_cm": 0, "radiance": [1, 1, 1]}})",
       "/lights/0/sphere/radius_cm: expected 0.001..1000000 cm, found 0"}};
  for (const auto& [light, place] : wrong) {
    const auto found = message(R"({"lights": [)" + light + "], " + groom + "}");
    EXPECT_NE(found.find(place), std::string::npos) << found;
  }
}

TEST(SceneFile, ReadsCortexAndWater) {
  const auto scene =
      parsed(R"({"materials": [{"cortex": {"scattering": 1.5, "asymmetry": -0.2}, "wetness": 0.5}], )" + groom + "}");
  const auto& hair = scene.materials.at(0).fiber;
  EXPECT_EQ(hair.cortex_scattering, 1.5f);
  EXPECT_EQ(hair.cortex_asymmetry, -0.2f);
  EXPECT_EQ(hair.wetness, 0.5f);
}

TEST(SceneFile, ReadsTheMedulla) {
  const auto scene = parsed(
      R"({"materials": [{"medulla": {"radius": 0.7, "scattering": 4, "asymmetry": -0.2, "absorption": 0.5}},
                        {"medulla": {"radius": 0.3}}], )" +
      groom + "}");
  const auto& fur = scene.materials.at(0).fiber;
  EXPECT_EQ(fur.medulla_radius, 0.7f);
  EXPECT_EQ(fur.medulla_scattering, 4);
  EXPECT_EQ(fur.medulla_asymmetry, -0.2f);
  EXPECT_EQ(fur.medulla_absorption, 0.5f);
  EXPECT_EQ(scene.materials.at(1).fiber.medulla_scattering, 0);
}

TEST(SceneFile, NamesNaturalHair) {
  const auto scene = parsed(R"({"materials": [{"hair": "dark brown"}, {"hair": "grey"}], )" + groom + "}");
  EXPECT_EQ(scene.materials.at(0).fiber.sigma_a, fiber::sigma_a_from_melanin(1.3f, 0));
  EXPECT_EQ(scene.materials.at(1).fiber.sigma_a, AbsorptionOf(false).hair("grey"));
  EXPECT_NE(message(R"({"materials": [{"hair": "blonde"}], )" + groom + "}").find("/materials/0/hair"),
            std::string::npos);
  EXPECT_NE(message(R"({"materials": [{"hair": "red", "color": [0.1, 0.2, 0.3]}], )" + groom + "}").find("hair"),
            std::string::npos);
}

TEST(SceneFile, ReadsShapesAndGainsOfLobes) {
  using fiber::Lobe;
  const auto scene = parsed(R"({"materials": [
    {"name": "a", "longitudinal_shape": "cauchy", "fresnel": "bravais", "gain": {"R": 2, "TRT": 3},
     "tint": {"TRT": [1, 0.5, 0.25], "residual": [0, 0, 0]}},
    {"name": "b", "gain": {"GLINT": 7}, "tint": {"TRT": [0.5, 0.5, 0.5]}},
    {"name": "c", "glint": true, "gain": {"TRT": 2}}, {"name": "d"}], )" +
                            groom + "}");
  ASSERT_EQ(scene.materials.size(), 4u);
  const auto gain = [&](std::size_t m, Lobe lobe) {
    return scene.materials[m].fiber.gain[static_cast<std::size_t>(lobe)];
  };
  const auto& a = scene.materials[0].fiber;
  EXPECT_EQ(a.longitudinal_shape, fiber::LongitudinalShape::cauchy);
  EXPECT_EQ(a.reflection_fresnel, fiber::ReflectionFresnel::bravais);
  EXPECT_FALSE(a.split_glint);
  EXPECT_EQ(gain(0, Lobe::r), glm::vec3(2));
  EXPECT_EQ(gain(0, Lobe::tt), glm::vec3(1));
  EXPECT_EQ(gain(0, Lobe::trt), glm::vec3(3, 1.5f, 0.75f));
  EXPECT_EQ(gain(0, Lobe::residual), glm::vec3(0));
  EXPECT_TRUE(scene.materials[1].fiber.split_glint);
  EXPECT_EQ(gain(1, Lobe::glint), glm::vec3(3.5f));  // its own gain, the tint of TRT
  EXPECT_TRUE(scene.materials[2].fiber.split_glint);
  EXPECT_EQ(gain(2, Lobe::glint), glm::vec3(2));  // a layer more, the same picture
  EXPECT_EQ(scene.materials[3].fiber, fiber::FiberParameters{});
}

TEST(SceneFile, ReadsSkies) {
  const auto scene = parsed(R"({"environment": {"sky": {"zenith": [0, 0, 2], "sun": {"elevation_deg": 90,
    "angle_deg": 2, "radiance": [9, 8, 7]}}, "scale": 0.5}, )" +
                            groom + "}");
  EXPECT_EQ(scene.environment.kind, EnvironmentDescription::Kind::sky);
  EXPECT_EQ(scene.environment.sky.zenith, glm::vec3(0, 0, 2));
  EXPECT_EQ(scene.environment.sky.ground, GradientSky{}.ground);
  EXPECT_EQ(sun_of(scene.environment, scene.environment.rotate_deg)->radiance, glm::vec3(4.5f, 4, 3.5f));
  EXPECT_NE(message(R"({"environment": {"sky": {}, "studio": true}, )" + groom + "}").find("/environment: expected at"),
            std::string::npos);
  EXPECT_NE(message(R"({"environment": {"sky": {"sun": {"radiance": [-1, 0, 0], "elevation_deg": 3}}}, )" + groom + "}")
                .find("/environment/sky/sun/radiance/0"),
            std::string::npos);
}

TEST(SceneFile, ReadsTheBasisOfFilesAndOfGeneratedGrooms) {
  const SceneDescription scene = parsed(R"({"grooms": [{"generate": "single_fiber"}, {"file": "a.hair"},
      {"generate": "single_fiber", "basis": "linear"}, {"file": "a.hair", "basis": "linear"},
      {"generate": "single_fiber", "basis": "bspline"}]})");
  ASSERT_EQ(scene.grooms.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_EQ(scene.grooms[i].placement.basis == kind_of_basis("linear"), i == 2 || i == 3) << i;
}

TEST(SceneFile, SurvivesDeepNestingAndEveryTruncation) {
  EXPECT_NE(message(std::string(100000, '[')), "");
  const std::string whole = R"({"camera": {"frame": true}, "materials": [{"name": "a", "eta": 1.5}], )" + groom + "}";
  for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_NE(message(whole.substr(0, size)), "") << size;
}

TEST(LoadScene, FindsTheAbsorptionOfAColorForTheShapeThatIsDrawn) {
  const auto file = std::filesystem::path(testing::TempDir()) / "tress_asked.json";
  const glm::vec3 asked(0.5f, 0.3f, 0.1f);
  std::ofstream(file) << R"({"materials": [{"color": [0.5, 0.3, 0.1], "eccentricity": 0.6}], )" << groom << "}";
  Overrides overrides;
  const auto as_it_is = load_scene(file, overrides);
  overrides.roughness = 0.05f;
  const auto smoother = load_scene(file, overrides);
  overrides.hair = "red";
  const auto red = load_scene(file, overrides);
  std::filesystem::remove(file);
  ASSERT_TRUE(as_it_is && smoother && red);
  for (const auto& scene : {*as_it_is, *smoother}) {
    EXPECT_EQ(scene.fibers.at(0).sigma_a, fiber::sigma_a_of_lock(asked, scene.fibers.at(0)));
  }
  EXPECT_NE(as_it_is->fibers[0].sigma_a, smoother->fibers[0].sigma_a);
  EXPECT_EQ(red->fibers.at(0).sigma_a, AbsorptionOf(false).hair("red"));
}

/// Red hair is by its numbers: a lock shows the green and blue that its absorption was chosen for, 0.25, 0.07, 0.024
/// and 0.10, 0.03, 0.012, against its red at most 0.3 and 0.12 of it; what melanin alone can show is 0.5 and more.
TEST(LoadScene, RedAndAuburnAreRed) {
  const fiber::FiberParameters usual;
  for (const auto& [name, color] :
       {std::pair{"red", glm::vec3(0.25f, 0.07f, 0.024f)}, {"auburn", glm::vec3(0.10f, 0.03f, 0.012f)}}) {
    const glm::vec3 expected = fiber::sigma_a_of_lock(color, usual), found = *AbsorptionOf(false).hair(name);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 0.01f * expected[c]) << name << " " << c;
  }
}

TEST(LoadScene, RefusesMissingEmptyAndFoldersWithoutGrooms) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("tress_no_groom_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder / "nothing");
  const auto empty = folder / "tress_empty.hair";
  std::ofstream(empty).close();
  EXPECT_NE(load_scene(folder / "tress_missing.json").error().message().find("no such file"), std::string::npos);
  EXPECT_NE(load_scene(empty).error().message().find("an empty file"), std::string::npos);
  EXPECT_NE(load_scene(folder / "nothing").error().message().find("a folder with scene.json or grooms"),
            std::string::npos);
  std::filesystem::remove_all(folder);
}

TEST(LoadScene, LoadsTheScenesOfTheProject) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(TRESS_SOURCE_DIR) / "scenes")) {
    if (entry.path().extension() != ".json" || entry.path().filename() == "schema.json") continue;
    const std::string name = entry.path().filename().string();
    ++scenes;
    const auto scene = load_scene(entry.path());
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_TRUE(scene->warnings.empty());
    for (const auto& p : scene->grooms.at(0).points) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
    const float distance = std::hypot(scene->camera.eye.x, scene->camera.eye.y, scene->camera.eye.z);
    EXPECT_GT(distance, 5) << name;
    EXPECT_LT(distance, 300) << name;
  }
  EXPECT_GE(scenes, 4);
}

TEST(LoadScene, HandsOnTheBasis) {
  const auto file = std::filesystem::path(testing::TempDir()) / "tress_basis.json";
  std::ofstream(file)
      << R"({"grooms": [{"generate": "single_fiber", "basis": "linear"}, {"generate": "single_fiber"}]})";
  const auto scene = load_scene(file);
  std::filesystem::remove(file);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->grooms[0].basis, StrandBasis::linear);
  EXPECT_EQ(scene->grooms[1].basis, StrandBasis::bspline);
}

TEST(Overrides, ReachTheScene) {
  Overrides overrides;
  overrides.eccentricity = 0.7f;
  overrides.sigma_a = glm::vec3(0.1f, 0.2f, 0.3f);
  overrides.width = 32;
  const auto file = std::filesystem::path(TRESS_SOURCE_DIR) / "scenes" / "furnace.json";
  const auto scene = load_scene(file, overrides);
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->materials[0].fiber.eccentricity, 0.7f);
  EXPECT_EQ(scene->materials[0].fiber.sigma_a, glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(scene->image.width, 32);
  overrides.eccentricity = 3.0f;
  EXPECT_NE(load_scene(file, overrides).error().message().find("--eccentricity"), std::string::npos);
}

TEST(SceneFile, PrincipledHairHasTheWidthsThatAreAskedFor) {
  const auto material = [](const std::string& keys) {
    return R"({"materials": [{"principled": {"sigma_a": [0.1, 0.2, 0.3])" + keys + "}}], " + groom + "}";
  };
  fiber::PrincipledHair hair;
  hair.sigma_a = {0.1f, 0.2f, 0.3f};
  for (const auto& [keys, widths] : {std::pair{"", fiber::PrincipledWidths::by_model},
                                     {R"(, "widths": "fitted")", fiber::PrincipledWidths::fitted},
                                     {R"(, "widths": "published")", fiber::PrincipledWidths::published}}) {
    const std::string text = material(keys);
    const auto scene = parse_scene_file(std::vector<unsigned char>(text.begin(), text.end()), "s.json");
    ASSERT_TRUE(scene) << scene.error().message();
    hair.widths = widths;
    EXPECT_EQ(scene->materials[0].fiber, fiber::fiber_of(hair)) << keys;
  }
  EXPECT_NE(message(material(R"(, "widths": "own")")).find("/materials/0/principled/widths"), std::string::npos);
  EXPECT_NE(message(material(R"(, "widths": "published", "aspect_ratio": 0.8)")).find("widths"), std::string::npos);
}

TEST(SceneFile, MaterialXsHairIsReadByItsInputs) {
  const std::string node = R"({"materials": [{"chiang_hair_bsdf": {"ior": 1.5, "tint_TT": [1, 0.5, 0.25],
      "roughness_R": {"longitudinal": 0.04, "azimuthal": 0.3}, "roughness_TRT": {"azimuthal": 0.4},
      "cuticle_angle": 0.51, "absorption_coefficient": [0.1, 0.2, 0.3]}}], )" +
                           groom + "}";
  const auto scene = parse_scene_file(std::vector<unsigned char>(node.begin(), node.end()), "s.json");
  ASSERT_TRUE(scene) << scene.error().message();
  fiber::ChiangHair hair;
  hair.eta = 1.5f;
  hair.tint[1] = {1, 0.5f, 0.25f};
  hair.longitudinal_variance[0] = 0.04f;
  hair.azimuthal_scale = {0.3f, 0.05f, 0.4f};
  hair.cuticle_angle = 0.51f;
  hair.sigma_a = {0.1f, 0.2f, 0.3f};
  EXPECT_EQ(scene->materials[0].fiber, fiber::fiber_of(hair));
  for (const char* other :
       {R"("roughness": 0.3)", R"("tint": {})", R"("principled": {"melanin": 1})", R"("hair": "red")"})
    EXPECT_NE(message(R"({"materials": [{"chiang_hair_bsdf": {}, )" + std::string(other) + "}], " + groom + "}")
                  .find("chiang_hair_bsdf"),
              std::string::npos)
        << other;
  EXPECT_NE(message(R"({"materials": [{"chiang_hair_bsdf": {"roughness_TT": 0.3}}], )" + groom + "}")
                .find("/materials/0/chiang_hair_bsdf/roughness_TT"),
            std::string::npos);
}

Material marschner(const std::string& keys) {
  const std::string text = R"({"materials": [{"marschner": {)" + keys + "}}], " + groom + "}";
  auto scene = parse_scene_file(std::vector<unsigned char>(text.begin(), text.end()), "s.json");
  EXPECT_TRUE(scene) << keys << ": " << scene.error().message();
  return scene ? scene->materials[0] : Material{};
}

TEST(SceneFile, RenderMansHairIsReadByItsParameters) {
  constexpr double degree = std::numbers::pi / 180, deviation = std::numbers::pi / std::numbers::sqrt3;
  const fiber::FiberParameters usual = marschner("").fiber;
  EXPECT_EQ(usual.eccentricity, 1);
  EXPECT_FLOAT_EQ(usual.tilt, static_cast<float>(3 * degree));
  EXPECT_FLOAT_EQ(usual.roughness, static_cast<float>(std::sqrt(2) * 8 * degree));
  EXPECT_FLOAT_EQ(*usual.longitudinal_lambda[1], static_cast<float>(8 * degree / deviation));
  EXPECT_FLOAT_EQ(*usual.azimuthal_sigma[1], static_cast<float>(10 * degree));
  EXPECT_EQ(usual.sigma_a, glm::vec3(0.0f));
  EXPECT_EQ(usual.gain, (fiber::LobeColors{glm::vec3(1.0f), glm::vec3(0.4f), glm::vec3(0.4f), glm::vec3(0.0f),
                                           glm::vec3(0.0f), glm::vec3(0.4f)}));
  EXPECT_FALSE(usual.split_glint);

  const Material set = marschner(R"("specularGainTT": 0.5, "specularColorTT": [1, 0.5, 0.25], "specularOffset": -5,
      "specularConeAngleTRT": 12, "specularGainGLINTS": 2, "specularEccentricity": 0.9, "presence": 0.5,
      "diffuseGain": 1, "diffuseColor": [1, 0, 0], "specularMixFresnel": 0.5, "glowGain": 0)");
  EXPECT_EQ(set.fiber.gain[1], glm::vec3(0.5f, 0.25f, 0.125f));
  EXPECT_EQ(set.fiber.gain[5], glm::vec3(0.8f));
  EXPECT_TRUE(set.fiber.split_glint);
  EXPECT_FLOAT_EQ(set.fiber.tilt, static_cast<float>(5 * degree));
  EXPECT_FLOAT_EQ(*set.fiber.longitudinal_lambda[2], static_cast<float>(12 * degree / deviation));
  EXPECT_EQ(set.fiber.eccentricity, 0.9f);
  EXPECT_EQ(set.presence->value.x, 0.5f);
  EXPECT_EQ(set.left_out, (std::vector<std::string>{"specularMixFresnel", "diffuseGain"}));

  for (const char* other : {R"("roughness": 0.3)", R"("principled": {"melanin": 1})", R"("chiang_hair_bsdf": {})"})
    EXPECT_NE(
        message(R"({"materials": [{"marschner": {}, )" + std::string(other) + "}], " + groom + "}").find("marschner"),
        std::string::npos)
        << other;
  EXPECT_NE(message(R"({"materials": [{"marschner": {"specularIor": 4}}], )" + groom + "}")
                .find("/materials/0/marschner/specularIor"),
            std::string::npos);
}

TEST(SceneFile, RenderMansHairColorIsAnAbsorption) {
  const auto color = [](const std::string& keys) { return marschner(R"("hair_color": {)" + keys + "}"); };
  const Material plain = color(R"("melanin": 0.6, "randomMelanin": 0, "strayDensity": 0, "dye": [1, 0.5, 0.5])");
  EXPECT_FALSE(plain.pigment);
  EXPECT_EQ(plain.fiber.sigma_a,
            fiber::sigma_a_of_principled_melanin(0.6f, 0) + fiber::sigma_a_of_principled_color({1, 0.5f, 0.5f}, 0.3f));
  EXPECT_EQ(plain.fiber.gain[1], glm::vec3(1.0f));
  const Material art = color(R"("mode": 1, "color": [0.6, 0.3, 0.1], "strayDensity": 0, "darkenRoots": 0.5)");
  EXPECT_EQ(art.fiber.sigma_a, fiber::sigma_a_of_lock({0.6f, 0.3f, 0.1f}, art.fiber));
  EXPECT_EQ(art.left_out, std::vector<std::string>{"hair_color/darkenRoots"});

  const Material dark =
      color(R"("melanin": 0.4, "randomMelanin": 0.1, "strayDensity": 0.25, "strayMelanin": 0, "darkenRoots": 0.3)");
  ASSERT_TRUE(dark.pigment);
  int strays = 0;
  for (std::uint64_t strand = 0; strand < 2000; ++strand) {
    const auto melanin = [&](float share) { return dark.pigment->source.at({.share = share, .strand = strand}).x; };
    EXPECT_NEAR(melanin(0) - melanin(1), 0.3f, 1e-5f);
    EXPECT_EQ(melanin(0.5f), melanin(1));
    strays += melanin(1) == 0;
    if (melanin(1) != 0) {
      EXPECT_NEAR(melanin(1), 0.4f, 0.1f + 1e-5f);
    }
  }
  EXPECT_NEAR(strays, 500, 4 * std::sqrt(2000 * 0.25 * 0.75));  // 4 standard deviations of a binomial
  EXPECT_EQ(dark.pigment->sigma_a({0.4f, 0, 0}, {}), fiber::sigma_a_of_principled_melanin(0.4f, 0));
}

}  // namespace
}  // namespace tress::scene
