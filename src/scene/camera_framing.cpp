#include "scene/camera_framing.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

namespace tress::scene {
namespace {

constexpr float elevation_rad = 0.14f;  ///< 8 degrees above
constexpr float margin = 1.06f;

}  // namespace

Camera frame_grooms(const std::vector<Groom>& grooms, const Image& image, const Camera& camera) {
  glm::vec3 low(1e30f), high(-1e30f);
  bool any = false;
  for (const auto& groom : grooms)
    for (const auto& p : groom.points) {
      low = glm::min(low, p);
      high = glm::max(high, p);
      any = true;
    }
  if (!any) return camera;
  const glm::vec3 centre = 0.5f * (low + high);
  const glm::vec3 back(0, -std::cos(elevation_rad), std::sin(elevation_rad));
  const glm::vec3 right(1, 0, 0);
  const glm::vec3 up = glm::cross(back, right);
  const float half = camera.vertical_fov_deg / 2 * std::numbers::pi_v<float> / 180;
  const float tan_up = std::tan(half) / margin;
  const float tan_right = tan_up * static_cast<float>(image.width) / static_cast<float>(image.height);
  float distance = 0.1f;
  for (const auto& groom : grooms)
    for (const auto& p : groom.points) {
      const glm::vec3 d = p - centre;
      const float aside = std::max(std::abs(glm::dot(d, right)) / tan_right, std::abs(glm::dot(d, up)) / tan_up);
      distance = std::max(distance, glm::dot(d, back) + aside);
    }
  Camera framed = camera;
  framed.look_at = centre;
  framed.eye = centre + distance * back;
  framed.up = glm::vec3(0, 0, 1);
  return framed;
}

}  // namespace tress::scene
