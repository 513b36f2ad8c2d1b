// Values that vary: what the keys of a source mean, and what is refused.
#include "scene/model/source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/ext/vector_double3.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "scene/model/strand_fibers.h"
#include "scene/read/scene_file.h"
#include "tress/base/random.h"
#include "tress/fiber/lock_color.h"
#include "tress/fiber/parameter_ranges.h"
#include "tress/fiber/principled_hair.h"

namespace tress::scene {
namespace {

Result<SceneDescription> scene_of(const std::string& material) {
  const std::string text = R"({"materials": [{"name": "m", )" + material + R"(}], "grooms": [{"file": "a.hair"}]})";
  return parse_scene_file(std::vector<unsigned char>(text.begin(), text.end()), "s.json");
}

Material material_of(const std::string& text) {
  auto scene = scene_of(text);
  EXPECT_TRUE(scene) << text << ": " << scene.error().message();
  return scene ? scene->materials[0] : Material{};
}

std::string refusal(const std::string& material) {
  const auto scene = scene_of(material);
  return scene ? "" : scene.error().message();
}

/// The absorption at a place.
glm::vec3 absorption(const Material& material, const StrandPlace& place) {
  if (!material.pigment) return material.fiber.sigma_a;
  return material.pigment->at(place, material.fiber);
}

void expect_near(const glm::vec3& found, const glm::vec3& expected) {
  EXPECT_LT(glm::distance(found, expected), 1e-5f * (1 + glm::length(expected)))
      << found.x << " " << found.y << " " << found.z;
}

TEST(Sources, RampsGoByShareOrByCentimetresFromEitherEnd) {
  const Material share = material_of(R"("sigma_a": {"ramp": [[0.2, [1, 0, 0]], [0.6, [0, 2, 0]], [1, [0, 0, 4]]]})");
  expect_near(absorption(share, {.share = 0}), {1, 0, 0});
  expect_near(absorption(share, {.share = 0.4f}), {0.5f, 1, 0});
  expect_near(absorption(share, {.share = 0.6f}), {0, 2, 0});
  expect_near(absorption(share, {.share = 0.7f}), {0, 1.5f, 1});
  expect_near(absorption(share, {.share = 1}), {0, 0, 4});
  const std::string ramp = R"("sigma_a": {"ramp": [[0, [0, 0, 0]], [2, [4, 4, 4]]], "along": )";
  expect_near(absorption(material_of(ramp + R"("root_cm"})"), {.root_cm = 0.5f, .tip_cm = 1.5f}), glm::vec3(1));
  expect_near(absorption(material_of(ramp + R"("tip_cm"})"), {.root_cm = 0.5f, .tip_cm = 1.5f}), glm::vec3(3));
  expect_near(absorption(material_of(ramp + R"("root_cm", "interpolation": "smooth"})"), {.root_cm = 0.5f}),
              glm::vec3(4 * (3 * 0.0625f - 2 * 0.015625f)));
}

TEST(Sources, StandForEveryColorThatAMaterialCanSay) {
  const StrandPlace middle{.share = 0.5f};
  const auto same = [&](const std::string& varied, const std::string& plain) {
    SCOPED_TRACE(varied);
    const Material material = material_of(varied);
    EXPECT_TRUE(material.pigment);
    expect_near(absorption(material, middle), absorption(material_of(plain), middle));
  };
  same(R"("color": {"ramp": [[0, [0.2, 0.1, 0.3]], [1, [0.6, 0.3, 0.1]]]})", R"("color": [0.4, 0.2, 0.2])");
  same(R"("color": {"root": [0.2, 0.1, 0.3], "tip": [0.6, 0.3, 0.1]})", R"("color": [0.4, 0.2, 0.2])");
  same(R"("hair": {"root": "black", "tip": {"root": "white", "tip": "black"}, "interpolation": "smooth"})",
       R"("hair": {"ramp": [[0, "black"], [1, {"ramp": [[0, "white"], [1, "black"]]}]]})");
  same(R"("hair": {"ramp": [[0, "white"], [0.5, "blond"], [1, "black"]]})", R"("hair": "blond")");
  same(R"("melanin": {"eumelanin": {"ramp": [[0, 3], [1, 1]]}, "pheomelanin": 0.5})",
       R"("melanin": {"eumelanin": 2, "pheomelanin": 0.5})");
  same(R"("principled": {"melanin": {"ramp": [[0, 0.8], [1, 0.2]]}, "redness": 0.3, "tint": [0.9, 0.5, 0.2]})",
       R"("principled": {"melanin": 0.5, "redness": 0.3, "tint": [0.9, 0.5, 0.2]})");
  same(R"("principled": {"color": {"ramp": [[0, [0, 0, 0]], [1, [1, 0.5, 0.5]]]}})",
       R"("principled": {"color": [0.5, 0.25, 0.25]})");
  same(R"("principled": {"sigma_a": {"ramp": [[0, [0, 0, 0]], [1, [1, 2, 3]]]}})",
       R"("principled": {"sigma_a": [0.5, 1, 1.5]})");
}

TEST(Sources, AreNumbersWhereTheyDoNotVary) {
  for (const char* constant :
       {R"({"ramp": [[0, [0.4, 0.2, 0.1]], [1, [0.4, 0.2, 0.1]]]})", R"({"ramp": [[0.5, [0.4, 0.2, 0.1]]]})",
        R"({"random": [[0.4, 0.2, 0.1], {"ramp": [[0, [0.4, 0.2, 0.1]]]}]})",
        R"({"mix": [[0.4, 0.2, 0.1], [0.4, 0.2, 0.1]], "share": 0.3})"}) {
    const Material varied = material_of(R"("color": )" + std::string(constant)),
                   plain = material_of(R"("color": [0.4, 0.2, 0.1])");
    EXPECT_FALSE(varied.pigment) << constant;
    EXPECT_EQ(varied.color, plain.color) << constant;
    EXPECT_EQ(varied.fiber, plain.fiber) << constant;
  }
  EXPECT_EQ(material_of(R"("melanin": {"eumelanin": {"ramp": [[0, 1.5]]}, "pheomelanin": 0.25})").fiber,
            material_of(R"("melanin": {"eumelanin": 1.5, "pheomelanin": 0.25})").fiber);
}

TEST(Sources, OfNumbersAreNumbersWhereTheyDoNotVary) {
  const auto same = [](const std::string& constant, const std::string& plain) {
    const Material material = material_of(constant);
    EXPECT_EQ(material.fiber, material_of(plain).fiber) << constant;
    for (const auto& number : material.numbers) EXPECT_FALSE(number) << constant;
  };
  same(R"("tilt_deg": {"ramp": [[0.5, 2.3]]})", R"("tilt_deg": 2.3)");
  same(R"("eccentricity": {"mix": [0.77, 0.77], "share": 0.3})", R"("eccentricity": 0.77)");
  same(R"("medulla": {"radius": {"random": [0.3, 0.3]}, "asymmetry": {"ramp": [[0, -0.4], [1, -0.4]]}})",
       R"("medulla": {"radius": 0.3, "asymmetry": -0.4})");
  EXPECT_NE(
      refusal(R"("tilt_deg": {"ramp": [[0, 2], [1, 16]]})").find("/materials/0/tilt_deg/ramp/1/1: expected 0..15"),
      std::string::npos);
  EXPECT_NE(refusal(R"("medulla": {"radius": {"ramp": [[0.5, 0.2], [0.4, 0.3]]}})")
                .find("/materials/0/medulla/radius/ramp/1/0: expected a place beyond that of the stop before"),
            std::string::npos);
}

TEST(Sources, RandomOnesStayWithTheStrand) {
  const Material uniform = material_of(R"("sigma_a": {"random": [[0, 0, 0], [1, 1, 1]]})"),
                 seeded = material_of(R"("sigma_a": {"random": [[0, 0, 0], [1, 1, 1]], "seed": 5})"),
                 grey = material_of(R"("sigma_a": {"random": [[2, 2, 2], [0, 0, 0]], "share": 0.25})");
  constexpr int n = 10000;
  double sum = 0, squares = 0, greys = 0, product = 0;
  for (std::uint64_t strand = 0; strand < n; ++strand) {
    const double x = absorption(uniform, {.strand = strand}).x;
    EXPECT_EQ(static_cast<float>(x), absorption(uniform, {.share = 0.7f, .strand = strand}).x);
    sum += x;
    squares += x * x;
    product += (x - 0.5) * (double{absorption(seeded, {.strand = strand}).x} - 0.5);
    const float sigma_a = absorption(grey, {.strand = strand}).x;
    EXPECT_TRUE(sigma_a == 0 || sigma_a == 2);
    greys += sigma_a == 0;
  }
  // 4 standard errors of the mean, the mean square, the correlation of independent ones, and the share
  EXPECT_NEAR(sum / n, 0.5, 4 * std::sqrt(1.0 / 12 / n));
  EXPECT_NEAR(squares / n, 1.0 / 3, 4 * std::sqrt(4.0 / 45 / n));
  EXPECT_NEAR(product / n, 0, 4 / 12.0 / std::sqrt(n));
  EXPECT_NEAR(greys / n, 0.25, 4 * std::sqrt(0.25 * 0.75 / n));
}

TEST(Sources, OfMelaninVaryByStrandAsThatOfTheirMiddle) {
  const Material ramp =
                     material_of(R"("principled": {"melanin": {"ramp": [[0, 0.2], [1, 0.6]]}, "random_color": 0.5})"),
                 middle = material_of(R"("principled": {"melanin": 0.4, "random_color": 0.5})");
  EXPECT_NEAR(ramp.variation.color, middle.variation.color, 1e-6f);
  EXPECT_GT(ramp.variation.color, 0.1f);
}

TEST(Sources, MixAndNest) {
  const Material material = material_of(
      R"("sigma_a": {"mix": [[0, 0, 0], {"ramp": [[0, [0, 0, 0]], [1, [4, 4, 4]]]}], "share": {"ramp": [[0, 0], [2, 1]], "along": "tip_cm"}})");
  expect_near(absorption(material, {.share = 0.5f, .tip_cm = 1}), glm::vec3(1));
  expect_near(absorption(material, {.share = 1, .tip_cm = 0}), glm::vec3(0));
  const Material file = material_of(R"("color": {"mix": [{"attribute": "Cd"}, [0.1, 0.1, 0.1]], "share": 0.5})");
  EXPECT_EQ(attributes_of(file), std::vector<std::string>{"Cd"});
  EXPECT_TRUE(file.pigment->source.varies_along(true));
  EXPECT_FALSE(file.pigment->source.varies_along(false));
  expect_near(absorption(file, {.attribute = glm::vec3(0.5f)}), fiber::sigma_a_of_lock(glm::vec3(0.3f), file.fiber));
}

TEST(Sources, AddUp) {
  const Material material =
      material_of(R"("sigma_a": {"sum": [[1, 2, 3], {"ramp": [[0, [0, 0, 0]], [1, [4, 4, 4]]]}, [0.5, 0, 0]]})");
  expect_near(absorption(material, {.share = 0.5f}), glm::vec3(3.5f, 4, 5));
  // Beyond its range a value is held to it.
  const Material wide = material_of(R"("roughness": {"sum": [0.7, {"ramp": [[0, 0.1], [1, 0.9]]}]})");
  EXPECT_NEAR(wide.roughness->at({.share = 1}).x, 1.6f, 1e-6f);
  // Three that are uniform by strand have the mean and the deviation of their sum, sqrt(3/12) of one's range: over
  // 4,096 strands within 5 standard errors.
  const Material normal = material_of(
      R"("sigma_a": {"sum": [{"random": [[0, 0, 0], [1, 1, 1]]}, {"random": [[0, 0, 0], [1, 1, 1]], "seed": 1}, {"random": [[0, 0, 0], [1, 1, 1]], "seed": 2}]})");
  double sum = 0, squares = 0;
  for (std::uint64_t strand = 0; strand < 4096; ++strand) {
    const double x = absorption(normal, {.strand = mix_bits(strand)}).x;
    sum += x;
    squares += x * x;
  }
  const double mean = sum / 4096;
  EXPECT_NEAR(mean, 1.5, 5 * 0.5 / 64);
  EXPECT_NEAR(squares / 4096 - mean * mean, 0.25, 5 * 0.25 * std::sqrt(2.0 / 4096));
}

/// The mean, the deviation and the share beyond one deviation, over 20,000 strands within 5 standard errors; 0.3173 is
/// the normal distribution's. Along a strand it is one number, and as other seeds it is independent of others.
TEST(Sources, NormalOnesHaveTheirMeanAndDeviationByStrand) {
  const Material material = material_of(R"("roughness": {"normal": 0.3, "deviation": 0.05})"),
                 seeded = material_of(R"("roughness": {"normal": 0.3, "deviation": 0.05, "seed": 4})");
  constexpr int n = 20000;
  double sum = 0, squares = 0, product = 0, beyond = 0;
  for (std::uint64_t strand = 0; strand < n; ++strand) {
    const double z = (double{material.roughness->at({.strand = mix_bits(strand)}).x} - 0.3) / 0.05;
    EXPECT_EQ(material.roughness->at({.strand = mix_bits(strand)}).x,
              material.roughness->at({.share = 0.6f, .strand = mix_bits(strand)}).x);
    sum += z;
    squares += z * z;
    beyond += std::abs(z) > 1;
    product += z * (double{seeded.roughness->at({.strand = mix_bits(strand)}).x} - 0.3) / 0.05;
  }
  EXPECT_NEAR(sum / n, 0, 5 / std::sqrt(n));
  EXPECT_NEAR(squares / n, 1, 5 * std::sqrt(2.0 / n));
  EXPECT_NEAR(beyond / n, 0.3173, 5 * std::sqrt(0.3173 * 0.6827 / n));
  EXPECT_NEAR(product / n, 0, 5 / std::sqrt(n));
  EXPECT_EQ(material.fiber.roughness, 0.3f);
  EXPECT_EQ(material_of(R"("tilt_deg": {"normal": 2, "deviation": 0})").fiber, material_of(R"("tilt_deg": 2)").fiber);
  const Material tilted = material_of(R"("tilt_deg": {"normal": {"root": 2, "tip": 4}, "deviation": 1})");
  const Source& tilt = *tilted.numbers[static_cast<std::size_t>(FiberNumber::tilt)];
  EXPECT_NEAR(tilt.at({.share = 1, .strand = 9}).x - tilt.at({.share = 0, .strand = 9}).x, 2 * std::numbers::pi / 180,
              1e-6);
}

/// Values beyond the range are held to it: strands at both ends and none beyond, no absorption below 0.
TEST(Sources, NormalOnesAreHeldToTheRangeOfTheirValue) {
  Scene scene;
  Groom groom;
  groom.basis = StrandBasis::linear;
  groom.first_point = {0};
  for (std::uint32_t s = 0; s < 300; ++s) {
    groom.points.insert(groom.points.end(), {{s, 0, 0}, {s, 0, 1}});
    groom.first_point.push_back(2 * s + 2);
  }
  scene.grooms = {groom};
  for (const char* wide :
       {R"("roughness": {"normal": 0.2, "deviation": 2})", R"("tilt_deg": {"normal": 5, "deviation": 9})",
        R"("sigma_a": {"normal": [0.1, 1, 0], "deviation": 3})",
        R"("color": {"normal": [0.1, 0.5, 0.9], "deviation": 0.5})",
        R"("melanin": {"eumelanin": {"normal": 0.1, "deviation": 1}})",
        R"("principled": {"melanin": {"normal": 0.9, "deviation": 1}})",
        R"("gain": {"R": {"normal": 1, "deviation": 60}})"}) {
    scene.materials = {material_of(wide)};
    EXPECT_FALSE(assign_fibers(&scene)) << wide;
    EXPECT_GT(scene.fibers.size(), 2u) << wide;
    for (const fiber::FiberParameters& fiber : scene.fibers) EXPECT_EQ(fiber::out_of_range(fiber), nullptr) << wide;
  }
}

/// Hue, saturation and value by the textbook's formulas (Foley and others, 13.3.4), and back.
struct Hsv {
  double hue, saturation, value;
};
Hsv hsv_of(const glm::dvec3& c) {
  const double most = std::max({c.x, c.y, c.z}), least = std::min({c.x, c.y, c.z}), range = most - least;
  if (range == 0) return {0, 0, most};
  const double hue = most == c.x   ? (c.y - c.z) / range
                     : most == c.y ? 2 + (c.z - c.x) / range
                                   : 4 + (c.x - c.y) / range;
  return {hue / 6 < 0 ? hue / 6 + 1 : hue / 6, range / most, most};
}
glm::dvec3 rgb_of(const Hsv& hsv) {
  const double h = 6 * (hsv.hue - std::floor(hsv.hue)), i = std::floor(h), f = h - i, v = hsv.value;
  const double p = v * (1 - hsv.saturation), q = v * (1 - hsv.saturation * f), t = v * (1 - hsv.saturation * (1 - f));
  const std::array<glm::dvec3, 6> sectors{{{v, t, p}, {q, v, p}, {p, v, t}, {p, q, v}, {t, p, v}, {v, p, q}}};
  return sectors[static_cast<std::size_t>(i) % 6];
}

TEST(Sources, OfColorsAreAdjustedInHueSaturationAndValue) {
  RandomStream random(31);
  for (int i = 0; i < 2000; ++i) {
    const glm::vec3 color(random.next(), random.next(), random.next());
    const float hue = 4 * random.next() - 2, saturation = 2 * random.next(), value = 2 * random.next();
    Hsv hsv = hsv_of(color);
    hsv = {hsv.hue + hue, std::min(hsv.saturation * saturation, 1.0), hsv.value * value};
    EXPECT_LT(glm::distance(glm::dvec3(hsv_adjusted(color, hue, saturation, value)), rgb_of(hsv)), 5e-6) << i;
  }
  EXPECT_EQ(hsv_adjusted({-1, 0, -2}, 0.3f, 0, 2), glm::vec3(0.0f));
  EXPECT_EQ(hsv_adjusted(glm::vec3(0.25f), 0.3f, 5, 2), glm::vec3(0.5f)) << "grey has no hue";
  expect_near(hsv_adjusted({1, 0, 0}, 1 / 3.0f, 1, 1), {0, 1, 0});
  const Material varied = material_of(
      R"("color": {"hsvadjust": [0.6, 0.3, 0.1], "hue": {"random": [-0.1, 0.1]}, "saturation": {"root": 1, "tip": 0.5}, "value": {"random": [0.5, 1.5], "seed": 2}})");
  ASSERT_TRUE(varied.pigment);
  const Source& source = varied.pigment->source;
  const auto of_seed = [](std::uint64_t seed) { return RandomStream(seed, 77).next(); };
  expect_near(source.at({.share = 0.5f, .strand = 77}),
              hsv_adjusted({0.6f, 0.3f, 0.1f}, 0.2f * of_seed(0) - 0.1f, 0.75f, 0.5f + of_seed(2)));
  EXPECT_TRUE(source.varies_along(false));
  const Material plain = material_of(R"("color": {"hsvadjust": [0.6, 0.3, 0.1], "hue": 0.5})");
  EXPECT_FALSE(plain.pigment);
  expect_near(*plain.color, {0.1f, 0.4f, 0.6f});
  EXPECT_TRUE(material_of(R"("tint": {"TRT": {"hsvadjust": [1, 0.5, 0.5], "hue": {"random": [0, 1]}}})").tint[2]);
}

/// A dye's absorption adds to that of melanin, wherever a material has melanin.
TEST(Sources, OfADyeAddToMelanin) {
  const StrandPlace middle{.share = 0.5f, .strand = 3};
  const auto found = [&](const std::string& keys) { return absorption(material_of(keys), middle); };
  const fiber::FiberParameters usual = material_of(R"("hair": "brown")").fiber;
  const glm::vec3 pink = fiber::sigma_a_of_lock({1, 0.5f, 0.5f}, usual);
  EXPECT_GT(pink.y, 10 * pink.x);
  expect_near(found(R"("melanin": {"eumelanin": 1.1}, "dye": [1, 0.5, 0.5])"),
              fiber::sigma_a_from_melanin(1.1f, 0) + pink);
  expect_near(found(R"("hair": "brown", "dye": {"root": [1, 0, 0], "tip": [1, 1, 1]})"), usual.sigma_a + pink);
  expect_near(found(R"("melanin": {"eumelanin": {"root": 1, "tip": 3}}, "dye": [1, 0.5, 0.5])"),
              fiber::sigma_a_from_melanin(2, 0) + pink);
  EXPECT_FALSE(material_of(R"("melanin": {"eumelanin": 1.1}, "dye": [1, 0.5, 0.5])").pigment);
  EXPECT_LT(glm::length(found(R"("hair": "brown", "dye": [1, 1, 1])") - usual.sigma_a), 1e-3f) << "white dyes nothing";
  const glm::vec3 node = fiber::sigma_a_of_principled_color({1, 0.5f, 0.5f}, 0.3f);
  expect_near(found(R"("principled": {"melanin": 0.4, "tint": {"root": [1, 0, 0], "tip": [1, 1, 1]}})"),
              fiber::sigma_a_of_principled_melanin(0.4f, 1) + node);
  const std::string hair_color = R"("melanin": 0.4, "randomMelanin": 0, "strayDensity": 0, "dye": [1, 0.5, 0.5])";
  const Material random = material_of(R"("marschner": {"hair_color": {)" + hair_color +
                                      R"(, "randomDyeHue": 0.5, "randomDyeSaturation": 1}})");
  EXPECT_TRUE(random.left_out.empty());
  const float u_hue = RandomStream(3, 3).next(), u_saturation = RandomStream(4, 3).next();
  expect_near(absorption(random, middle),
              fiber::sigma_a_of_principled_melanin(0.4f, 0) +
                  fiber::sigma_a_of_principled_color(
                      hsv_adjusted({1, 0.5f, 0.5f}, 0.5f * u_hue - 0.25f, 2 * u_saturation, 1), 0.3f));
}

TEST(Sources, OfPresenceAreValuesOfTheirStrands) {
  Scene scene;
  scene.materials = {material_of(R"("presence": {"ramp": [[0.5, 1], [1, 0]]})")};
  Groom groom;
  groom.basis = StrandBasis::linear;
  groom.first_point = {0, 2, 5};
  groom.points = {{0, 0, 0}, {0, 0, 4}, {1, 0, 0}, {1, 0, 1}, {1, 0, 4}};
  scene.grooms = {groom};
  const auto presence = [&](std::uint32_t strand, float place) {
    EXPECT_FALSE(assign_fibers(&scene));
    return scene.grooms[0].presence_at(strand, place);
  };
  EXPECT_NEAR(presence(0, 0.25f), 1, 1e-6f);
  EXPECT_NEAR(presence(0, 0.75f), 0.5f, 1e-6f);
  EXPECT_NEAR(presence(0, 1), 0, 1e-6f);
  EXPECT_NEAR(presence(1, 0), 1, 1e-6f);
  EXPECT_NEAR(presence(1, 1.5f), 0.75f, 1e-6f) << "2.5 cm of 4 from the root";
  EXPECT_EQ(scene.fibers.size(), 1u) << "no fiber comes of it";
  scene.materials = {material_of(R"("presence": 0.25)")};
  EXPECT_EQ(presence(1, 1.5f), 0.25f);
  for (const char* whole : {R"("presence": 1)", R"("presence": {"random": [1, 1]})", R"("hair": "brown")"}) {
    scene.materials = {material_of(whole)};
    EXPECT_FALSE(assign_fibers(&scene));
    EXPECT_TRUE(scene.grooms[0].presence.empty()) << whole;
  }
}

TEST(Sources, WrongOnesAreRefusedByKeyAndPlace) {
  const std::vector<std::pair<const char*, const char*>> wrong{
      {R"("color": {"ramp": [[0.5, [1, 0.5, 0.5]]]})",
       "s.json: /materials/0/color/ramp/0/1/0: expected 0.001..0.999, found 1"},
      {R"("color": {"ramp": []})",
       "/materials/0/color/ramp: expected one stop or more, [place, value] each, found none"},
      {R"("color": {"ramp": [[0, [0.5, 0.5, 0.5]], [0, [0.1, 0.1, 0.1]]]})",
       "/materials/0/color/ramp/1/0: expected a place beyond that of the stop before, 0, found 0"},
      {R"("color": {"ramp": [[0, [0.5, 0.5, 0.5]], [3, [0.1, 0.1, 0.1]]]})",
       "/materials/0/color/ramp/1/0: expected a share of the length"},
      {R"("color": {"ramp": [[-1, [0.5, 0.5, 0.5]]]})", "/materials/0/color/ramp/0/0: expected 0..1000000, found -1"},
      {R"("color": {"ramp": [[0]]})", "/materials/0/color/ramp/0: expected a stop, [place, value]"},
      {R"("color": {"ramp": 3})", "/materials/0/color/ramp: expected an array of at most 256, found 3"},
      {R"("color": {"ramp": [[0, "red"]]})",
       "/materials/0/color/ramp/0/1: expected an array of 3 numbers, found \"red\""},
      {R"("color": {})",
       "/materials/0/color: expected one of ramp, root, random, normal, mix, sum, attribute, texture, hsvadjust, found "
       "none of them"},
      {R"("color": {"ramp": [[0, [0.5, 0.5, 0.5]]], "random": []})", "/materials/0/color: expected at most one of"},
      {R"("color": {"root": [0.1, 0.1, 0.1]})", "/materials/0/color/tip: expected this key, found none"},
      {R"("color": {"tip": [0.1, 0.1, 0.1], "ramp": []})",
       "/materials/0/color/tip: expected this key beside \"root\" only"},
      {R"("color": {"rampe": []})", "/materials/0/color/rampe: expected a known key (the nearest is \"ramp\")"},
      {R"("color": {"random": [[0.1, 0.1, 0.1]]})", "/materials/0/color/random: expected two values, [A, B]"},
      {R"("color": {"random": [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2]], "share": 2})",
       "/materials/0/color/share: expected 0..1, found 2"},
      {R"("color": {"random": [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2]], "along": "share"})",
       "/materials/0/color/along: expected this key beside \"ramp\" only"},
      {R"("color": {"mix": [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2]]})",
       "/materials/0/color/share: expected this key, found none"},
      {R"("color": {"mix": [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2]], "share": {"ramp": [[0, 7]]}})",
       "/materials/0/color/share/ramp/0/1: expected 0..1, found 7"},
      {R"("color": {"sum": [[0.1, 0.1, 0.1]]})", "/materials/0/color/sum: expected 2 to 16 values, [A, B, ...]"},
      {R"("color": {"sum": [[0.1, 0.1, 0.1], {"ramp": []}]})",
       "/materials/0/color/sum/1/ramp: expected one stop or more"},
      {R"("roughness": {"normal": 0.2})", "/materials/0/roughness/deviation: expected this key, found none"},
      {R"("roughness": {"normal": 3, "deviation": 1})", "/materials/0/roughness/normal: expected 0.01..1, found 3"},
      {R"("roughness": {"normal": 0.2, "deviation": -1})",
       "s.json: /materials/0/roughness/deviation: expected 0..10000, found -1"},
      {R"("roughness": {"random": [0.2, 0.3], "deviation": 1})",
       "/materials/0/roughness/deviation: expected this key beside \"normal\" only"},
      {R"("hair": {"normal": "brown", "deviation": 1})", "/materials/0/hair/normal: expected it at a key of numbers"},
      {R"("color": {"hsvadjust": [0.5, 0.2, 3]})", "/materials/0/color/hsvadjust/2: expected 0.001..0.999, found 3"},
      {R"("color": {"hsvadjust": [0.5, 0.2, 0.1], "hue": 101})",
       "s.json: /materials/0/color/hue: expected -100..100 turns, found 101"},
      {R"("color": {"hsvadjust": [0.5, 0.2, 0.1], "saturation": {"random": [0.5, -1]}})",
       "/materials/0/color/saturation/random/1: expected 0..100, found -1"},
      {R"("color": {"mix": [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2]], "share": 0, "hue": 1})",
       "/materials/0/color/hue: expected this key beside \"hsvadjust\" only"},
      {R"("roughness": {"hsvadjust": 0.2})",
       "/materials/0/roughness/hsvadjust: expected it at a key whose value is a color"},
      {R"("sigma_a": {"hsvadjust": [1, 2, 3]})",
       "/materials/0/sigma_a/hsvadjust: expected it at a key whose value is a color"},
      {R"("dye": [1, 0.5, 0.5], "color": [0.2, 0.2, 0.2])",
       "/materials/0/dye: expected this key beside \"melanin\" or \"hair\" only"},
      {R"("hair": "brown", "dye": [1, 2, 0.5])", "/materials/0/dye/1: expected 0..1, found 2"},
      {R"("color": {"attribute": ""})", "/materials/0/color/attribute: expected a text of 1..4096 characters"},
      {R"("color": {"mix": [{"attribute": "a"}, {"attribute": "b"}], "share": 0.5})",
       "/materials/0: expected one attribute of the file in a material, found a, b"},
      {R"("hair": {"ramp": [[0, "blonde"]]})", "/materials/0/hair/ramp/0/1: expected one of black, dark brown"},
      {R"("presence": 1.5)", "/materials/0/presence: expected 0..1, found 1.5"},
      {R"("eta": {"ramp": [[0, 1.5]]})", "/materials/0/eta: expected 1.05..3, found an object"}};
  for (const auto& [material, message] : wrong)
    EXPECT_NE(refusal(material).find(message), std::string::npos) << material << "\n" << refusal(material);
  std::string deep = "[0.1, 0.1, 0.1]";
  for (int level = 0; level < 40; ++level) deep = R"({"ramp": [[0, )" + deep + "]]}";
  EXPECT_NE(refusal(R"("color": )" + deep).find("expected sources of at most 16 levels"), std::string::npos);
}

}  // namespace
}  // namespace tress::scene
