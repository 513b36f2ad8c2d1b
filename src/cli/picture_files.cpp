#include "cli/picture_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "cli/console.h"
#include "cli/output_files.h"
#include "cli/picture_preview.h"
#include "cli/telemetry_lines.h"
#include "denoise/denoised_layer.h"
#include "integrate/camera_projection.h"
#include "tress/version.h"

namespace tress::cli {
namespace {

/// The camera as JSON with the keys of a scene file.
std::string camera_text(const scene::Camera& camera) {
  const auto triple = [](const glm::vec3& x) { return nlohmann::ordered_json{x.x, x.y, x.z}; };
  nlohmann::ordered_json keys{
      {"eye", triple(camera.eye)}, {"look_at", triple(camera.look_at)}, {"up", triple(camera.up)}};
  if (camera.orthographic_height_cm > 0)
    keys["orthographic_height_cm"] = camera.orthographic_height_cm;
  else
    keys["vertical_fov_deg"] = camera.vertical_fov_deg;
  if (camera.shift_x != 0) keys["shift_x"] = camera.shift_x;
  if (camera.shift_y != 0) keys["shift_y"] = camera.shift_y;
  if (camera.lens_radius_cm > 0) {
    nlohmann::ordered_json& lens = keys["depth_of_field"];
    lens = {{"radius_cm", camera.lens_radius_cm}, {"focus_cm", camera.focus_cm}};
    if (camera.blades > 0) lens["blades"] = camera.blades;
    if (camera.blades > 0) lens["blade_rotation_deg"] = camera.blade_rotation_rad * 180 / std::numbers::pi_v<float>;
  }
  return json_text(keys);
}

}  // namespace

void describe_request(const RenderSettings& settings, const scene::Scene& scene, const Identity& identity,
                      image::Picture* picture) {
  std::map<std::string, std::string>& header = picture->metadata;
  header["scene"] = scene.source;
  header["settings"] = identity_text(identity);
  header["command"] = settings.command;
  header["version"] = version();
  if (settings.overrides.frame) header["frame"] = std::to_string(*settings.overrides.frame);
  scene::Camera camera = scene.camera;
  for (glm::vec3* place : {&camera.eye, &camera.look_at}) *place = glm::vec3(glm::dvec3(*place) + scene.origin);
  header["camera"] = camera_text(camera);
  integrate::describe_camera(scene.camera, scene.image, picture, scene.origin);
  header["exposure"] = fmt::format("{} stops, of the PNG alone", scene.image.exposure_stops);
  header["view"] =
      image::view_names()[static_cast<std::size_t>(scene.image.view)] + ", of the PNG alone; these pixels are linear";
  header["alpha"] = scene.environment_visible && !scene.image.transparent
                        ? "opaque: R, G, B have the background, A is 1"
                        : "premultiplied: R, G, B have no background, A is the coverage";
  if (scene.image.transparent) header["alpha"] += alpha_of_png;
  header["seed"] = std::to_string(settings.render.seed);
  header["model"] = settings.model;
  if (settings.quadrature_points) header["quadrature_points"] = std::to_string(*settings.quadrature_points);
  header["estimator"] = fiber::estimator_name(estimator_of(settings));
  header["epsilon"] = fmt::format("{}", fiber::find_model(settings.model)->epsilon(settings.table));
}

void keep_asked_layers(const RenderSettings& settings, image::Picture* picture) {
  if (settings.layers) {
    std::vector<std::string> layers = *settings.layers;
    layers.emplace_back(denoise::denoised_layer);
    image::keep_layers(layers, picture);
  }
  if (!settings.keeps_halves) integrate::remove_halves(picture);
}

std::optional<std::filesystem::path> PictureFiles::write(const std::filesystem::path& file, const Write& to) {
  const std::optional<Error> error = to(file);
  if (!error) {
    remove_leftovers(file);
    return file;
  }
  check(error);
  for (const std::filesystem::path& place : other_places(file)) {
    if (to(place)) continue;
    log_warning(fmt::format("{}: saved as {} instead", file.string(), place.string()));
    return place;
  }
  return std::nullopt;
}

void PictureFiles::check(const std::optional<Error>& error) {
  if (!error) return;
  log_error(error->message());
  failed_ = true;
}

}  // namespace tress::cli
