#include "scene/generate/sky_environment.h"

#include <cmath>
#include <numbers>
#include <vector>

namespace tress::scene {

Environment gradient_environment(const GradientSky& sky, float scale) {
  constexpr int rows = 1024;  // even: the horizon is an edge
  std::vector<glm::vec3> pixels;
  pixels.reserve(rows);
  for (int row = 0; row < rows / 2; ++row) {
    // z is uniform in solid angle; the mean of sqrt z over [low, high].
    const double high = std::cos(std::numbers::pi * row / rows);
    const double low = row + 1 < rows / 2 ? std::cos(std::numbers::pi * (row + 1) / rows) : 0;
    const auto t = static_cast<float>(2.0 / 3 * (high * std::sqrt(high) - low * std::sqrt(low)) / (high - low));
    pixels.push_back(sky.horizon + t * (sky.zenith - sky.horizon));
  }
  pixels.resize(rows, sky.ground);
  return Environment(1, rows, std::move(pixels), 0, scale);
}

}  // namespace tress::scene
