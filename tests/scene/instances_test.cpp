// Instances of grooms in scene files: where they are, when they move, what is wrong with them, and their strands
// written out.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <span>
#include <string>

#include "scene/model/groom_bounds.h"
#include "scene/read/load_scene.h"
#include "scene/read/scene_strands.h"

namespace tress::scene {
namespace {

using ::testing::HasSubstr;

Result<Scene> load(const std::string& camera, const std::string& instances, const std::string& more = "",
                   const Overrides& overrides = {}) {
  const std::string text =
      fmt::format(R"({{"camera": {}, "grooms": [{{"generate": "single_fiber", "length_cm": 2, "instances": {}{}}}]}})",
                  camera, instances, more);
  return load_scene(std::span(reinterpret_cast<const unsigned char*>(text.data()), text.size()), "s.json", ".", {},
                    overrides);
}

const std::string framed = R"({"frame": true})";

TEST(Instances, AreScaledTurnedAndMovedAfterTheGroom) {
  const auto alone = load(framed, R"([{}])");
  const auto scene =
      load(framed, R"([{"scale": 2, "rotate_deg": [0, 0, 90], "translate": [10, 0, 0]}, {"translate": [0, 0, 5]}])",
           R"(, "translate": [1, 0, 0])");
  ASSERT_TRUE(alone && scene) << scene.error().message();
  const Groom &own = alone->grooms[0], &groom = scene->grooms[0];
  ASSERT_EQ(groom.instances.size(), 2u);
  for (std::size_t i = 0; i < own.points.size(); ++i) {
    const glm::vec3 moved = own.points[i] + glm::vec3(1, 0, 0);
    EXPECT_NEAR(glm::distance(groom.points[i], moved), 0, 1e-5f);
    const glm::vec3 placed = 2.0f * glm::vec3(-moved.y, moved.x, moved.z) + glm::vec3(10, 0, 0);
    EXPECT_NEAR(glm::distance(groom.instances[0].first.point(groom.points[i]), placed), 0, 1e-4f);
    EXPECT_NEAR(glm::distance(groom.instances[0].first.local_point(placed), moved), 0, 1e-5f);
    EXPECT_NEAR(glm::distance(groom.instances[1].first.point(groom.points[i]), moved + glm::vec3(0, 0, 5)), 0, 1e-5f);
  }
}

TEST(Instances, AreAllSeenByAFramedCamera) {
  const auto one = load(framed, R"([{}])"), two = load(framed, R"([{}, {"translate": [200, 0, 0]}])");
  ASSERT_TRUE(one && two);
  EXPECT_NEAR(two->camera.look_at.x - one->camera.look_at.x, 100, 0.01f);
  EXPECT_GT(glm::distance(two->camera.eye, two->camera.look_at), 200);
}

TEST(Instances, MoveByKeysAndOnATurntable) {
  const std::string shutter = R"("shutter": {"open": 0, "close": 1})";
  const auto keys =
      load(fmt::format(R"({{"eye": [0, -50, 0], {}}})", shutter),
           R"([{}, {"frames": [{"frame": 0, "translate": [0, 0, 0]}, {"frame": 10, "translate": [10, 0, 0]}]}])", "",
           {.frame = 4});
  ASSERT_TRUE(keys) << keys.error().message();
  EXPECT_TRUE(keys->grooms[0].instances[0].later.empty());
  ASSERT_EQ(keys->grooms[0].instances[1].later.size(), 1u);
  EXPECT_NEAR(keys->grooms[0].instances[1].first.offset.x, 4, 1e-5f);
  EXPECT_NEAR(keys->grooms[0].instances[1].at(0.5f).offset.x, 4.5f, 1e-5f);
  EXPECT_TRUE(keys->grooms[0].later.empty()) << "the strands themselves rest";

  const auto turned = load(fmt::format(R"({{"turntable": {{"frames": 4, "look_at": [0, 0, 0]}}, {}}})", shutter),
                           R"([{"translate": [10, 0, 0]}])", "", {.frame = 1});
  ASSERT_TRUE(turned) << turned.error().message();
  const Instance& instance = turned->grooms[0].instances[0];  // a quarter, clockwise from above
  EXPECT_NEAR(glm::distance(instance.first.offset, {0, -10, 0}), 0, 1e-4f);
  EXPECT_NEAR(glm::distance(instance.first.turn[0], {0, -1, 0}), 0, 1e-5f);
  ASSERT_EQ(instance.later.size(), 1u);
  EXPECT_NEAR(glm::distance(instance.later[0].offset, {-10, 0, 0}), 0, 1e-4f);
}

TEST(Instances, AreWrittenOutByStrandsOf) {
  const auto scene = load(framed, R"([{"scale": 2, "translate": [10, 0, 0]}, {}, {"rotate_deg": [0, 90, 0]}])");
  ASSERT_TRUE(scene);
  const Groom& groom = scene->grooms[0];
  const auto strands = strands_of(*scene);
  ASSERT_TRUE(strands) << strands.error().message();
  ASSERT_EQ(strands->strand_count(), 3 * groom.strand_count());
  ASSERT_EQ(strands->parts.size(), 1u);
  EXPECT_EQ(strands->parts[0].strands, 3 * groom.strand_count());
  EXPECT_THAT(strands->parts[0].name, HasSubstr(", 3 instances"));
  for (std::size_t i = 0; i < groom.points.size(); ++i) {
    EXPECT_NEAR(glm::distance(strands->points[i], 2.0f * groom.points[i] + glm::vec3(10, 0, 0)), 0, 1e-5f);
    EXPECT_FLOAT_EQ(strands->width[i], 4 * groom.radius_cm[i]);
  }
}

TEST(Instances, ThatAreWrongAreNamed) {
  for (const auto& [instances, place, expected] :
       {std::tuple{"[]", "/grooms/0/instances", "one instance or more"},
        {"[{\"scale\": 0}]", "/grooms/0/instances/0/scale", ""},
        {"[{}, {\"shear\": 1}]", "/grooms/0/instances/1", "shear"},
        {"[{\"scale\": 1e6, \"translate\": [0, 0, -1e6]}]", "instances", "within 1e+06 cm"}}) {
    const auto scene = load(framed, instances);
    ASSERT_FALSE(scene) << instances;
    EXPECT_THAT(scene.error().message(), HasSubstr(place));
    EXPECT_THAT(scene.error().message(), HasSubstr(expected));
  }
}

}  // namespace
}  // namespace tress::scene
