#include "cli/live_look.h"

#include <gmock/gmock.h>

#include <map>
#include <string>
#include <vector>

#include "scene/read/source_reader.h"
#include "tress/fiber/lock_color.h"

namespace tress::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> names(const cli::RenderSettings& settings, const scene::Scene& scene) {
  std::vector<std::string> found;
  for (const auto& slider : cli::sliders_of(settings, scene)) found.push_back(slider.name);
  return found;
}

/// A slider that would move nothing is not shown: the widths and the shape of a node's fiber are the node's.
TEST(LiveLook, OffersTheSlidersThatDoSomethingToTheHair) {
  scene::Scene scene;
  scene.materials.resize(2);
  EXPECT_THAT(names({}, scene), ElementsAre("melanin", "roughness", "eccentricity", "tilt", "lights"));
  scene.materials[0].has_node_widths = true;
  EXPECT_THAT(names({}, scene), ElementsAre("melanin", "roughness", "eccentricity", "tilt", "lights"));
  scene.materials[1].has_node_widths = true;
  EXPECT_THAT(names({}, scene), ElementsAre("melanin", "tilt", "lights"));
}

TEST(LiveLook, OffersNoneBesideFilesThatDescribeOnePicture) {
  scene::Scene scene;
  scene.materials.resize(1);
  cli::RenderSettings settings;
  settings.checkpoint = "a.checkpoint";
  EXPECT_THAT(names(settings, scene), ElementsAre());
}

/// The color of hair whose melanin or absorption is known is that with which it would have been made.
TEST(LiveLook, ShowsTheColorOfTheFirstMaterial) {
  scene::Scene scene;
  scene.materials.resize(1);
  fiber::FiberParameters& fiber = scene.materials[0].fiber;
  fiber.sigma_a = fiber::sigma_a_of_lock({0.4f, 0.2f, 0.1f}, fiber);
  EXPECT_EQ(cli::color_of(scene), (live::RenderServer::Json{0.4, 0.2, 0.1}));
  auto source =
      scene::parse_color(R"({"ramp": [[0.25, [0.1, 0.2, 0.3]], [1, [0.8, 0.8, 0.8]]], "interpolation": "smooth"})");
  ASSERT_TRUE(source);
  scene::Pigment& pigment = scene.materials[0].pigment.emplace();
  pigment.source = *source;
  pigment.sigma_a = fiber::sigma_a_of_lock;
  EXPECT_EQ(cli::color_of(scene).dump(),
            R"({"ramp":[[0.25,[0.1,0.2,0.3]],[1.0,[0.8,0.8,0.8]]],"interpolation":"smooth"})");
}

TEST(LiveLook, AColorReplacesTheMelaninAsTheOptionDoes) {
  cli::RenderSettings settings;
  settings.given_options = {{"--melanin", "3"}, {"--spp", "4"}};
  settings.overrides.melanin = {3.0f, 0.0f};
  const std::string color = R"({"ramp":[[0,[0.1,0.2,0.3]],[1,[0.8,0.8,0.8]]]})";
  EXPECT_EQ(cli::fault_of_color(color), "");
  const cli::RenderSettings changed = cli::with_look(settings, {{{"tilt", 1}}, color});
  EXPECT_EQ(changed.overrides.color_source, color);
  EXPECT_FALSE(changed.overrides.melanin);
  EXPECT_EQ(changed.given_options,
            (std::map<std::string, std::string>{{"--color", color}, {"--cuticle-tilt", "1"}, {"--spp", "4"}}));
}

TEST(LiveLook, AColorThatNoSceneMayHaveIsRefusedWithItsPlace) {
  EXPECT_THAT(cli::fault_of_color(R"({"ramp": [[0, [0.1, 2, 0.1]]]})"), HasSubstr("--color/ramp/0/1/1: expected"));
  EXPECT_THAT(cli::fault_of_color(R"({"ramp": [[0.5, [0, 0, 0.1]], [0.5, [0.1, 0.1, 0.1]]]})"),
              HasSubstr("--color/ramp/"));
  EXPECT_THAT(cli::fault_of_color(R"({"mix": [[0.1, 0.1, 0.1], {"texture": "a.png"}], "share": 0.5})"),
              HasSubstr("without textures"));
  EXPECT_THAT(cli::fault_of_color(R"({"attribute": "Cd"})"), HasSubstr("without textures"));
  for (const char* text : {"", "null", "\"file\"", "[1, 2]", "{\"ramp\""})
    EXPECT_NE(cli::fault_of_color(text), "") << text;
}

}  // namespace
}  // namespace tress::test
