#include "scene/read/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/pi.h"
#include "scene/model/parameters.h"
#include "scene/read/json_reader.h"
#include "scene/read/material_reader.h"
#include "scene/read/set_keys.h"

namespace tress::scene {
namespace {

constexpr std::size_t most_materials = 4096, most_grooms = 4096, most_lights = 1024, most_meshes = 4096;

void read_image(const JsonReader& json, Image* image) {
  if (!json.object()) return;
  image->width = static_cast<int>(json.integer("width").value_or(image->width));
  image->height = static_cast<int>(json.integer("height").value_or(image->height));
  image->samples = static_cast<int>(json.integer("samples").value_or(image->samples));
  image->least_width_px = static_cast<float>(json.number("least_width").value_or(image->least_width_px));
  image->curve_error_px = static_cast<float>(json.number("curve_error").value_or(image->curve_error_px));
  image->transparent = json.boolean("transparent").value_or(image->transparent);
  image->exposure_stops = json.number("exposure").value_or(image->exposure_stops);
  if (const auto view = json.choice("view", image::view_names())) image->view = *image::view_of(*view);
  if (std::int64_t{image->width} * image->height > most_image_pixels)
    json.fail("", fmt::format("at most {} pixels", most_image_pixels),
              fmt::format("{} x {}", image->width, image->height));
}

Integrator read_integrator(const JsonReader& json) {
  Integrator integrator;
  if (!json.object()) return integrator;
  const auto whole = [&](const char* key) {
    const auto value = json.integer(key);
    return value ? std::optional(static_cast<int>(*value)) : std::nullopt;
  };
  integrator.max_depth = whole("max_depth");
  integrator.light_samples = whole("light_samples");
  integrator.bcsdf_samples = whole("bcsdf_samples");
  integrator.roulette = json.choice("roulette");
  integrator.deep_light = json.choice("deep_light");
  integrator.deep_light_depth = whole("deep_light_depth");
  integrator.adaptive = json.boolean("adaptive");
  integrator.spectral = json.boolean("spectral").value_or(false);
  if (json.is_text("near"))
    integrator.near = json.choice("near");
  else if (const auto pixels = json.number("near"))
    integrator.near_pixels = static_cast<float>(*pixels);
  if (integrator.learns_deep_light() && integrator.roulette == "throughput")
    json.fail("deep_light", "traced with roulette throughput, which learns no light", "learned");
  if (json.has("deep_light_depth") && !json.has("deep_light"))
    json.fail("deep_light_depth", "this key beside \"deep_light\" only", "it alone");
  return integrator;
}

/// Checks the expected answer of a scene that has one. Tests compare renders with it; no render uses it.
void read_expected(const JsonReader& json) {
  if (json.object()) json.triple("radiance");
}

Error not_json(const std::string& name, const nlohmann::json::parse_error& error) {
  std::string why = error.what();
  if (const auto colon = why.find("] "); colon != std::string::npos) why = why.substr(colon + 2);
  return {name, fmt::format("byte {}", error.byte), "JSON", why.substr(0, 200)};
}

CoatParameters read_coat(const JsonReader& json) {
  CoatParameters coat;
  if (!json.object()) return coat;
  coat.roughness = static_cast<float>(json.number("roughness").value_or(coat.roughness));
  coat.eta = static_cast<float>(json.number("eta").value_or(coat.eta));
  return coat;
}

}  // namespace

void check_rising(const JsonReader& key, int frame, std::optional<int> before) {
  if (before && frame <= *before)
    key.fail("frame", fmt::format("more than {}, the frame before", *before), fmt::format("{}", frame));
}

ObjectPath read_path(const JsonReader& json) {
  const auto read = [](const JsonReader& at, ObjectTransform transform) {
    transform.scale = at.number("scale").value_or(transform.scale);
    transform.rotate_deg = at.triple("rotate_deg").value_or(transform.rotate_deg);
    transform.translate = at.triple("translate").value_or(transform.translate);
    return transform;
  };
  ObjectPath path;
  path.still = read(json, {});
  for (const auto& item : json.items("frames", most_keys)) {
    if (!item.object() || !item.need({"frame"})) return path;
    const TransformKey key{static_cast<int>(item.integer("frame").value_or(0)), read(item, path.still)};
    check_rising(item, key.frame, path.keys.empty() ? std::nullopt : std::optional(path.keys.back().frame));
    path.keys.push_back(key);
  }
  if (json.has("frames") && path.keys.empty()) json.fail("frames", "one frame or more", "none");
  return path;
}

Visibility read_visibility(const JsonReader& json) {
  return {.camera = json.boolean("visible").value_or(true),
          .shadow = json.boolean("casts_shadow").value_or(true),
          .indirect = json.boolean("visible_indirect").value_or(true)};
}

MeshDescription read_mesh(const JsonReader& json) {
  MeshDescription mesh;
  if (!json.object() || !json.need({"file"}) || !json.at_most_one({"albedo", "albedo_file"})) return mesh;
  mesh.name = json.text("name");
  mesh.file = json.text("file").value_or("");
  if (const auto up = json.choice("up")) mesh.y_up = *up == "y";
  mesh.cm_per_unit = json.number("cm_per_unit").value_or(mesh.cm_per_unit);
  mesh.path = read_path(json);
  mesh.albedo = json.triple("albedo").value_or(mesh.albedo);
  mesh.albedo_file = json.text("albedo_file");
  if (json.has("coat")) mesh.coat = read_coat(json.child("coat"));
  mesh.visibility = read_visibility(json);
  mesh.holdout = json.boolean("holdout").value_or(mesh.holdout);
  if (mesh.holdout && !mesh.visibility.camera)
    json.fail("holdout", "a mesh that the camera sees", "\"visible\": false");
  return mesh;
}

Result<SceneDescription> parse_scene_file(std::span<const unsigned char> text, const std::string& name, KnownKeys* keys,
                                          std::span<const std::string> settings) {
  nlohmann::json document;
  try {
    document = nlohmann::json::parse(text.begin(), text.end());
  } catch (const nlohmann::json::parse_error& error) {
    return not_json(name, error);
  } catch (const nlohmann::json::exception& error) {
    return Error{name, "", "JSON with numbers in range", error.what()};
  }
  const auto set = set_keys(settings, &document);
  if (!set) {
    Error fault = set.error();
    fault.file = name;
    return fault;
  }
  std::optional<Error> error;
  const JsonReader root(document, "", name, &error, keys);
  SceneDescription scene;
  if (root.object()) {
    root.text("$schema");
    if (root.has("expected")) read_expected(root.child("expected"));
    if (root.has("camera")) scene.camera = read_camera(root.child("camera"));
    if (root.has("image")) read_image(root.child("image"), &scene.image);
    if (root.has("integrator")) scene.integrator = read_integrator(root.child("integrator"));
    if (root.has("environment")) scene.environment = read_environment(root.child("environment"));
    scene.environment_visible = root.boolean("environment_visible").value_or(true);
    for (const auto& item : root.items("lights", most_lights)) scene.lights.push_back(read_light(item));
    for (const auto& item : root.items("meshes", most_meshes)) scene.meshes.push_back(read_mesh(item));
    for (const auto& item : root.items("materials", most_materials)) {
      scene.materials.push_back(read_material(item, scene.materials.size(), scene.integrator.spectral));
      for (std::size_t m = 0; m + 1 < scene.materials.size(); ++m)
        if (scene.materials[m].name == scene.materials.back().name)
          item.fail("name", "a name of its own", fmt::format("that of /materials/{}", m));
    }
    if (scene.materials.empty()) scene.materials.push_back(usual_material(scene.integrator.spectral));
    for (const auto& item : root.items("grooms", most_grooms))
      scene.grooms.push_back(read_groom(item, scene.materials));
    if (scene.grooms.empty()) root.fail("grooms", "one groom or more", "none");
  }
  if (error) {
    if (const KeySetting* setting = setting_of(*set, error->place))
      error->file += fmt::format(" with --set {}", setting->text);
    return *error;
  }
  return scene;
}

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

namespace {

void read_sky(const JsonReader& json, EnvironmentDescription* environment) {
  if (!json.object()) return;
  GradientSky& sky = environment->sky;
  sky.zenith = json.triple("zenith").value_or(sky.zenith);
  sky.horizon = json.triple("horizon").value_or(sky.horizon);
  sky.ground = json.triple("ground").value_or(sky.ground);
  if (json.has("sun")) environment->sun = read_distant_light(json.child("sun"));
}

void read_keys(const JsonReader& json, EnvironmentDescription* environment) {
  std::vector<TurnKey>& keys = environment->keys;
  for (const auto& item : json.items("frames", most_keys)) {
    if (!item.object() || !item.need({"frame", "rotate_deg"})) return;
    const TurnKey key{static_cast<int>(item.integer("frame").value_or(0)), item.number("rotate_deg").value_or(0)};
    check_rising(item, key.frame, keys.empty() ? std::nullopt : std::optional(keys.back().frame));
    keys.push_back(key);
  }
  if (json.has("frames") && keys.empty()) json.fail("frames", "one frame or more", "none");
}

}  // namespace

double EnvironmentDescription::turn_at(double frame) const {
  if (keys.empty()) return rotate_deg;
  const auto next = std::ranges::find_if(keys, [frame](const TurnKey& key) { return key.frame >= frame; });
  if (next == keys.end()) return keys.back().rotate_deg;
  if (next == keys.begin()) return next->rotate_deg;
  const TurnKey& before = *(next - 1);
  const double share = (frame - before.frame) / (double(next->frame) - before.frame);
  return before.rotate_deg + share * (next->rotate_deg - before.rotate_deg);
}

EnvironmentDescription read_environment(const JsonReader& json) {
  using Kind = EnvironmentDescription::Kind;
  EnvironmentDescription environment;
  if (!json.object() || !json.exactly_one({"file", "constant", "studio", "sky"})) return environment;
  if (const auto file = json.text("file")) environment.kind = Kind::file, environment.file = *file;
  if (const auto constant = json.triple("constant"))
    environment.kind = Kind::constant, environment.constant = *constant;
  if (json.has("studio") && !json.boolean("studio").value_or(true)) json.fail("studio", "true", "false");
  if (json.has("sky")) {
    environment.kind = Kind::sky;
    read_sky(json.child("sky"), &environment);
  }
  environment.rotate_deg = json.number("rotate_deg").value_or(0);
  read_keys(json, &environment);
  environment.scale = static_cast<float>(json.number("scale").value_or(1));
  environment.group = read_light_group(json);
  environment.links = read_links(json);
  return environment;
}

std::optional<Light> sun_of(const EnvironmentDescription& environment, double rotate_deg) {
  if (environment.kind != EnvironmentDescription::Kind::sky || !environment.sun) return std::nullopt;
  Light sun = *environment.sun;
  const double turn = rotate_deg * std::numbers::pi / 180, c = std::cos(turn), s = std::sin(turn);
  const glm::vec3 d = sun.direction;
  sun.direction = glm::vec3(static_cast<float>(c * d.x - s * d.y), static_cast<float>(s * d.x + c * d.y), d.z);
  sun.radiance *= environment.scale;
  sun.group = environment.group;
  sun.links = environment.links;
  return sun;
}

}  // namespace tress::scene
