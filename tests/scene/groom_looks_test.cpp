// Grooms of which some strands have another material.
#include "scene/read/groom_looks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <string>

#include "scene/read/load_scene.h"

namespace tress::scene {
namespace {

Result<Scene> loaded(const std::string& groom, const std::filesystem::path& folder = TRESS_SOURCE_DIR "/scenes") {
  const std::string text =
      R"({"materials": [{"name": "a"}, {"name": "b"}, {"name": "c"}], "grooms": [{)" + groom + "}]}";
  return load_scene({reinterpret_cast<const unsigned char*>(text.data()), text.size()}, "s.json", folder, {}, {});
}

Scene scene_of(const std::string& groom) {
  auto scene = loaded(groom);
  EXPECT_TRUE(scene) << scene.error().message();
  Scene found;
  if (scene) found = std::move(*scene);
  return found;
}

// Of 4,000 strands each look has its share within four standard deviations of a binomial: for the two of them that
// fails once in 8,000 choices of a hash, which is fixed.
TEST(GroomLooks, AreOfTheirSharesOfStrandsWhichStayWhatTheyAre) {
  const std::string groom = R"("generate": "straight", "strands": 4000, "material": "b")";
  const Scene whole = scene_of(groom);
  const Scene scene =
      scene_of(groom + R"(, "looks": [{"material": "c", "share": 0.3}, {"material": "a", "share": 0.05}])");
  ASSERT_EQ(scene.grooms.size(), 3u);
  const double shares[] = {0.65, 0.3, 0.05};
  const std::uint32_t materials[] = {1, 2, 0};
  std::set<std::int64_t> ids;
  for (std::size_t k = 0; k < 3; ++k) {
    const Groom& part = scene.grooms[k];
    EXPECT_EQ(part.material, materials[k]);
    EXPECT_EQ(part.object, whole.grooms[0].object) << "one matte";
    EXPECT_NEAR(part.strand_count() / 4000.0, shares[k], 4 * std::sqrt(shares[k] * (1 - shares[k]) / 4000));
    ASSERT_EQ(part.radius_cm.size(), part.points.size());
    for (std::uint32_t s = 0; s < part.strand_count(); ++s) {
      const auto id = static_cast<std::uint32_t>(part.strand_id(s));
      ids.insert(id);
      ASSERT_EQ(part.first_point[s + 1] - part.first_point[s],
                whole.grooms[0].first_point[id + 1] - whole.grooms[0].first_point[id]);
      EXPECT_EQ(part.points[part.first_point[s]], whole.grooms[0].points[whole.grooms[0].first_point[id]]);
    }
  }
  EXPECT_EQ(ids.size(), 4000u) << "each strand once";
}

TEST(GroomLooks, OfAllStrandsOrOfNoneMakeNoOtherGroom) {
  const std::string groom = R"("generate": "straight", "strands": 50, "material": "b", "looks": [)";
  const Scene all = scene_of(groom + R"({"material": "c", "share": 1}])");
  ASSERT_EQ(all.grooms.size(), 1u);
  EXPECT_EQ(all.grooms[0].material, 2u);
  const Scene none = scene_of(groom + R"({"material": "c", "share": 0}])");
  ASSERT_EQ(none.grooms.size(), 1u);
  EXPECT_EQ(none.grooms[0].material, 1u);
  EXPECT_EQ(none.grooms[0].strand_count(), 50u);
}

// A mask of the file, and what else it has by strand and by point; while the shutter is open, too.
TEST(GroomLooks, FollowAMaskAndKeepWhatAStrandHas) {
  Groom groom;
  groom.object = "hair";
  groom.basis = StrandBasis::linear;
  groom.first_point = {0, 2, 5, 7};
  for (int i = 0; i < 7; ++i) {
    groom.points.push_back({static_cast<float>(i), 0, 0});
    groom.radius_cm.push_back(0.1f + static_cast<float>(i));
    groom.minor_axis.push_back({0, static_cast<float>(i), 1});
  }
  groom.later.push_back({groom.points, glm::dmat3(1.0), groom.radius_cm});
  groom.color = {glm::vec3(0), glm::vec3(1), glm::vec3(0)};
  groom.id = {7, 9, 11};
  groom.root_uv = {{0, 0}, {0.5f, 0.5f}, {1, 1}};
  Source mask;
  mask.kind = Source::Kind::attribute;
  mask.value = glm::vec3(1.0f);
  const std::vector<Groom> parts = divided(groom, {{1, mask}});
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].id, (std::vector<std::int64_t>{7, 11}));
  EXPECT_EQ(parts[0].first_point, (std::vector<std::uint32_t>{0, 2, 4}));
  EXPECT_EQ(parts[1].id, (std::vector<std::int64_t>{9}));
  EXPECT_EQ(parts[1].material, 1u);
  EXPECT_EQ(parts[1].color, (std::vector<glm::vec3>{glm::vec3(1)}));
  EXPECT_EQ(parts[1].root_uv, (std::vector<glm::vec2>{{0.5f, 0.5f}}));
  EXPECT_EQ(parts[1].points, (std::vector<glm::vec3>{{2, 0, 0}, {3, 0, 0}, {4, 0, 0}}));
  EXPECT_EQ(parts[1].later[0].points, parts[1].points);
  EXPECT_EQ(parts[1].later[0].radius_cm, parts[1].radius_cm);
  EXPECT_EQ(parts[1].minor_axis[0], glm::vec3(0, 2, 1));
}

// A strand keeps its look when others are culled: it goes by ids.
TEST(GroomLooks, DependOnTheIdOfAStrandAlone) {
  Groom groom;
  groom.object = "hair";
  groom.first_point = {0};
  for (int strand = 0; strand < 200; ++strand) {
    groom.points.insert(groom.points.end(), 2, glm::vec3(static_cast<float>(strand), 0, 0));
    groom.radius_cm.insert(groom.radius_cm.end(), 2, 0.1f);
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
    groom.id.push_back(3 * strand + 1);
  }
  Groom culled = groom;
  culled.first_point.resize(101);
  culled.points.resize(200);
  culled.radius_cm.resize(200);
  culled.id.resize(100);
  const std::vector<GroomLook> looks{{1, {.value = glm::vec3(0.4f)}}};
  const std::vector<Groom> all = divided(groom, looks), some = divided(culled, looks);
  ASSERT_EQ(all.size(), 2u);
  ASSERT_EQ(some.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    std::vector<std::int64_t> expected;
    for (const std::int64_t id : all[k].id)
      if (id < 300) expected.push_back(id);
    EXPECT_EQ(some[k].id, expected);
  }
}

TEST(GroomLooks, RefuseWhatContradicts) {
  const std::pair<std::string, std::string> wrong[] = {
      {R"([{"material": "x", "share": 0.1}])", "/grooms/0/looks/0/material: expected a name of /materials"},
      {R"([{"share": 0.1}])", "/grooms/0/looks/0/material: expected this key"},
      {R"([{"material": "a"}])", "/grooms/0/looks/0/share: expected this key"},
      {R"([{"material": "a", "share": 1.5}])", "/grooms/0/looks/0/share: expected 0..1, found 1.5"},
      {R"([{"material": "a", "share": 0.6}, {"material": "c", "share": 0.5}])", "/grooms/0/looks: expected shares of"},
      {R"([{"material": "a", "share": {"attribute": "mask"}}])", "/grooms/0/looks: expected colors and numbers"}};
  for (const auto& [looks, why] : wrong) {
    const auto scene = loaded(R"("generate": "straight", "strands": 9, "material": "b", "looks": )" + looks);
    ASSERT_FALSE(scene) << looks;
    EXPECT_NE(scene.error().message().find(why), std::string::npos) << scene.error().message();
  }
}

}  // namespace
}  // namespace tress::scene
