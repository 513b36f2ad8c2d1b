#include "tress/fiber/rounded_shape.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/pi.h"
#include "tress/fiber/parameter_ranges.h"

namespace tress::inline v0_2::fiber {
namespace {

static_assert(ShapeSteps::roughness == degree);

constexpr double rounding = 1e-5;  ///< of a float, in steps

/// The whole numbers of steps of one number, within its range.
struct Steps {
  double step;
  ParameterRange range;

  float value(double steps) const { return static_cast<float>(std::clamp(steps * step, range.least, range.most)); }
  /// The step below or above: floor(x + u), and x itself if it is whole but for the rounding of floats. Values are
  /// clamped to a step beyond the range, and u to [0, 1]; NaN counts as the least.
  double at(float value, float u) const {
    const double near = std::min(std::fmax(static_cast<double>(value), range.least - step), range.most + step);
    const double x = near / step, whole = std::round(x);
    return std::abs(x - whole) < rounding ? whole : std::floor(x + std::clamp(std::fmax(double{u}, 0.0), 0.0, 1.0));
  }
};

constexpr ParameterRange any_tilt{0, pi / 2};
constexpr Steps eccentricities{ShapeSteps::eccentricity, eccentricity_range};
constexpr Steps roughnesses{ShapeSteps::roughness, roughness_range};
constexpr Steps tilts{ShapeSteps::tilt, any_tilt};
constexpr Steps radii{ShapeSteps::medulla, medulla_radius_range},
    asymmetries{ShapeSteps::medulla, medulla_asymmetry_range}, wetnesses{ShapeSteps::wetness, wetness_range};

}  // namespace

FiberParameters rounded_shape(FiberParameters fiber, const std::array<float, 3>& u) {
  const auto round = [](const Steps& steps, float& value, float by) { value = steps.value(steps.at(value, by)); };
  round(eccentricities, fiber.eccentricity, u[0]);
  round(roughnesses, fiber.roughness, u[1]);
  round(tilts, fiber.tilt, u[2]);
  round(radii, fiber.medulla_radius, u[2]);
  round(asymmetries, fiber.medulla_asymmetry, u[2]);
  round(asymmetries, fiber.cortex_asymmetry, u[2]);
  round(wetnesses, fiber.wetness, u[2]);
  return fiber;
}

std::vector<FiberParameters> rounded_shapes(const FiberParameters& least, const FiberParameters& most) {
  constexpr float below = 0, nearest = 0.5f, above = 0x1.fffffep-1f;
  std::vector<FiberParameters> shapes{least};
  shapes[0].medulla_radius = radii.value(radii.at(least.medulla_radius, nearest));
  shapes[0].medulla_asymmetry = asymmetries.value(asymmetries.at(least.medulla_asymmetry, nearest));
  shapes[0].wetness = wetnesses.value(wetnesses.at(least.wetness, nearest));
  shapes[0].cortex_asymmetry = asymmetries.value(asymmetries.at(least.cortex_asymmetry, nearest));
  const auto multiply = [&](const Steps& steps, float FiberParameters::* member) {
    std::vector<FiberParameters> all;
    for (const FiberParameters& shape : shapes) {
      for (double n = steps.at(least.*member, below); n <= steps.at(most.*member, above); ++n) {
        all.push_back(shape);
        all.back().*member = steps.value(n);
      }
    }
    shapes = std::move(all);
  };
  multiply(eccentricities, &FiberParameters::eccentricity);
  multiply(roughnesses, &FiberParameters::roughness);
  multiply(tilts, &FiberParameters::tilt);
  return shapes;
}

}  // namespace tress::inline v0_2::fiber
