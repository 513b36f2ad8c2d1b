#include "scene/generate/generated_environments.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>
#include <vector>

namespace tress::scene {
namespace {

constexpr int width = 256, height = 128;

struct Softbox {
  glm::vec3 towards;
  float half_width, half_height;  ///< tangents of the half angles
  glm::vec3 radiance;
};

/// Returns 1 inside and 0 outside, with a soft edge.
float coverage(const Softbox& box, const glm::vec3& direction) {
  const glm::vec3 axis = glm::normalize(box.towards);
  const float depth = glm::dot(direction, axis);
  if (depth <= 0.05f) return 0;
  const glm::vec3 right = glm::normalize(glm::cross(axis, glm::vec3(0, 0, 1)));
  const glm::vec3 up = glm::cross(right, axis);
  const auto edge = [](float x, float half) { return std::clamp((half - std::abs(x)) / (0.25f * half), 0.0f, 1.0f); };
  return edge(glm::dot(direction, right) / depth, box.half_width) *
         edge(glm::dot(direction, up) / depth, box.half_height);
}

}  // namespace

Environment studio_environment(double rotate_rad, float scale) {
  const Softbox boxes[] = {
      {{-0.75f, -0.85f, 0.80f}, 0.42f, 0.32f, {13.0f, 12.3f, 11.4f}},  // key
      {{0.45f, 1.00f, 0.95f}, 0.90f, 0.28f, {9.0f, 9.6f, 10.5f}},      // rim
      {{1.00f, -0.35f, 0.25f}, 0.35f, 0.60f, {0.9f, 0.95f, 1.0f}},     // fill
  };
  std::vector<glm::vec3> pixels;
  pixels.reserve(static_cast<std::size_t>(width) * height);
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const double down = std::numbers::pi * (row + 0.5) / height;
      const double azimuth = 2 * std::numbers::pi * ((column + 0.5) / width - 0.5);
      const glm::vec3 direction(-std::sin(down) * std::sin(azimuth), -std::sin(down) * std::cos(azimuth),
                                std::cos(down));
      glm::vec3 radiance(0.17f + 0.07f * direction.z);
      for (const auto& box : boxes) radiance += coverage(box, direction) * box.radiance;
      pixels.push_back(radiance);
    }
  return Environment(width, height, std::move(pixels), rotate_rad, scale);
}

Environment gradient_environment(const GradientSky& sky, float scale) {
  constexpr int steps = 1024;  // of the root of z, in which the sky is linear; the mean errs by 1e-7
  std::vector<double> fall;
  std::vector<glm::vec3> values;
  const auto add = [&](double at, const glm::vec3& radiance) {
    fall.push_back(at);
    values.push_back(scale * radiance);
  };
  for (int i = steps; i >= 0; --i) {
    const double root = static_cast<double>(i) / steps;
    add(1 - root * root, sky.horizon + static_cast<float>(root) * (sky.zenith - sky.horizon));
  }
  add(1, sky.ground);  // the horizon is an edge
  add(2, sky.ground);
  return Environment(RadianceMap(std::move(fall), std::move(values)));
}

}  // namespace tress::scene
