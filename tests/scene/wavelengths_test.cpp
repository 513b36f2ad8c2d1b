// Absorptions by channel and in bands, and their colors beside those of whole spectra.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "base/bands.h"
#include "scene/model/absorption.h"
#include "scene/model/hair_colors.h"
#include "scene/model/strand_fibers.h"
#include "scene/read/material_reader.h"
#include "scene/read/scene_file.h"
#include "tress/fiber/lock_color.h"
#include "tress/fiber/principled_hair.h"

namespace tress::scene {
namespace {

const AbsorptionOf channels(false), bands(true);

glm::vec3 kept(const glm::vec3& sigma_a, float length) {
  return {std::exp(-length * sigma_a.x), std::exp(-length * sigma_a.y), std::exp(-length * sigma_a.z)};
}

/// The color matching functions of CIE 1931 (2 degrees) times the illuminant D65, from 380 nm in steps of 10 nm.
struct Wave {
  double x, y, z, d65;
};
constexpr std::array<Wave, 35> waves{
    {{.0014, .0000, .0065, 49.98},   {.0042, .0001, .0201, 54.65},   {.0143, .0004, .0679, 82.75},
     {.0435, .0012, .2074, 91.49},   {.1344, .0040, .6456, 93.43},   {.2839, .0116, 1.3856, 86.68},
     {.3483, .0230, 1.7471, 104.87}, {.3362, .0380, 1.7721, 117.01}, {.2908, .0600, 1.6692, 117.81},
     {.1954, .0910, 1.2876, 114.86}, {.0956, .1390, .8130, 115.92},  {.0320, .2080, .4652, 108.81},
     {.0049, .3230, .2720, 109.35},  {.0093, .5030, .1582, 107.80},  {.0633, .7100, .0782, 104.79},
     {.1655, .8620, .0422, 107.69},  {.2904, .9540, .0203, 104.41},  {.4334, .9950, .0087, 104.05},
     {.5945, .9950, .0039, 100.0},   {.7621, .9520, .0021, 96.33},   {.9163, .8700, .0017, 95.79},
     {1.0263, .7570, .0011, 88.69},  {1.0622, .6310, .0008, 90.01},  {1.0026, .5030, .0003, 89.60},
     {.8544, .3810, .0002, 87.70},   {.6424, .2650, .0000, 83.29},   {.4479, .1750, .0000, 83.70},
     {.2835, .1070, .0000, 80.03},   {.1649, .0610, .0000, 80.21},   {.0874, .0320, .0000, 82.28},
     {.0468, .0170, .0000, 78.28},   {.0227, .0082, .0000, 69.72},   {.0114, .0041, .0000, 71.61},
     {.0058, .0021, .0000, 74.35},   {.0029, .0010, .0000, 61.60}}};

/// Rec. 709 of white light that has passed a length of pigments, white being 1.
std::array<double, 3> color_of_spectrum(double eumelanin, double pheomelanin, double length) {
  constexpr std::array<std::array<double, 3>, 3> rows{
      {{3.2406, -1.5372, -.4986}, {-.9689, 1.8758, .0415}, {.0557, -.2040, 1.0570}}};
  std::array<double, 3> sum{}, white{};
  for (std::size_t i = 0; i < waves.size(); ++i) {
    const double nm = 380 + 10 * static_cast<double>(i);
    const double sigma_a =
        0.697 * eumelanin * std::pow(nm / 550, -3.33) + 0.4 * pheomelanin * std::pow(nm / 550, -4.75);
    for (std::size_t c = 0; c < 3; ++c) {
      const double weight =
          waves[i].d65 * (rows[c][0] * waves[i].x + rows[c][1] * waves[i].y + rows[c][2] * waves[i].z);
      white[c] += weight;
      sum[c] += weight * std::exp(-sigma_a * length);
    }
  }
  for (std::size_t c = 0; c < 3; ++c) sum[c] /= white[c];
  return sum;
}

// The bound is that of base/bands.h, with 0.0005 for the steps of 10 nm here. By channel the error exceeds 0.015.
TEST(AbsorptionOf, MelaninInBandsHasTheColorOfItsSpectrum) {
  for (const auto& [eumelanin, pheomelanin] :
       {std::array{1.0f, 0.0f}, std::array{0.3f, 0.3f}, std::array{8.0f, 0.0f}, std::array{0.0f, 1.0f}}) {
    double of_channels = 0;
    for (float length = 0.02f; length < 60; length *= 1.3f) {
      const auto color = color_of_spectrum(double{eumelanin}, double{pheomelanin}, double{length});
      const glm::vec3 in_bands = rgb_of_bands(kept(bands.melanin(eumelanin, pheomelanin), length)),
                      by_channel = kept(channels.melanin(eumelanin, pheomelanin), length);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(double{in_bands[c]}, color[static_cast<std::size_t>(c)], 0.003) << eumelanin << " " << length;
        of_channels = std::max(of_channels, std::abs(double{by_channel[c]} - color[static_cast<std::size_t>(c)]));
      }
    }
    EXPECT_GT(of_channels, 0.015);
  }
}

TEST(AbsorptionOf, PrincipledMelaninIsTheSamePigment) {
  for (const AbsorptionOf& of : {channels, bands})
    for (const float melanin : {0.1f, 0.8f}) {
      const float amount = -std::log(1 - melanin);  // times concentrations of 1.2065 and 1.8325 in our units
      for (const float redness : {0.0f, 0.4f, 1.0f}) {
        const glm::vec3 one = of.principled_melanin(melanin, redness),
                        other = of.melanin(1.2065f * amount * (1 - redness), 1.8325f * amount * redness);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(one[c], other[c], 0.001f * other[c]);
      }
    }
  EXPECT_EQ(channels.principled_melanin(0.5f, 0.3f), fiber::sigma_a_of_principled_melanin(0.5f, 0.3f));
}

TEST(AbsorptionOf, AGivenOneKeepsTheColorOfAShortPath) {
  const glm::vec3 dye(0.156f, 0.532f, 1.289f);
  EXPECT_EQ(channels.given(dye), dye);
  const glm::vec3 wanted = kept(dye, 1), found = rgb_of_bands(kept(bands.given(dye), 1));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], wanted[c], 1e-5f);
  EXPECT_EQ(bands.given(glm::vec3(0)), glm::vec3(0)) << "clear hair stays clear";
  const glm::vec3 black = bands.given(glm::vec3(1e20f));
  for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(black[c]) && black[c] > 80);
}

TEST(AbsorptionOf, AColorIsThatOfTheLockInEveryBand) {
  const fiber::FiberParameters fiber;
  const glm::vec3 color(0.8f, 0.2f, 0.5f);
  EXPECT_EQ(channels.of_lock()(color, fiber), fiber::sigma_a_of_lock(color, fiber));
  EXPECT_EQ(bands.of_lock()(color, fiber), fiber::sigma_a_of_lock(bands_of_rgb(color), fiber));
}

TEST(AbsorptionOf, EveryNameIsAHairColor) {
  for (const std::string& name : hair_color_names()) {
    ASSERT_TRUE(channels.hair(name) && bands.hair(name)) << name;
    EXPECT_EQ(*channels.hair(name) == glm::vec3(0), *bands.hair(name) == glm::vec3(0)) << name;
  }
  EXPECT_FALSE(bands.hair("purple"));
}

Material material_of(const std::string& keys, bool spectral) {
  const std::string text = std::string(R"({"integrator": {"spectral": )") + (spectral ? "true" : "false") +
                           R"(}, "materials": [{)" + keys + R"(}], "grooms": [{"generate": "straight"}]})";
  auto scene = parse_scene_file(std::vector<unsigned char>(text.begin(), text.end()), "s.json");
  EXPECT_TRUE(scene) << keys << ": " << scene.error().message();
  return scene ? scene->materials[0] : Material{};
}

TEST(AbsorptionOf, EveryKeyOfAMaterialIsReadInBands) {
  const glm::vec3 given(0.2f, 0.5f, 1.1f), color(0.5f, 0.3f, 0.15f);
  for (const bool spectral : {false, true}) {
    const AbsorptionOf of(spectral);
    const auto sigma_a = [&](const std::string& keys) { return material_of(keys, spectral).fiber.sigma_a; };
    EXPECT_EQ(sigma_a(""), spectral ? bands.melanin(1.3f, 0) : fiber::FiberParameters{}.sigma_a);
    EXPECT_EQ(sigma_a(R"("sigma_a": [0.2, 0.5, 1.1])"), of.given(given));
    EXPECT_EQ(sigma_a(R"("hair": "red")"), *of.hair("red"));
    EXPECT_EQ(sigma_a(R"("melanin": {"eumelanin": 0.3, "pheomelanin": 0.4})"), of.melanin(0.3f, 0.4f));
    EXPECT_EQ(sigma_a(R"("color": [0.5, 0.3, 0.15])"), of.of_lock()(color, fiber::FiberParameters{}));
    EXPECT_EQ(sigma_a(R"("hair": "white", "dye": [0.5, 0.3, 0.15])"), of.of_lock()(color, fiber::FiberParameters{}));
    EXPECT_EQ(sigma_a(R"("principled": {"sigma_a": [0.2, 0.5, 1.1]})"), of.given(given));
    EXPECT_EQ(sigma_a(R"("principled": {"melanin": 0.4, "redness": 0.3})"), of.principled_melanin(0.4f, 0.3f));
    EXPECT_EQ(sigma_a(R"("principled": {"color": [0.5, 0.3, 0.15], "radial_roughness": 0.3})"),
              fiber::sigma_a_of_principled_color(spectral ? bands_of_rgb(color) : color, 0.3f));
    EXPECT_EQ(sigma_a(R"("chiang_hair_bsdf": {"absorption_coefficient": [0.2, 0.5, 1.1]})"), of.given(given));
    EXPECT_EQ(sigma_a(R"("marschner": {"hair_color": {"strayDensity": 0, "randomMelanin": 0, "melanin": 0.4}})"),
              of.principled_melanin(0.4f, 0));
    EXPECT_EQ(sigma_a(R"("marschner": {"hair_color": {"mode": 1, "strayDensity": 0, "color": [0.5, 0.3, 0.15]}})"),
              of.of_lock()(color, material_of(R"("marschner": {"hair_color": {}})", spectral).fiber));
  }
}

TEST(AbsorptionOf, GainsOfFibersAreInBandsToo) {
  for (const bool spectral : {false, true}) {
    Scene scene;
    scene.materials.push_back(usual_material(spectral));
    scene.materials[0].fiber.gain[0] = {1, 0.5f, 0};
    scene.grooms.resize(1);
    scene.grooms[0].points = {{0, 0, 1}, {0, 0, 0}};
    scene.grooms[0].radius_cm = {0.01f, 0.01f};
    scene.grooms[0].first_point = {0, 2};
    ASSERT_FALSE(assign_fibers(&scene));
    const glm::vec3 given(1, 0.5f, 0);
    EXPECT_EQ(scene.fibers.at(0).gain[0], spectral ? bands_of_rgb(given) : given);
  }
}

}  // namespace
}  // namespace tress::scene
