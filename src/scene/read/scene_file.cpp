#include "scene/read/scene_file.h"

#include <fmt/format.h>

#include "scene/read/json_reader.h"
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

}  // namespace tress::scene
