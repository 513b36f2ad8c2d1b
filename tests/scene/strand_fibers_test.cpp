#include "scene/model/strand_fibers.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "scene/read/scene_file.h"
#include "tress/base/random.h"
#include "tress/fiber/lock_color.h"
#include "tress/fiber/parameter_ranges.h"
#include "tress/fiber/principled_hair.h"

namespace tress::scene {
namespace {

constexpr double degree = std::numbers::pi / 180;

Groom strands(std::uint32_t count, std::uint32_t material) {
  Groom groom;
  groom.material = material;
  groom.first_point.push_back(0);
  for (std::uint32_t s = 0; s < count; ++s) {
    groom.points.insert(groom.points.end(), {{float(s), 0, 0}, {float(s), 0, -1}});
    groom.radius_cm.insert(groom.radius_cm.end(), {0.004f, 0.004f});
    groom.first_point.push_back(2 * s + 2);
  }
  return groom;
}

Scene varied_scene(const StrandVariation& variation, std::uint32_t count = 20000) {
  Scene scene;
  scene.source = "s.json";
  scene.materials.emplace_back();
  scene.materials[0].variation = variation;
  scene.grooms.push_back(strands(count, 0));
  return scene;
}

/// The fiber of a hit on a strand, of which each strand has one.
const fiber::FiberParameters& fiber_of(const Scene& scene, std::size_t groom, std::uint32_t strand) {
  return scene.fibers.at(scene.grooms.at(groom).fiber_at(strand, RandomStream(strand, 3).next()));
}

/// The mean over strands of what `value` takes from a fiber, in standard errors away from `expected`.
template <class Value>
double z_of_mean(const Scene& scene, double expected, Value&& value) {
  double sum = 0, squares = 0;
  const std::uint32_t n = scene.grooms[0].strand_count();
  for (std::uint32_t s = 0; s < n; ++s) {
    const double x = value(fiber_of(scene, 0, s));
    sum += x;
    squares += x * x;
  }
  const double mean = sum / n;
  return (mean - expected) / std::sqrt((squares / n - mean * mean) / n);
}

// Seeds are fixed, so a passing test goes on passing. Another seed would fail one of the 16 z-tests of this file, each
// at 4 standard errors, once in a thousand times.
constexpr double largest_z = 4;

TEST(StochasticRounding, KeepsTheMean) {
  for (const double x : {0.3, 1.0, 2.5, 17.99}) {
    RandomStream random(7);
    constexpr int n = 40000;
    double whole = 0, power = 0, power_squares = 0;
    for (int i = 0; i < n; ++i) {
      const double u = random.next();
      const auto rounded = round_stochastically(x, u);
      ASSERT_LT(std::abs(double(rounded) - x), 1);
      whole += double(rounded);
      const double rounded_power = std::pow(1.2, double(round_to_power(x, 1.2, u)));
      ASSERT_LT(std::abs(std::log(rounded_power / x)), std::log(1.2) + 1e-12);
      power += rounded_power;
      power_squares += rounded_power * rounded_power;
    }
    const double part = x - std::floor(x);
    EXPECT_LE(std::abs(whole / n - x), largest_z * std::sqrt(part * (1 - part) / n)) << x;
    const double deviation = std::sqrt(std::max(power_squares / n - (power / n) * (power / n), 0.0));
    EXPECT_LE(std::abs(power / n - x), largest_z * deviation / std::sqrt(double(n)) + 1e-12 * x) << x;
    EXPECT_LE(deviation / x, 0.2 / (2 * std::sqrt(1.2)) + 1e-3) << x;
  }
}

TEST(StrandFibers, AreTheMaterialWhereNothingVaries) {
  Scene scene = varied_scene({}, 100);
  scene.materials.emplace_back();
  scene.materials[1].fiber.eccentricity = 0.731f;
  scene.grooms.push_back(strands(10, 1));
  ASSERT_FALSE(assign_fibers(&scene));
  ASSERT_EQ(scene.fibers.size(), 2u);
  for (std::uint32_t s = 0; s < 100; ++s) ASSERT_EQ(fiber_of(scene, 0, s), scene.materials[0].fiber);
  for (std::uint32_t s = 0; s < 10; ++s) ASSERT_EQ(fiber_of(scene, 1, s), scene.materials[1].fiber);
  EXPECT_TRUE(scene.notes.empty());
}

/// All by one factor, in steps of .05: the node's Random Roughness. Its mean is 1: 20,000 strands, uniform within .3,
/// whose deviation is at most .18; 5 standard errors of the mean are .0064 (false alarm 6e-7; the seed is fixed).
TEST(StrandFibers, OfANodeVaryAllWidthsByOneFactor) {
  Scene scene = varied_scene({});
  const fiber::FiberParameters whole = fiber::fiber_of(fiber::PrincipledHair{});
  scene.materials[0].fiber = whole;
  scene.materials[0].has_node_widths = true;
  scene.materials[0].variation.width = 0.3f;
  ASSERT_FALSE(assign_fibers(&scene));
  ASSERT_EQ(scene.fibers.size(), 13u);
  for (const fiber::FiberParameters& fiber : scene.fibers) {
    ASSERT_TRUE(fiber.published_widths);
    EXPECT_EQ(fiber.roughness, whole.roughness);
    const float factor = *fiber.longitudinal_lambda[0] / *whole.longitudinal_lambda[0];
    for (std::size_t p = 0; p < 4; ++p) {
      EXPECT_NEAR(*fiber.longitudinal_lambda[p] / *whole.longitudinal_lambda[p], factor, 1e-5);
      EXPECT_NEAR(fiber.published_widths->longitudinal_lambda[p] / whole.published_widths->longitudinal_lambda[p],
                  factor, 1e-5);
    }
    for (std::size_t p = 0; p < 3; ++p) {
      EXPECT_NEAR(*fiber.azimuthal_sigma[p] / *whole.azimuthal_sigma[p], factor, 1e-5);
      EXPECT_NEAR(fiber.published_widths->azimuthal_sigma[p] / whole.published_widths->azimuthal_sigma[p], factor,
                  1e-5);
    }
  }
  double mean = 0;
  for (std::uint32_t s = 0; s < 20000; ++s)
    mean += double{*fiber_of(scene, 0, s).longitudinal_lambda[0] / *whole.longitudinal_lambda[0]} / 20000;
  EXPECT_NEAR(mean, 1, 0.0064);
}

TEST(StrandFibers, OfANodeStayWithinTheirRangesWhateverItSays) {
  for (const float roughness : {0.0f, 0.9f}) {
    Scene scene = varied_scene({}, 1000);
    scene.materials[0].fiber =
        fiber::fiber_of(fiber::PrincipledHair{.roughness = roughness, .radial_roughness = roughness});
    scene.materials[0].has_node_widths = true;
    scene.materials[0].variation.width = 0.9f;
    ASSERT_FALSE(assign_fibers(&scene)) << roughness;
    for (const fiber::FiberParameters& fiber : scene.fibers)
      EXPECT_EQ(fiber::out_of_range(fiber), nullptr) << roughness;
  }
}

TEST(StrandFibers, KeepTheMeanOfWhatVaries) {
  Scene scene = varied_scene({.eccentricity = 0.1f});
  ASSERT_FALSE(assign_fibers(&scene));
  const auto given = scene.materials[0].fiber;
  EXPECT_LT(std::abs(z_of_mean(scene, given.eccentricity, [](const auto& f) { return f.eccentricity; })), largest_z);

  scene = varied_scene({.width = 0.25f});
  ASSERT_FALSE(assign_fibers(&scene));
  EXPECT_LT(std::abs(z_of_mean(scene, given.roughness, [](const auto& f) { return f.roughness; })), largest_z);
  const auto sigmas = fiber::azimuthal_sigmas(given);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_LT(std::abs(z_of_mean(scene, sigmas[i], [&](const auto& f) { return azimuthal_sigmas(f)[i]; })), largest_z)
        << i;

  scene = varied_scene({.color = 0.6f});
  ASSERT_FALSE(assign_fibers(&scene));
  for (int c = 0; c < 3; ++c)
    EXPECT_LT(std::abs(z_of_mean(scene, given.sigma_a[c], [&](const auto& f) { return f.sigma_a[c]; })), largest_z)
        << c;
}

TEST(StrandFibers, KeepTheMeanOfGivenWidths) {
  Scene scene = varied_scene({.width = 0.3f});
  scene.materials[0].fiber.azimuthal_sigma[1] = static_cast<float>(10.4 * degree);
  scene.materials[0].fiber.longitudinal_lambda[0] = static_cast<float>(5 * degree);
  ASSERT_FALSE(assign_fibers(&scene));
  EXPECT_LT(std::abs(z_of_mean(scene, 10.4 * degree, [](const auto& f) { return double{*f.azimuthal_sigma[1]}; })),
            largest_z);
  EXPECT_LT(std::abs(z_of_mean(scene, 5 * degree, [](const auto& f) { return double{*f.longitudinal_lambda[0]}; })),
            largest_z);
}

TEST(StrandFibers, AreOnTheGridAndInRange) {
  Scene scene = varied_scene({.eccentricity = 0.15f, .width = 0.2f});
  ASSERT_FALSE(assign_fibers(&scene));
  for (const auto& fiber : scene.fibers) {
    const double percent = 100 * double{fiber.eccentricity};
    ASSERT_NEAR(percent, std::round(percent), 1e-4);
    ASSERT_GE(percent, 70 - 1e-4);
    ASSERT_LE(percent, 100 + 1e-4);
    ASSERT_NEAR(fiber.roughness / degree, std::round(fiber.roughness / degree), 1e-4);
  }
}

TEST(StrandFibers, AreDistinctAndFew) {
  Scene scene = varied_scene({.eccentricity = 0.05f});
  ASSERT_FALSE(assign_fibers(&scene));
  EXPECT_EQ(scene.fibers.size(), 11u);  // .80 to .90
  EXPECT_EQ(scene.notes.size(), 1u);

  scene = varied_scene({.width = 0.2f});
  ASSERT_FALSE(assign_fibers(&scene));
  EXPECT_EQ(scene.fibers.size(), 6u);  // 9 to 14 degrees

  scene = varied_scene({.color = 0.5f});
  ASSERT_FALSE(assign_fibers(&scene));
  EXPECT_LE(scene.fibers.size(), 8u);  // 1.2^-4 to 1.2^3
  std::set<std::uint32_t> used;
  for (std::uint32_t s = 0; s < 20000; ++s)
    for (const float u : {0.0f, 0.999f}) used.insert(scene.grooms[0].fiber_at(s, u));
  EXPECT_EQ(used.size(), scene.fibers.size());
}

/// The mean of a number is that of its source: 20,000 strands, uniform between two values.
TEST(StrandFibers, NumbersOfSourcesKeepTheirMean) {
  const auto random = [](float a, float b) {
    return Source{.kind = Source::Kind::random, .parts = {{.value = glm::vec3(a)}, {.value = glm::vec3(b)}}};
  };
  Scene scene = varied_scene({});
  const auto set = [&](FiberNumber number, float a, float b) {
    scene.materials[0].numbers = {};
    scene.materials[0].numbers[static_cast<std::size_t>(number)] = random(a, b);
    ASSERT_FALSE(assign_fibers(&scene));
  };
  set(FiberNumber::eccentricity, 0.7f, 0.803f);
  EXPECT_LT(std::abs(z_of_mean(scene, 0.7515, [](const auto& f) { return double{f.eccentricity}; })), largest_z);
  EXPECT_EQ(scene.fibers.size(), 12u);
  set(FiberNumber::tilt, static_cast<float>(2.1 * degree), static_cast<float>(3.3 * degree));
  EXPECT_LT(std::abs(z_of_mean(scene, 2.7 * degree, [](const auto& f) { return double{f.tilt}; })), largest_z);
  EXPECT_EQ(scene.fibers.size(), 4u);  // 2 to 3.5 degrees
  set(FiberNumber::medulla_radius, 0.31f, 0.47f);
  EXPECT_LT(std::abs(z_of_mean(scene, 0.39, [](const auto& f) { return double{f.medulla_radius}; })), largest_z);
  set(FiberNumber::medulla_scattering, 0, 3);
  EXPECT_LT(std::abs(z_of_mean(scene, 1.5, [](const auto& f) { return double{f.medulla_scattering}; })), largest_z);
  set(FiberNumber::medulla_asymmetry, -0.73f, 0.12f);
  EXPECT_LT(std::abs(z_of_mean(scene, -0.305, [](const auto& f) { return double{f.medulla_asymmetry}; })), largest_z);
  set(FiberNumber::cortex_scattering, 0, 3);
  EXPECT_LT(std::abs(z_of_mean(scene, 1.5, [](const auto& f) { return double{f.cortex_scattering}; })), largest_z);
  set(FiberNumber::wetness, 0.1f, 0.8f);
  EXPECT_LT(std::abs(z_of_mean(scene, 0.45, [](const auto& f) { return double{f.wetness}; })), largest_z);
  EXPECT_EQ(scene.fibers.size(), 5u);  // 0 to 1 by 0.25
  scene.materials[0].numbers = {};
  scene.materials[0].gain[0] = random(0, 1.5f);
  ASSERT_FALSE(assign_fibers(&scene));
  EXPECT_LT(std::abs(z_of_mean(scene, 0.75, [](const auto& f) { return double{f.gain[0].x}; })), largest_z);
}

/// Over 4096 equal parts of the hits of each single strand: a step of at most 20 % begins and ends within a part, and
/// shares are rounded to 1/65536. Gain and absorption are not rounded up together: with one u for both their
/// correlation would be 0.5 on average; that of a pair is at most 1, and of 600 pairs 0.25 is 6 standard errors (false
/// alarm 2e-9; the seed is fixed).
TEST(StrandFibers, HitsOfEveryStrandHaveTheMeanOfItsValues) {
  constexpr std::uint32_t count = 200;
  constexpr int parts = 4096;
  Scene scene = varied_scene({}, count);
  Material& material = scene.materials[0];
  const auto attribute = [](float factor) {
    return Source{.kind = Source::Kind::attribute, .value = glm::vec3(factor)};
  };
  const auto sum = [&](float a, float factor) {
    return Source{.kind = Source::Kind::sum, .parts = {{.value = glm::vec3(a)}, attribute(factor)}};
  };
  material.pigment =
      Pigment{attribute(1), [](const glm::vec3& value, const auto&) { return glm::vec3(value.y, value.z, value.x); }};
  material.roughness = sum(0.11f, 0.03f);
  material.tint[0] = attribute(1);
  material.numbers[static_cast<std::size_t>(FiberNumber::tilt)] = sum(0.02f, 0.02f);
  material.numbers[static_cast<std::size_t>(FiberNumber::medulla_absorption)] = sum(0.2f, 0.1f);
  RandomStream random(5);
  for (std::uint32_t s = 0; s < count; ++s) {
    const float x = random.next(), y = random.next(), z = random.next();
    scene.grooms[0].color.push_back(glm::vec3(0.7f) + 0.3f * glm::vec3(x, y, z));
  }
  ASSERT_FALSE(assign_fibers(&scene));
  double correlation = 0;
  for (std::uint32_t s = 0; s < count; ++s) {
    const glm::vec3 a = scene.grooms[0].color[s];
    glm::dvec3 sigma_a(0.0), gain(0.0), product(0.0), sigma_squares(0.0), gain_squares(0.0);
    double roughness = 0, tilt = 0, medulla = 0;
    for (int i = 0; i < parts; ++i) {
      const fiber::FiberParameters& fiber = scene.fibers[scene.grooms[0].fiber_at(s, (float(i) + 0.5f) / float(parts))];
      const glm::dvec3 absorbed(fiber.sigma_a), reflected(fiber.gain[0]);
      sigma_a += absorbed / double(parts);
      gain += reflected / double(parts);
      product += absorbed * reflected / double(parts);
      sigma_squares += absorbed * absorbed / double(parts);
      gain_squares += reflected * reflected / double(parts);
      roughness += double{fiber.roughness} / parts;
      tilt += double{fiber.tilt} / parts;
      medulla += double{fiber.medulla_absorption} / parts;
    }
    constexpr double of_parts = 0.2 * (1.0 / parts + 1.0 / 65536), step = degree * (1.0 / parts + 1.0 / 65536);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(sigma_a[c] / a[(c + 1) % 3], 1, of_parts + 1e-6) << s;
      EXPECT_NEAR(gain[c] / a[c], 1, of_parts + 1e-6) << s;
      correlation += (product[c] - sigma_a[c] * gain[c]) /
                     std::sqrt((sigma_squares[c] - sigma_a[c] * sigma_a[c]) * (gain_squares[c] - gain[c] * gain[c])) /
                     (3 * count);
    }
    EXPECT_NEAR(roughness, 0.11 + 0.03 * a.x, step + 1e-7) << s;
    EXPECT_NEAR(tilt, 0.02 + 0.02 * a.x, step / 2 + 1e-7) << s;
    EXPECT_NEAR(medulla / (0.2 + 0.1 * a.x), 1, of_parts + 1e-6) << s;
  }
  EXPECT_LT(std::abs(correlation), 0.25);
}

TEST(StrandFibers, OfManyShapesShareThePathsOfTheirEnergies) {
  const auto share = [](const StrandVariation& variation) {
    Scene scene = varied_scene(variation);
    scene.materials.emplace_back();  // of one shape, whatever the other one does
    scene.materials[1].name = "plain";
    scene.grooms.push_back(strands(10, 1));
    EXPECT_FALSE(assign_fibers(&scene));
    EXPECT_EQ(fiber_of(scene, 1, 0).energy_path_share, 1);
    for (const FiberChoice& choice : scene.grooms[0].choices) {
      EXPECT_EQ(scene.fibers[choice.fiber].energy_path_share, fiber_of(scene, 0, 0).energy_path_share);
    }
    return fiber_of(scene, 0, 0).energy_path_share;
  };
  EXPECT_EQ(share({}), 1);
  EXPECT_EQ(share({.color = 0.9f}), 1);                              // colors have one shape
  EXPECT_EQ(share({.eccentricity = 0.03f}), 1);                      // 7
  EXPECT_EQ(share({.eccentricity = 0.05f}), 8 / 11.0f);              // .80 to .90
  EXPECT_EQ(share({.eccentricity = 0.15f, .width = 0.5f}), 0.125f);  // 31 x 13
}

TEST(StrandFibers, DependNeitherOnTheOrderOfGroomsNorOnPlaces) {
  const StrandVariation variation{.eccentricity = 0.05f, .width = 0.1f, .color = 0.3f};
  Scene forwards = varied_scene(variation, 500);
  forwards.materials.push_back(forwards.materials[0]);
  forwards.materials[1].name = "other";
  forwards.grooms.push_back(strands(300, 1));
  Scene backwards = forwards;
  std::swap(backwards.grooms[0], backwards.grooms[1]);
  for (auto& p : backwards.grooms[0].points) p += glm::vec3(1, 2, 3);
  ASSERT_FALSE(assign_fibers(&forwards));
  ASSERT_FALSE(assign_fibers(&backwards));
  EXPECT_EQ(forwards.fibers, backwards.fibers);
  for (const std::size_t g : {0u, 1u}) {
    EXPECT_EQ(forwards.grooms[g].choices, backwards.grooms[1 - g].choices);
  }
  std::uint32_t same = 0;
  for (std::uint32_t s = 0; s < 300; ++s)
    same += fiber_of(forwards, 0, s).eccentricity == fiber_of(forwards, 1, s).eccentricity;
  EXPECT_LT(same, 60u);  // two materials vary apart: of 11 values about a tenth agrees by chance

  Scene seeded = varied_scene(variation, 500);
  seeded.materials[0].variation.seed = 1;
  ASSERT_FALSE(assign_fibers(&seeded));
  std::uint32_t differ = 0;
  for (std::uint32_t s = 0; s < 500; ++s) differ += !(fiber_of(forwards, 0, s) == fiber_of(seeded, 0, s));
  EXPECT_GT(differ, 450u);
}

Pigment color_of_file() { return {{.kind = Source::Kind::attribute, .value = glm::vec3(1)}, fiber::sigma_a_of_lock}; }

TEST(StrandFibers, TakeColorsOfTheFile) {
  Scene scene = varied_scene({}, 20000);
  scene.materials[0].pigment = color_of_file();
  const glm::vec3 color(0.9f, 0.5f, 0.999f);
  scene.grooms[0].color.assign(20000, color);
  ASSERT_FALSE(assign_fibers(&scene));
  EXPECT_LE(scene.fibers.size(), 8u);
  const glm::vec3 sigma_a = fiber::sigma_a_of_lock(color, scene.materials[0].fiber);
  for (int c = 0; c < 3;
       ++c)  // blue is almost clear: some 30 of the strands have the least absorption, the others none
    EXPECT_LT(std::abs(z_of_mean(scene, sigma_a[c], [&](const auto& f) { return f.sigma_a[c]; })), largest_z) << c;
}

/// Strands of 5 points, evenly along z from 0 to -4, of a color that the place and nothing else gives.
Scene colored_along(StrandBasis basis, std::uint32_t count) {
  Scene scene = varied_scene({}, 0);
  scene.materials[0].pigment = color_of_file();
  Groom& groom = scene.grooms[0];
  groom.basis = basis;
  const std::uint32_t points = basis == StrandBasis::bezier ? 13 : basis == StrandBasis::open_bspline ? 7 : 5;
  for (std::uint32_t s = 0; s < count; ++s) {
    for (std::uint32_t i = 0; i < points; ++i) {
      const float place = basis == StrandBasis::bezier         ? float(i) / 3
                          : basis == StrandBasis::open_bspline ? float(i) - 1
                                                               : float(i);
      groom.points.push_back({s, 0, -place});
      groom.radius_cm.push_back(0.004f);
      groom.color.push_back(glm::clamp(glm::vec3(0.1f + 0.2f * place, 0.5f, 0.9f - 0.2f * place), 0.0f, 1.0f));
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  return scene;
}

TEST(StrandFibers, HaveTheColorsOfTheirPointsInTheMeanAtEveryPlace) {
  for (const auto basis : {StrandBasis::linear, StrandBasis::bspline, StrandBasis::open_bspline, StrandBasis::bezier}) {
    Scene scene = colored_along(basis, 4000);
    ASSERT_FALSE(assign_fibers(&scene));
    const Groom& groom = scene.grooms[0];
    EXPECT_EQ(groom.stations_a_segment, 8u);
    EXPECT_EQ(groom.first_station(4000), 4000u * 33);
    EXPECT_EQ(groom.choices_a_station, 4u);  // one for each channel that is rounded up, and another
    EXPECT_EQ(groom.choices.size(), 4000u * 33 * 4);
    for (const float place : {0.0f, 1.0f, 2.125f, 3.5f, 4.0f}) {
      const glm::vec3 expected =
          fiber::sigma_a_of_lock({0.1f + 0.2f * place, 0.5f, 0.9f - 0.2f * place}, scene.materials[0].fiber);
      for (int c = 0; c < 3; ++c) {
        double sum = 0, squares = 0;
        for (std::uint32_t s = 0; s < 4000; ++s) {
          const std::size_t station = groom.station_at(s, place, 0.5f);
          const double x = scene.fibers[groom.fiber_at(station, RandomStream(s, 5).next())].sigma_a[c];
          sum += x;
          squares += x * x;
        }
        const double mean = sum / 4000, error = std::sqrt(std::max(squares / 4000 - mean * mean, 0.0) / 4000);
        EXPECT_NEAR(mean, expected[c], largest_z * error + 1e-6) << place << " " << c;
      }
    }
    // 16 bytes a station and 12 a color: 33 stations a strand.
    const std::size_t bytes = groom.choices.size() * sizeof(FiberChoice) + groom.color.size() * sizeof(glm::vec3);
    const std::string expected =
        fmt::format("at 132000 places along the strands ({:.1f} MB)", double(bytes) / (1 << 20));
    EXPECT_NE(scene.notes.at(0).find(expected), std::string::npos) << scene.notes[0];
  }
}

TEST(StrandFibers, BetweenTwoStationsEachCountsByHowNearItIs) {
  Groom groom = strands(2, 0);
  groom.stations_a_segment = 2;
  EXPECT_EQ(groom.station_at(0, 0.0f, 0.0f), 0u);
  EXPECT_EQ(groom.station_at(0, 0.125f, 0.2f), 1u);
  EXPECT_EQ(groom.station_at(0, 0.125f, 0.3f), 0u);
  EXPECT_EQ(groom.station_at(0, 1.0f, 0.0f), 2u);
  EXPECT_EQ(groom.station_at(1, 0.75f, 0.6f), 4u);
  EXPECT_EQ(groom.station_at(1, 1.25f, 0.0f), 5u);  // past the tip by rounding
}

/// Whatever else the groom has: a strand that is of one color along its length is the strand of that color.
TEST(StrandFibers, OneColorAtAllPointsIsThatOfTheStrand) {
  Scene along = colored_along(StrandBasis::linear, 300), by_strand = along;
  for (std::uint32_t s = 0; s < 300; s += 2)
    std::fill_n(along.grooms[0].color.begin() + 5 * s, 5, glm::vec3(0.3f, 0.2f, 0.1f));
  by_strand.grooms[0].color.assign(300, glm::vec3(0.3f, 0.2f, 0.1f));
  ASSERT_FALSE(assign_fibers(&along));
  ASSERT_FALSE(assign_fibers(&by_strand));
  EXPECT_EQ(by_strand.grooms[0].stations_a_segment, 0u);
  for (std::uint32_t s = 0; s < 300; s += 2)
    for (const float place : {0.0f, 1.3f, 4.0f})
      for (const float u : {0.0f, 0.3f, 0.6f, 0.9f})
        EXPECT_EQ(along.fibers[along.grooms[0].fiber_at(along.grooms[0].station_at(s, place, 0.4f), u)],
                  by_strand.fibers[by_strand.grooms[0].fiber_at(s, u)]);
}

TEST(StrandFibers, VaryByTheIdOfTheStrandWhereTheFileHasOne) {
  Scene all = varied_scene({}, 200);
  all.materials[0].pigment = Pigment{
      {.kind = Source::Kind::random, .parts = {{.value = glm::vec3(0.1f)}, {.value = glm::vec3(8)}}, .chance = 0.5f},
      [](const glm::vec3& value, const fiber::FiberParameters&) { return value; }};
  Scene culled = all;
  culled.grooms[0] = strands(100, 0);
  for (std::int64_t s = 0; s < 200; ++s) all.grooms[0].id.push_back(1000 + s);
  for (std::int64_t s = 0; s < 100; ++s) culled.grooms[0].id.push_back(1001 + 2 * s);
  ASSERT_FALSE(assign_fibers(&all));
  ASSERT_FALSE(assign_fibers(&culled));
  for (std::uint32_t s = 0; s < 100; ++s)
    EXPECT_EQ(fiber_of(culled, 0, s).sigma_a.x > 1, fiber_of(all, 0, 1 + 2 * s).sigma_a.x > 1) << s;
}

TEST(StrandFibers, AreBoundedOrCoarsened) {
  Scene scene = varied_scene({.eccentricity = 0.15f, .width = 0.4f, .color = 0.9f});
  const auto error = assign_fibers(&scene);
  ASSERT_TRUE(error);
  EXPECT_NE(error->message().find("s.json: /materials/0/variation: expected at most 1024 distinct fibers"),
            std::string::npos)
      << error->message();

  scene = varied_scene({}, 5000);
  scene.materials[0].pigment = color_of_file();
  RandomStream random(3);
  for (int s = 0; s < 5000; ++s) {
    const float r = random.next(), g = random.next(), b = random.next();
    scene.grooms[0].color.emplace_back(r, g, b);
  }
  ASSERT_FALSE(assign_fibers(&scene));
  EXPECT_LE(scene.fibers.size(), most_fibers);
  EXPECT_EQ(scene.notes.size(), 2u);
}

TEST(StrandFibers, RefuseVariationsThatLeaveTheRange) {
  const auto message = [](Scene scene) {
    const auto error = assign_fibers(&scene);
    return error ? error->message() : "";
  };
  EXPECT_NE(message(varied_scene({.eccentricity = 0.2f}, 1)).find("/materials/0/variation/eccentricity: expected"),
            std::string::npos);
  Scene narrow = varied_scene({.width = 0.5f}, 1);
  narrow.materials[0].fiber.roughness = 0.05f;
  EXPECT_NE(message(narrow).find("/materials/0/variation/width: expected azimuthal sigmas"), std::string::npos);
  Scene rough = varied_scene({.width = 0.5f}, 1);
  rough.materials[0].fiber.roughness = 0.9f;
  EXPECT_NE(message(rough).find("/materials/0/variation/width: expected roughness"), std::string::npos);
  Scene wide = varied_scene({.width = 0.5f}, 1);
  wide.materials[0].fiber.azimuthal_sigma[2] = static_cast<float>(40 * degree);
  EXPECT_NE(message(wide).find("/materials/0/variation/width: expected azimuthal sigmas"), std::string::npos);
  for (const double lambda_deg : {0.25, 45.0}) {
    Scene varied = varied_scene({.width = 0.2f}, 1);
    varied.materials[0].fiber.longitudinal_lambda[2] = static_cast<float>(lambda_deg * degree);
    EXPECT_NE(message(varied).find("/materials/0/variation/width: expected longitudinal lambdas"), std::string::npos)
        << lambda_deg;
  }
}

}  // namespace
}  // namespace tress::scene
