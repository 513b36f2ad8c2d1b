#include "scene/model/camera.h"

#include <fmt/format.h>

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

Camera between(const Camera& a, const Camera& b, float t) {
  const auto mix = [t](const auto& x, const auto& y) { return x + t * (y - x); };
  return {mix(a.eye, b.eye), mix(a.look_at, b.look_at), mix(a.up, b.up), mix(a.vertical_fov_deg, b.vertical_fov_deg)};
}

Camera at_keys(const std::vector<CameraKey>& keys, int frame) {
  const auto next =
      std::find_if(keys.begin(), keys.end(), [frame](const CameraKey& key) { return key.frame >= frame; });
  if (next == keys.end()) return keys.back().camera;
  if (next == keys.begin() || next->frame == frame) return next->camera;
  const auto& before = *(next - 1);
  const double t = (static_cast<double>(frame) - before.frame) / (static_cast<double>(next->frame) - before.frame);
  return between(before.camera, next->camera, static_cast<float>(t));
}

Camera on_turntable(const Turntable& turntable, int frame, const std::vector<Groom>& grooms, const Image& image,
                    const Camera& still) {
  Camera camera = frame_grooms_all_round(grooms, image, still, turntable.look_at);
  const glm::vec3 middle = turntable.look_at.value_or(camera.look_at);
  float distance = std::hypot(camera.eye.x - middle.x, camera.eye.y - middle.y), height = camera.eye.z - middle.z;
  if (turntable.distance_cm) distance = *turntable.distance_cm, height = turntable.height_cm;
  const int step = (frame % turntable.frames + turntable.frames) % turntable.frames;
  const double turn = 2 * std::numbers::pi * step / turntable.frames;
  camera.look_at = middle;
  camera.eye = middle + glm::vec3(distance * static_cast<float>(std::sin(turn)),
                                  -distance * static_cast<float>(std::cos(turn)), height);
  camera.up = glm::vec3(0, 0, 1);
  return camera;
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

std::optional<CameraFault> fault_of(const Camera& camera) {
  const auto forward = camera.look_at - camera.eye;
  if (!(glm::length(forward) > 1e-5f)) return CameraFault{"look_at", "a point other than eye", "the same point"};
  const auto up_length = glm::length(camera.up);
  if (!(up_length > 1e-6f && glm::length(glm::cross(glm::normalize(forward), camera.up / up_length)) > 1e-4f))
    return CameraFault{"up", "a direction across the view", "one along it, or of no length"};
  return std::nullopt;
}

Result<Camera> camera_at(const CameraDescription& description, std::optional<int> frame,
                         const std::vector<Groom>& grooms, const Image& image, const std::string& name) {
  if (description.framed) return frame_grooms(grooms, image, description.camera, description.turn_rad);
  Camera camera = description.camera;
  int at = frame.value_or(0);
  if (description.turntable) {
    camera = on_turntable(*description.turntable, at, grooms, image, description.camera);
  } else if (!description.keys.empty()) {
    at = frame.value_or(description.keys.front().frame);
    camera = at_keys(description.keys, at);
  }
  if (const auto fault = fault_of(camera))
    return Error{name, fmt::format("/camera at frame {}: {}", at, fault->key), fault->expected, fault->found};
  return camera;
}

}  // namespace tress::scene
