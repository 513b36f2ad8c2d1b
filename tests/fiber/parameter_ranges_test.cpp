#include "tress/fiber/parameter_ranges.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace tress {
namespace {

using fiber::FiberParameters;

constexpr float degree = std::numbers::pi_v<float> / 180;
constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();

TEST(ParameterRanges, TakeTheirEnds) {
  EXPECT_EQ(fiber::out_of_range(FiberParameters{}), nullptr);
  for (const bool low : {false, true}) {
    FiberParameters fiber;
    fiber.eta = low ? 1.05f : 3.0f;
    fiber.eccentricity = low ? 0.5f : 1.0f;
    fiber.roughness = low ? 0.001f : 1.0f;
    fiber.tilt = low ? 0 : 15 * degree;
    fiber.sigma_a = glm::vec3(low ? 0.0f : 1e4f);
    fiber.azimuthal_sigma.fill((low ? 0.5f : 45.0f) * degree);
    fiber.longitudinal_lambda.fill((low ? 0.25f : 45.0f) * degree);
    fiber.medulla_radius = low ? 0.0f : 0.95f;
    fiber.medulla_scattering = fiber.medulla_absorption = low ? 0.0f : 100.0f;
    fiber.medulla_asymmetry = fiber.cortex_asymmetry = low ? -0.95f : 0.95f;
    fiber.cortex_scattering = low ? 0.0f : 20.0f;
    fiber.wetness = low ? 0.0f : 1.0f;
    fiber.gain.fill(glm::vec3(low ? 0.0f : 100.0f));
    fiber.energy_path_share = low ? 0.01f : 1.0f;
    EXPECT_EQ(fiber::out_of_range(fiber), nullptr);
  }
}

TEST(ParameterRanges, NameWhatIsOutOfThem) {
  const std::vector<std::pair<const char*, std::function<void(FiberParameters&, float)>>> members{
      {"eta", [](auto& f, float x) { f.eta = x; }},
      {"eccentricity", [](auto& f, float x) { f.eccentricity = x; }},
      {"roughness", [](auto& f, float x) { f.roughness = x; }},
      {"tilt", [](auto& f, float x) { f.tilt = x; }},
      {"sigma_a", [](auto& f, float x) { f.sigma_a.y = x; }},
      {"azimuthal_sigma", [](auto& f, float x) { f.azimuthal_sigma[1] = x; }},
      {"longitudinal_lambda", [](auto& f, float x) { f.longitudinal_lambda[3] = x; }},
      {"medulla_radius", [](auto& f, float x) { f.medulla_radius = x; }},
      {"medulla_scattering", [](auto& f, float x) { f.medulla_scattering = x; }},
      {"medulla_asymmetry", [](auto& f, float x) { f.medulla_asymmetry = 1000 * x; }},
      {"medulla_absorption", [](auto& f, float x) { f.medulla_absorption = x; }},
      {"cortex_scattering", [](auto& f, float x) { f.cortex_scattering = x; }},
      {"cortex_asymmetry", [](auto& f, float x) { f.cortex_asymmetry = 1000 * x; }},
      {"wetness", [](auto& f, float x) { f.wetness = x; }},
      {"gain", [](auto& f, float x) { f.gain[5].z = x; }},
      {"energy_path_share", [](auto& f, float x) { f.energy_path_share = x; }}};
  for (const auto& [name, set] : members) {
    for (const float x : {nan, infinity, -infinity, -1e-3f}) {
      FiberParameters fiber;
      set(fiber, x);
      EXPECT_STREQ(fiber::out_of_range(fiber), name) << x;
    }
  }
  FiberParameters bright;
  bright.gain[2].x = 1e15f;
  EXPECT_EQ(fiber::out_of_range(bright), nullptr);
  bright.gain[2].x = 1.01e15f;
  EXPECT_EQ(fiber::range_error(bright)->message(), "gain: expected a number from 0 to 1e+15, found 1.01e+15");
  FiberParameters smooth;
  smooth.roughness = 0.0009f;
  EXPECT_EQ(fiber::range_error(smooth)->message(), "roughness: expected a number from 0.01 to 1, found 0.0009");
  smooth.azimuthal_sigma.fill(0.1f);
  smooth.longitudinal_lambda.fill(0.1f);
  EXPECT_EQ(fiber::range_error(smooth)->message(), "roughness: expected a number from 0.001 to 1, found 0.0009");
  FiberParameters fiber;
  fiber.eccentricity = 1.000001f;  // the axes would swap
  EXPECT_STREQ(fiber::out_of_range(fiber), "eccentricity");
}

}  // namespace
}  // namespace tress
