#include "scene/model/camera_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "scene/model/camera_framing.h"

namespace tress::scene {
namespace {

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
