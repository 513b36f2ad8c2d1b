#include "scene/generate/generated_grooms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "scene/generate/head_grooms.h"
#include "scene/read/assembly.h"
#include "scene/read/scene_file.h"

namespace tress::scene {
namespace {

float strand_length(const Groom& groom, std::uint32_t strand) {
  float length = 0;
  for (std::uint32_t i = groom.first_point[strand] + 1; i < groom.first_point[strand + 1]; ++i)
    length += glm::distance(groom.points[i - 1], groom.points[i]);
  return length;
}

glm::vec3 tip(const Groom& groom, std::uint32_t strand) { return groom.points[groom.first_point[strand + 1] - 1]; }

/// Mean distance from a tip to the nearest other one.
float tip_spacing(const Groom& groom) {
  float sum = 0;
  for (std::uint32_t a = 0; a < groom.strand_count(); ++a) {
    float nearest = 1e30f;
    for (std::uint32_t b = 0; b < groom.strand_count(); ++b)
      if (a != b) nearest = std::min(nearest, glm::distance(tip(groom, a), tip(groom, b)));
    sum += nearest;
  }
  return sum / static_cast<float>(groom.strand_count());
}

std::string message(const std::string& groom) {
  const std::string text = R"({"grooms": [{)" + groom + "}]}";
  const std::vector<unsigned char> bytes(text.begin(), text.end());
  const auto scene = parse_scene_file(bytes, "s.json");
  return scene ? "" : scene.error().message();
}

TEST(GeneratedGrooms, HaveThePapersCountsAndRepeat) {
  const auto curly = generate_groom({.kind = "curly_lock"});
  EXPECT_EQ(curly.strand_count(), 5513u);
  EXPECT_EQ(usual_strands("straight"), 19226u);
  EXPECT_EQ(generate_groom({.kind = "curly_lock"}).points, curly.points);
  EXPECT_NE(generate_groom({.kind = "curly_lock", .seed = 1}).points, curly.points);
}

TEST(GeneratedGrooms, AreFiniteAndOfTheSizeTheyState) {
  for (const std::string& kind : generated_groom_kinds()) {
    const GroomRecipe recipe{.kind = kind, .strands = 300};
    const Groom groom = generate_groom(recipe);
    ASSERT_EQ(groom.strand_count(), 300u) << kind;
    ASSERT_EQ(groom.points.size(), 300u * points_per_strand(recipe)) << kind;
    ASSERT_EQ(groom.radius_cm.size(), groom.points.size()) << kind;
    for (const glm::vec3& p : groom.points) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z)) << kind;
    for (const float radius : groom.radius_cm) ASSERT_GT(radius, 0) << kind;
    for (std::uint32_t s = 0; s < 300; ++s) ASSERT_GT(strand_length(groom, s), 0.1f) << kind << " " << s;
  }
}

TEST(GeneratedGrooms, HaveRootUvForTextures) {
  for (const std::string& kind : generated_groom_kinds()) {
    const Groom groom = generate_groom({.kind = kind, .strands = 300});
    ASSERT_EQ(groom.root_uv.size(), 300u) << kind;
    for (const glm::vec2& uv : groom.root_uv)
      ASSERT_TRUE(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1) << kind << " " << uv.x << " " << uv.y;
  }
  // Seen from outside the picture is upright: the left ear (+x, the face towards +y) is left of the face, the top high.
  const Groom fur = generate_groom({.kind = "fur_ball", .strands = 300});
  for (std::uint32_t s = 0; s < 300; ++s) {
    const glm::vec3 root = glm::normalize(fur.points[fur.first_point[s]]);
    const glm::vec2 uv = fur.root_uv[s];
    EXPECT_NEAR(uv.y, 0.5f + std::asin(root.z) / std::numbers::pi_v<float>, 1e-5f);
    EXPECT_EQ(root.x > 0, uv.x < 0.5f) << root.x;
    EXPECT_EQ(root.y > 0, uv.x > 0.25f && uv.x < 0.75f) << root.y;
  }
  const Groom curtain = generate_groom({.kind = "curtain", .strands = 300});
  const auto right = std::ranges::max_element(curtain.root_uv, {}, &glm::vec2::x) - curtain.root_uv.begin();
  for (std::uint32_t s = 0; s < 300; ++s)
    EXPECT_LE(curtain.points[curtain.first_point[s]].x, curtain.points[curtain.first_point[std::size_t(right)]].x);
}

TEST(GeneratedGrooms, StandTheEndsOfEveryRange) {
  for (const std::string& kind : generated_groom_kinds())
    for (const ShapeParameter& parameter : shape_parameters(kind)) {
      ASSERT_LE(parameter.low, parameter.usual);
      ASSERT_LE(parameter.usual, parameter.high);
      for (const double value : {parameter.low, parameter.high}) {
        GroomRecipe recipe{.kind = kind, .strands = 3};
        recipe.shape[parameter.key] = value;
        for (const glm::vec3& p : generate_groom(recipe).points)
          ASSERT_TRUE(std::isfinite(p.x + p.y + p.z)) << kind << " " << parameter.key << " " << value;
      }
    }
}

TEST(GeneratedGrooms, GrowHairOutsideTheHead) {
  for (const char* kind : {"straight", "wavy", "curly", "layered"})
    for (const glm::vec3& p : generate_groom({.kind = kind, .strands = 500}).points)
      ASSERT_GT(glm::length(p / head_semi_axes_cm()), 0.999f) << kind;
}

TEST(GeneratedGrooms, LayersHideTheScalpAndLeaveTheFaceFree) {
  const Groom groom = generate_groom({.kind = "layered", .strands = 20000});
  std::vector<glm::vec3> on_head;  // where each strand stands over the head, on its unit sphere
  for (const glm::vec3& p : groom.points) {
    const glm::vec3 n = p / head_semi_axes_cm();
    if (glm::length(n) < 1.3f) on_head.push_back(glm::normalize(n));
    ASSERT_FALSE(n.y > 0.8f && n.z < 0 && n.z > -1) << n.x << " " << n.y << " " << n.z;
  }
  // No parting, no crown that shows: 20,000 strands of 0.5 cm between points leave no gap of 0.06, half a centimetre.
  RandomStream random(1, 2, 3);
  for (int i = 0; i < 60; ++i) {
    const glm::vec3 spot = scalp_point(random);
    float nearest = 4;
    for (const glm::vec3& n : on_head) nearest = std::min(nearest, glm::dot(n - spot, n - spot));
    EXPECT_LT(nearest, 0.06f * 0.06f) << spot.x << " " << spot.y << " " << spot.z;
  }
}

TEST(GeneratedGrooms, CurlsTakeMoreHairThanTheFall) {
  GroomRecipe recipe{.kind = "curly", .strands = 200};
  recipe.shape = {{"length_cm", 40.0},    {"length_variation", 0.0},
                  {"wavelength_cm", 4.0}, {"curl_diameter_cm", 2.0},
                  {"clump", 1.0},         {"frizz", 0.0}};
  const Groom groom = generate_groom(recipe);
  double sum = 0;
  for (std::uint32_t s = 0; s < 200; ++s) sum += strand_length(groom, s);
  // A helix of this diameter and pitch is sqrt(1 + (pi/2)^2) = 1.86 times as long as its axis; the root is straight,
  // 10 chords a turn are 3 % short, clumps vary in pitch by 15 % and in diameter by 18 %, and in length with height.
  const double ratio = sum / 200 / 40;
  EXPECT_GT(ratio, 1.5);
  EXPECT_LT(ratio, 1.95);
}

TEST(GeneratedGrooms, LayeredHairCurlsWhereADiameterIsGiven) {
  GroomRecipe plain{.kind = "layered", .strands = 200}, curls = plain;
  plain.shape = curls.shape = {{"wavelength_cm", 4.0}, {"wave_amplitude_cm", 0.0}, {"frizz", 0.0}};
  curls.shape["curl_diameter_cm"] = 2.0;
  const Groom straight = generate_groom(plain), curly = generate_groom(curls);
  double fall = 0, along = 0;
  for (std::uint32_t s = 0; s < 200; ++s) fall += strand_length(straight, s), along += strand_length(curly, s);
  // A helix of this diameter and pitch is 1.86 times as long as its axis; it opens over 5 cm, and pitch and diameter
  // vary by a fifth.
  EXPECT_GT(along / fall, 1.3);
  EXPECT_LT(along / fall, 2.2);
}

TEST(GeneratedGrooms, ACurtainIsAsWideAsItStatesAndCurlsWhereADiameterIsGiven) {
  GroomRecipe plain{.kind = "curtain", .strands = 2000};
  plain.shape = {{"width_cm", 20.0},     {"length_cm", 30.0},        {"length_variation", 0.0},
                 {"wavelength_cm", 4.0}, {"wave_amplitude_cm", 0.0}, {"frizz", 0.0}};
  GroomRecipe curls = plain;
  curls.shape["curl_diameter_cm"] = 2.0;
  const Groom straight = generate_groom(plain), curly = generate_groom(curls);
  float least = 0, most = 0;
  double fall = 0, along = 0;
  for (std::uint32_t s = 0; s < 2000; ++s) {
    const glm::vec3 root = straight.points[straight.first_point[s]];
    ASSERT_EQ(root.z, 0);
    least = std::min(least, root.x), most = std::max(most, root.x);
    ASSERT_NEAR(tip(straight, s).z, -30, 1e-3);
    fall += strand_length(straight, s), along += strand_length(curly, s);
  }
  // Wisps and strings reach beyond the locks' roots, which end within the width: by 1.1 cm together.
  EXPECT_NEAR(most - least, 20, 2.3);
  // A helix of this diameter and pitch is 1.86 times as long as its axis; it opens over 6 cm and narrows by a quarter.
  EXPECT_GT(along / fall, 1.3);
  EXPECT_LT(along / fall, 2.0);
}

TEST(GeneratedGrooms, GatherTipsByTheStrengthOfTheirClumps) {
  for (const char* kind : {"curly_lock", "straight", "wavy", "curly", "layered", "curtain", "fur_ball"}) {
    GroomRecipe loose{.kind = kind, .strands = 1500}, tight = loose;
    loose.shape = {{"clump", 0.0}, {"frizz", 0.0}};
    tight.shape = {{"clump", 1.0}, {"frizz", 0.0}};
    EXPECT_LT(tip_spacing(generate_groom(tight)), 0.8f * tip_spacing(generate_groom(loose))) << kind;
  }
}

TEST(GeneratedGrooms, CombFurDownAndKeepItOutsideTheBall) {
  GroomRecipe recipe{.kind = "fur_ball", .strands = 2000};
  recipe.shape["ball_radius_cm"] = 3;
  const Groom groom = generate_groom(recipe);
  double fall = 0;
  for (std::uint32_t s = 0; s < groom.strand_count(); ++s) {
    const glm::vec3 root = groom.points[groom.first_point[s]];
    ASSERT_NEAR(glm::length(root), 3, 0.35);
    fall += root.z - tip(groom, s).z;
  }
  EXPECT_GT(fall / 2000, 0.3);
  for (const glm::vec3& p : groom.points) ASSERT_GT(glm::length(p), 2.4f);
}

TEST(GroomTaper, IsLinearAlongTheLengthOfTheStrand) {
  Groom groom;
  groom.first_point = {0, 3, 5};
  groom.points = {{0, 0, 0}, {1, 0, 0}, {4, 0, 0}, {0, 1, 0}, {0, 2, 0}};
  groom.radius_cm = {0.01f, 0.02f, 0.01f, 0.01f, 0.01f};
  apply_taper({.root = 1, .tip = 0.2}, &groom);
  EXPECT_FLOAT_EQ(groom.radius_cm[0], 0.01f);
  EXPECT_FLOAT_EQ(groom.radius_cm[1], 0.016f);  // a quarter of the way: .8 of .02
  EXPECT_FLOAT_EQ(groom.radius_cm[2], 0.002f);
  EXPECT_FLOAT_EQ(groom.radius_cm[4], 0.002f);
  apply_taper({.root = 1, .tip = 0}, &groom);
  EXPECT_FLOAT_EQ(groom.radius_cm[4], 0);
}

TEST(GroomReader, TakesTheKeysOfItsKindOnly) {
  EXPECT_EQ(message(R"("generate": "wavy", "wave_amplitude_cm": 1, "taper": {"root": 1, "tip": 0.2})"), "");
  const std::pair<std::string, std::string> wrong[] = {
      {R"("generate": "straight", "wavelength_cm": 3)", "/grooms/0/wavelength_cm: expected a key that shapes"},
      {R"("generate": "wavy", "wave_amplitude_cm": 11)", "/grooms/0/wave_amplitude_cm: expected 0..10 cm, found 11"},
      {R"("generate": "curly", "clump": -1)", "/grooms/0/clump"},
      {R"("file": "a.hair", "clump": 1)", "/grooms/0/clump: expected this key beside \"generate\""},
      {R"("generate": "wavy", "up": "y")", "/grooms/0/up"},
      {R"("generate": "wavy", "taper": {"tip": -1})", "/grooms/0/taper/tip"},
      {R"("generate": "wavy", "taper": {"middle": 1})", "/grooms/0/taper"},
      {R"("generate": "wavy", "wavelength_cm": 0.2, "strands": 1000000)", "/grooms/0/strands: expected at most"}};
  for (const auto& [groom, place] : wrong) EXPECT_NE(message(groom).find(place), std::string::npos) << message(groom);
}

}  // namespace
}  // namespace tress::scene
