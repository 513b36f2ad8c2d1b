#include "scene/model/camera_framing.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

namespace tress::scene {
namespace {

constexpr float elevation_rad = 0.14f;  ///< 8 degrees above
constexpr float margin = 1.06f;

/// Towards the camera.
glm::vec3 back_of(double turn_rad) {
  const float level = std::cos(elevation_rad);
  return {static_cast<float>(std::sin(turn_rad)) * level, -static_cast<float>(std::cos(turn_rad)) * level,
          std::sin(elevation_rad)};
}

/// Tangents of the half angles of view, with the margin.
struct View {
  float right, up;
  View(const Image& image, const Camera& camera)
      : up(std::tan(camera.vertical_fov_deg / 2 * std::numbers::pi_v<float> / 180) / margin) {
    right = up * static_cast<float>(image.width) / static_cast<float>(image.height);
  }
};

/// At `distance_of(point - middle)` along `back`, the largest of all points.
template <class Distance>
Camera placed(const std::vector<Groom>& grooms, const Camera& camera, const glm::vec3& middle, const glm::vec3& back,
              Distance distance_of) {
  float distance = 0.1f;
  for (const auto& groom : grooms)
    for (const auto& p : groom.points) distance = std::max(distance, distance_of(p - middle));
  Camera framed = camera;
  framed.look_at = middle;
  framed.eye = middle + distance * back;
  framed.up = glm::vec3(0, 0, 1);
  return framed;
}

}  // namespace

std::optional<glm::vec3> middle_of(const std::vector<Groom>& grooms) {
  glm::vec3 low(1e30f), high(-1e30f);
  bool any = false;
  for (const auto& groom : grooms)
    for (const auto& p : groom.points) {
      low = glm::min(low, p);
      high = glm::max(high, p);
      any = true;
    }
  if (!any) return std::nullopt;
  return 0.5f * (low + high);
}

Camera frame_grooms(const std::vector<Groom>& grooms, const Image& image, const Camera& camera, double turn_rad) {
  const auto middle = middle_of(grooms);
  if (!middle) return camera;
  const View view(image, camera);
  const glm::vec3 back = back_of(turn_rad);
  const glm::vec3 right(static_cast<float>(std::cos(turn_rad)), static_cast<float>(std::sin(turn_rad)), 0);
  const glm::vec3 up = glm::cross(back, right);
  return placed(grooms, camera, *middle, back, [&](const glm::vec3& d) {
    return glm::dot(d, back) + std::max(std::abs(glm::dot(d, right)) / view.right, std::abs(glm::dot(d, up)) / view.up);
  });
}

Camera frame_grooms_all_round(const std::vector<Groom>& grooms, const Image& image, const Camera& camera,
                              const std::optional<glm::vec3>& look_at) {
  const auto middle = middle_of(grooms);
  if (!middle) return camera;
  const View view(image, camera);
  const float c = std::cos(elevation_rad), s = std::sin(elevation_rad);
  // A point at height z goes around on a circle of radius r: the largest of the above over its azimuth t, where
  // back . d = c r cos t + s z, right . d = r sin t, up . d = -s r cos t + c z, is closed.
  return placed(grooms, camera, look_at.value_or(*middle), back_of(0), [&](const glm::vec3& d) {
    const float r = std::hypot(d.x, d.y), z = d.z;
    const float aside = r * std::hypot(c, 1 / view.right) + s * z;
    const float above = r * std::abs(c - s / view.up) + z * (s + c / view.up);
    const float below = r * std::abs(c + s / view.up) + z * (s - c / view.up);
    return std::max({aside, above, below});
  });
}

}  // namespace tress::scene
