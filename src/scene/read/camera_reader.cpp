#include <fmt/format.h>

#include <numbers>

#include "scene/model/parameters.h"
#include "scene/read/scene_file.h"

namespace tress::scene {
namespace {

constexpr std::size_t most_keys = 100'000;
constexpr double radians = std::numbers::pi / 180;

/// The keys that a still camera and a keyframe share, over the defaults in `camera`.
Camera read_view(const JsonReader& json, Camera camera) {
  camera.eye = json.triple("eye").value_or(camera.eye);
  camera.look_at = json.triple("look_at").value_or(camera.look_at);
  camera.up = json.triple("up").value_or(camera.up);
  if (const auto x = json.number("vertical_fov_deg")) camera.vertical_fov_deg = static_cast<float>(*x);
  return camera;
}

void check_view(const JsonReader& json, const Camera& camera) {
  if (json.failed()) return;
  if (const auto fault = fault_of(camera)) json.fail(fault->key, fault->expected, fault->found);
}

void read_keys(const JsonReader& json, CameraDescription* camera) {
  for (const auto& item : json.items("frames", most_keys)) {
    if (!item.object({"frame", "eye", "look_at", "up", "vertical_fov_deg"}) || !item.need({"frame", "eye"})) return;
    const auto frame = item.integer("frame");
    const CameraKey key{static_cast<int>(frame.value_or(0)), read_view(item, camera->camera)};
    check_view(item, key.camera);
    if (!camera->keys.empty() && key.frame <= camera->keys.back().frame)
      item.fail("frame", fmt::format("more than {}, the frame before", camera->keys.back().frame),
                fmt::format("{}", key.frame));
    if (item.failed()) return;
    camera->keys.push_back(key);
  }
  if (camera->keys.empty()) json.fail("frames", "one frame or more", "none");
}

Turntable read_turntable(const JsonReader& json) {
  Turntable turntable;
  if (!json.object({"frames", "look_at", "distance_cm", "height_cm"}) || !json.need({"frames"})) return turntable;
  turntable.frames = static_cast<int>(json.integer("frames").value_or(1));
  turntable.look_at = json.triple("look_at");
  if (const auto x = json.number("distance_cm")) turntable.distance_cm = static_cast<float>(*x);
  if (const auto x = json.number("height_cm")) turntable.height_cm = static_cast<float>(*x);
  if (json.has("height_cm") && !json.has("distance_cm"))
    json.fail("height_cm", "this key beside \"distance_cm\" only", "it alone");
  if (turntable.distance_cm)
    check_view(json, {glm::vec3(0, -*turntable.distance_cm, turntable.height_cm), glm::vec3(0.0f), {0, 0, 1}, 30});
  return turntable;
}

}  // namespace

CameraDescription read_camera(const JsonReader& json) {
  CameraDescription camera;
  if (!json.object({"frame", "turn_deg", "eye", "look_at", "up", "vertical_fov_deg", "frames", "turntable"}))
    return camera;
  const bool placed = json.has("eye") || json.has("look_at") || json.has("up");
  camera.camera = read_view(json, camera.camera);
  if (json.has("frames") || json.has("turntable")) {
    camera.framed = false;
    if (placed || json.has("frame") || json.has("turn_deg"))
      json.fail("", "frames or turntable without frame, turn_deg, eye, look_at and up", "them beside it");
    if (!json.at_most_one({"frames", "turntable"})) return camera;
    if (json.has("frames")) read_keys(json, &camera);
    if (json.has("turntable")) camera.turntable = read_turntable(json.child("turntable"));
    return camera;
  }
  camera.framed = json.boolean("frame").value_or(!json.has("eye"));
  if (camera.framed && placed) json.fail("", "\"frame\": true, or eye, look_at and up", "both");
  if (!camera.framed && !json.has("eye")) json.fail("eye", "an array of 3 numbers, or \"frame\": true", "neither");
  if (!camera.framed && json.has("turn_deg"))
    json.fail("turn_deg", "this key where the camera is placed to see the hair", "it beside \"eye\"");
  camera.turn_rad = json.number("turn_deg").value_or(0) * radians;
  if (!camera.framed) check_view(json, camera.camera);
  return camera;
}

}  // namespace tress::scene
