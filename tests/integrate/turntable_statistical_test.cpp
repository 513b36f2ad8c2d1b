// A turntable of objects is one of the camera whose light goes around with it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>

#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"
#include "scene/model/camera.h"
#include "support/scale.h"
#include "support/seed.h"

namespace tress::integrate {
namespace {

/// Brighter towards one side, and blue above.
scene::Environment uneven(double rotate_rad) {
  constexpr int width = 32, height = 16;
  std::vector<glm::vec3> pixels;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      pixels.emplace_back(x < width / 4 ? 6.0f : 0.2f, 0.5f, y < height / 2 ? 2.0f : 0.1f);
  return scene::Environment(width, height, pixels, rotate_rad, 1);
}

/// Means over the left and the right half of both, 3 channels, seeds 5 and 6 of independent pictures of 400
/// samples: 6 differences against their errors (an upper bound of them), of which one is beyond 5 once in 290,000 runs.
/// The picture under the light that stood still is off by more than 20.
TEST(Turntable, ObjectsThatTurnAreACameraThatTurnsWithItsLight) {
  const double turn = 1.1;
  const glm::vec3 pivot(0.2f, -0.1f, 0);
  scene::Scene still = tangle(120, 16, 16);
  still.environment = uneven(0);
  still.camera.look_at = pivot;
  scene::Scene turning = still;
  scene::turn_objects(std::array{scene::ObjectTurn{-turn, pivot}}, &still.grooms, &still.meshes);
  const glm::vec3 back = turning.camera.eye - pivot;
  const float c = static_cast<float>(std::cos(turn)), s = static_cast<float>(std::sin(turn));
  turning.camera.eye = pivot + glm::vec3(c * back.x - s * back.y, s * back.x + c * back.y, back.z);
  const auto render_it = [](const scene::Scene& scene, std::uint64_t seed) {
    WhiteFiber model;
    RenderOptions options;
    options.samples = test::scaled(400);
    options.max_depth = 30;
    options.seed = test::seed(seed);
    return render_with(scene, model, {model.add_fiber({glm::vec3(0.6f)})}, options, 2);
  };
  const RenderResult objects = render_it(still, 5);
  const auto worst = [&](const RenderResult& other) {
    double most = 0;
    for (const char* name : {"R", "G", "B"})
      for (const int from : {0, 8}) {
        double difference = 0, variance = 0;
        for (const RenderResult* result : {&objects, &other}) {
          const std::vector<float>& pixels = result->picture.find(name)->pixels;
          const std::vector<float>& noise = result->picture.find(std::string("variance.") + name)->pixels;
          for (std::size_t i = 0; i < pixels.size(); ++i) {
            if (static_cast<int>(i % 16) / 8 * 8 != from) continue;
            difference += (result == &objects ? 1.0 : -1.0) * static_cast<double>(pixels[i]);
            variance += static_cast<double>(noise[i]);
          }
        }
        most = std::max(most, std::abs(difference) / std::sqrt(variance));
      }
    return most;
  };
  EXPECT_GT(worst(render_it(turning, 6)), 4 * z_limit) << "the light stood still";
  turning.environment = uneven(turn);
  EXPECT_LT(worst(render_it(turning, 6)), z_limit);
}

}  // namespace
}  // namespace tress::integrate
