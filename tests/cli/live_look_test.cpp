#include "cli/live_look.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

namespace tress::test {
namespace {

using ::testing::ElementsAre;

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

}  // namespace
}  // namespace tress::test
