// Links of lights to objects, and what rays meet objects: how they are read.
#include <gtest/gtest.h>

#include <string>

#include "scene/read/load_scene.h"

namespace tress::scene {
namespace {

const std::string distant = R"("distant": {"elevation_deg": 30, "radiance": [1, 1, 1]})";

Result<Scene> loaded(const std::string& lights, const std::string& groom = "",
                     const std::string& environment = R"({"constant": [1, 1, 1]})") {
  const std::string text = R"({"environment": )" + environment + R"(, "lights": [)" + lights +
                           R"(], "grooms": [{"name": "fringe", "generate": "single_fiber")" + groom +
                           R"(}, {"generate": "straight", "strands": 9}]})";
  return load_scene({reinterpret_cast<const unsigned char*>(text.data()), text.size()}, "s.json",
                    TRESS_SOURCE_DIR "/scenes", {}, {});
}

Scene scene_of(const std::string& lights, const std::string& groom = "",
               const std::string& environment = R"({"constant": [1, 1, 1]})") {
  auto scene = loaded(lights, groom, environment);
  EXPECT_TRUE(scene) << scene.error().message();
  return scene ? std::move(*scene) : Scene();
}

TEST(LightLinks, HaveTheirNamesOrAllOthers) {
  const Scene scene = scene_of("{" + distant + "}, {" + distant +
                               R"(, "light_link": {"include": ["fringe"]}, "shadow_link": {"exclude": ["straight"]}},
                                 {)" +
                               distant + R"(, "light_link": {"include": []}, "shadow_link": {"exclude": []}})");
  ASSERT_EQ(scene.lights.size(), 3u);
  const auto has = [&](std::size_t light, const char* name) {
    const LightLinks& links = scene.lights[light].links;
    return std::pair(links.lit.has(name), links.blocking.has(name));
  };
  EXPECT_EQ(has(0, "fringe"), std::pair(true, true));
  EXPECT_EQ(has(1, "fringe"), std::pair(true, true));
  EXPECT_EQ(has(1, "straight"), std::pair(false, false));
  EXPECT_EQ(has(2, "straight"), std::pair(false, true));
}

TEST(LightLinks, OfAnEnvironmentAreThoseOfItsSunToo) {
  const Scene scene = scene_of("", "",
                               R"({"sky": {"sun": {"elevation_deg": 30, "radiance": [1, 1, 1]}},
                                   "light_link": {"exclude": ["fringe"]}, "shadow_link": {"include": ["fringe"]}})");
  ASSERT_EQ(scene.lights.size(), 1u);
  for (const LightLinks& links : {scene.environment_links, scene.lights[0].links}) {
    EXPECT_FALSE(links.lit.has("fringe"));
    EXPECT_TRUE(links.lit.has("straight"));
    EXPECT_TRUE(links.blocking.has("fringe"));
    EXPECT_FALSE(links.blocking.has("straight"));
  }
}

TEST(LightLinks, ToNoObjectAreRefusedByWhatThereIs) {
  const std::string there = R"(expected the name of a groom or mesh (the nearest is "fringe"; there are "fringe", )"
                            R"("straight"), found "fridge")";
  const auto light =
      loaded("{" + distant + "}, {" + distant + R"(, "shadow_link": {"exclude": ["fringe", "fridge"]}})");
  ASSERT_FALSE(light);
  EXPECT_EQ(light.error().message(), "s.json: /lights/1/shadow_link/exclude/1: " + there);
  const auto sky = loaded("", "", R"({"studio": true, "light_link": {"include": ["fridge"]}})");
  ASSERT_FALSE(sky);
  EXPECT_EQ(sky.error().message(), "s.json: /environment/light_link/include/0: " + there);
  for (const char* wrong : {R"({})", R"({"include": [], "exclude": []})", R"({"include": "fringe"})", R"(["fringe"])",
                            R"({"include": [3]})", R"({"only": ["fringe"]})"}) {
    const auto scene = loaded("{" + distant + R"(, "light_link": )" + wrong + "}");
    ASSERT_FALSE(scene) << wrong;
    EXPECT_EQ(scene.error().place.find("/lights/0/light_link"), 0u) << scene.error().message();
  }
}

TEST(Visibility, IsReadForEachKindOfRay) {
  const Scene scene =
      scene_of("", R"(, "visible": false, "visible_indirect": false, "looks": [{"material": "brown", "share": 0}])");
  ASSERT_EQ(scene.grooms.size(), 2u);
  const Visibility seen = scene.grooms[0].visibility, other = scene.grooms[1].visibility;
  EXPECT_FALSE(seen.camera);
  EXPECT_TRUE(seen.shadow);
  EXPECT_FALSE(seen.indirect);
  EXPECT_TRUE(other.camera && other.shadow && other.indirect);
  EXPECT_FALSE(scene_of("", R"(, "casts_shadow": false)").grooms[0].visibility.shadow);
}

}  // namespace
}  // namespace tress::scene
