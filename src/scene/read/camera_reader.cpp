#include <fmt/format.h>

#include "base/pi.h"
#include "scene/model/parameters.h"
#include "scene/read/scene_file.h"

namespace tress::scene {
namespace {

/// Reads the keys that a still camera and a keyframe share; `camera` has the defaults.
Camera read_view(const JsonReader& json, Camera camera) {
  camera.eye = json.triple("eye").value_or(camera.eye);
  camera.look_at = json.triple("look_at").value_or(camera.look_at);
  camera.up = json.triple("up").value_or(camera.up);
  if (!json.at_most_one({"vertical_fov_deg", "focal_length_mm", "orthographic_height_cm"})) return camera;
  if (const auto x = json.number("vertical_fov_deg")) {
    camera.vertical_fov_deg = static_cast<float>(*x);
    camera.focal_length_mm = 0;
  }
  if (const auto x = json.number("focal_length_mm")) camera.focal_length_mm = static_cast<float>(*x);
  const auto fault = fault_of(camera);
  const bool is_along_default = fault && fault->key == "up" && camera.up == Camera{}.up;
  if (is_along_default && !json.has("up")) camera.up = {0, 1, 0};  // it looks straight up or down
  return camera;
}

void check_view(const JsonReader& json, const Camera& camera) {
  if (json.failed()) return;
  if (const auto fault = fault_of(camera)) json.fail(fault->key, fault->expected, fault->found);
}

void read_keys(const JsonReader& json, CameraDescription* camera) {
  for (const auto& item : json.items("frames", most_keys)) {
    if (!item.object() || !item.need({"frame", "eye"})) return;
    const auto frame = item.integer("frame");
    const CameraKey key{static_cast<int>(frame.value_or(0)), read_view(item, camera->camera)};
    check_view(item, key.camera);
    check_rising(item, key.frame, camera->keys.empty() ? std::nullopt : std::optional(camera->keys.back().frame));
    if (item.failed()) return;
    camera->keys.push_back(key);
  }
  if (camera->keys.empty()) json.fail("frames", "one frame or more", "none");
}

Turntable read_turntable(const JsonReader& json) {
  Turntable turntable;
  if (!json.object() || !json.need({"frames"})) return turntable;
  turntable.frames = static_cast<int>(json.integer("frames").value_or(1));
  turntable.turns_camera = json.choice("turns").value_or("object") == "camera";
  turntable.look_at = json.triple("look_at");
  if (const auto x = json.number("distance_cm")) turntable.distance_cm = static_cast<float>(*x);
  if (const auto x = json.number("height_cm")) turntable.height_cm = static_cast<float>(*x);
  if (json.has("height_cm") && !json.has("distance_cm"))
    json.fail("height_cm", "this key beside \"distance_cm\" only", "it alone");
  if (turntable.distance_cm) check_view(json, {.eye = {0, -*turntable.distance_cm, turntable.height_cm}});
  return turntable;
}

std::optional<float> float_of(std::optional<double> x) {
  return x ? std::optional(static_cast<float>(*x)) : std::nullopt;
}

void read_depth_of_field(const JsonReader& json, CameraDescription* camera) {
  if (!json.object() || !json.exactly_one({"f_number", "radius_cm"}) || !json.at_most_one({"focus_cm", "focus_point"}))
    return;
  camera->lens.f_number = float_of(json.number("f_number"));
  camera->lens.radius_cm = float_of(json.number("radius_cm"));
  camera->lens.focus_cm = float_of(json.number("focus_cm"));
  camera->lens.focus_point = json.triple("focus_point");
  camera->camera.blades = static_cast<int>(json.integer("blades").value_or(0));
  const double rotation_deg = json.number("blade_rotation_deg").value_or(0);
  camera->camera.blade_rotation_rad = static_cast<float>(rotation_deg * degree);
  if (json.has("blade_rotation_deg") && !json.has("blades"))
    json.fail("blade_rotation_deg", "this key beside \"blades\" only", "it without them");
  if (json.has("f_number") && camera->camera.orthographic_height_cm > 0)
    json.fail("f_number", "radius_cm, as an orthographic camera has no focal length", "an f-number");
}

/// Reads the properties of a camera that do not depend on its place.
void read_optics(const JsonReader& json, CameraDescription* camera) {
  using Fit = Lens::Fit;
  if (const auto x = json.number("orthographic_height_cm"))
    camera->camera.orthographic_height_cm = static_cast<float>(*x);
  camera->camera.shift_x = float_of(json.number("shift_x")).value_or(0);
  camera->camera.shift_y = float_of(json.number("shift_y")).value_or(0);
  camera->lens.sensor_mm = float_of(json.number("sensor_mm")).value_or(camera->lens.sensor_mm);
  if (const auto fit = json.choice("sensor_fit"))
    camera->lens.sensor_fit = *fit == "width" ? Fit::width : *fit == "height" ? Fit::height : Fit::longer;
  if (json.has("depth_of_field")) read_depth_of_field(json.child("depth_of_field"), camera);
}

Shutter read_shutter(const JsonReader& json) {
  Shutter shutter;
  if (!json.object()) return shutter;
  shutter.open = json.number("open").value_or(0);
  shutter.close = json.number("close").value_or(0);
  return shutter;
}

}  // namespace

CameraDescription read_camera(const JsonReader& json) {
  CameraDescription camera;
  if (!json.object()) return camera;
  if (json.has("shutter")) camera.shutter = read_shutter(json.child("shutter"));
  camera.frames_per_second = json.number("frames_per_second");
  camera.shutter.samples = static_cast<int>(json.integer("motion_samples").value_or(camera.shutter.samples));
  const bool placed = json.has("eye") || json.has("look_at") || json.has("up");
  camera.camera = read_view(json, camera.camera);
  read_optics(json, &camera);
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
  camera.turn_rad = json.number("turn_deg").value_or(0) * degree;
  if (!camera.framed) check_view(json, camera.camera);
  return camera;
}

}  // namespace tress::scene
