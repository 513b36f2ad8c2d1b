#include "scene/read/load_scene.h"

#include <fmt/format.h>

#include <cstring>
#include <glm/common.hpp>
#include <numbers>

#include "scene/generate/studio_environment.h"
#include "scene/model/camera_motion.h"
#include "scene/model/groom_taper.h"
#include "scene/model/strand_fibers.h"
#include "scene/read/environment_file.h"
#include "scene/read/input_file.h"
#include "scene/read/scene_file.h"

namespace tress::scene {
namespace {

constexpr std::uintmax_t most_scene_bytes = std::uintmax_t{64} << 20, most_hair_bytes = std::uintmax_t{8} << 30;
constexpr std::uintmax_t most_obj_bytes = std::uintmax_t{2} << 30;

SceneDescription bare_hair_file(const std::filesystem::path& file) {
  SceneDescription scene;
  scene.materials.emplace_back();
  scene.grooms.emplace_back();
  scene.grooms[0].file = std::filesystem::absolute(file).string();
  return scene;
}

std::optional<Error> out_of_range(const std::string& option, double value, double low, double high) {
  if (value >= low && value <= high) return std::nullopt;
  return Error{"", option, fmt::format("{:g}..{:g}", low, high), fmt::format("{:g}", value)};
}

std::optional<Error> apply(const Overrides& overrides, SceneDescription* scene) {
  using Kind = EnvironmentDescription::Kind;
  std::optional<Error> error;
  const auto check = [&](const char* option, double value, double low, double high) {
    if (!error) error = out_of_range(option, value, low, high);
    return !error;
  };
  if (overrides.environment_file) {
    scene->environment = EnvironmentDescription{};
    scene->environment.kind = Kind::file;
    scene->environment.file = std::filesystem::absolute(*overrides.environment_file).string();
  }
  if (overrides.environment_rotate_deg && check("--rotate", *overrides.environment_rotate_deg, -360, 360))
    scene->environment.rotate_deg = *overrides.environment_rotate_deg;
  for (auto& material : scene->materials) {
    auto& fiber = material.fiber;
    if (overrides.color || overrides.melanin || overrides.sigma_a) material.color_from_file = false;
    bool colors_fit = true;
    for (int c = 0; c < 3; ++c) {
      if (overrides.color) colors_fit = check("--color", (*overrides.color)[c], 0, 1) && colors_fit;
      if (overrides.sigma_a) colors_fit = check("--sigma-a", (*overrides.sigma_a)[c], 0, 1e4) && colors_fit;
    }
    if (overrides.color && colors_fit)
      fiber.sigma_a = fiber::sigma_a_from_color(glm::clamp(*overrides.color, glm::vec3(0.001f), glm::vec3(0.999f)));
    if (overrides.melanin && check("--melanin", overrides.melanin->first, 0, 100) &&
        check("--melanin", overrides.melanin->second, 0, 100))
      fiber.sigma_a = fiber::sigma_a_from_melanin(overrides.melanin->first, overrides.melanin->second);
    if (overrides.sigma_a && colors_fit) fiber.sigma_a = *overrides.sigma_a;
    if (overrides.eccentricity && check("--eccentricity", *overrides.eccentricity, 0.5, 1))
      fiber.eccentricity = *overrides.eccentricity;
    if (overrides.roughness && check("--roughness", *overrides.roughness, 0.01, 1))
      fiber.roughness = *overrides.roughness;
  }
  for (auto& groom : scene->grooms) {
    if (!groom.file) continue;
    if (overrides.y_up) groom.placement.y_up = *overrides.y_up;
    if (overrides.cm_per_unit && check("--cm-per-unit", *overrides.cm_per_unit, 1e-6, 1e6))
      groom.placement.cm_per_unit = *overrides.cm_per_unit;
  }
  auto& image = scene->image;
  if (overrides.width && check("--resolution", *overrides.width, 1, 65536)) image.width = *overrides.width;
  if (overrides.height && check("--resolution", *overrides.height, 1, 65536)) image.height = *overrides.height;
  if (overrides.samples && check("--spp", *overrides.samples, 1, 1e6)) image.samples = *overrides.samples;
  check("--resolution (pixels)", static_cast<double>(image.width) * image.height, 1, 1 << 26);
  return error;
}

Result<Environment> make_environment(const EnvironmentDescription& description, const std::filesystem::path& folder,
                                     Scene* scene) {
  using Kind = EnvironmentDescription::Kind;
  const double rotate_rad = description.rotate_deg * std::numbers::pi / 180;
  if (description.kind == Kind::constant) return Environment(description.constant * description.scale);
  if (description.kind == Kind::studio) return studio_environment(rotate_rad, description.scale);
  if (description.kind == Kind::sky) return gradient_environment(description.sky, description.scale);
  return load_environment(folder / description.file, rotate_rad, description.scale, &scene->warnings);
}

Result<Groom> make_groom(const GroomDescription& description, const std::filesystem::path& folder, Scene* scene) {
  if (!description.file) return generate_groom(description.recipe);
  const auto file = folder / *description.file;
  const auto bytes = read_input_file(file, "a .hair file", most_hair_bytes);
  if (!bytes) return bytes.error();
  const auto hair = parse_hair_file(*bytes, file.string());
  if (!hair) return hair.error();
  return assemble_groom(*hair, description.placement, file.string(), &scene->notes, &scene->warnings);
}

Result<Mesh> make_mesh(const MeshDescription& description, const std::filesystem::path& folder, Scene* scene) {
  const auto file = folder / description.file;
  const auto bytes = read_input_file(file, "an .obj file", most_obj_bytes);
  if (!bytes) return bytes.error();
  const auto obj = parse_obj_file(*bytes, file.string());
  if (!obj) return obj.error();
  return place_mesh(*obj, description, file.string(), &scene->warnings);
}

bool is_hair_file(const std::filesystem::path& file, const std::vector<unsigned char>& bytes) {
  return file.extension() == ".hair" || (bytes.size() >= 4 && std::memcmp(bytes.data(), "HAIR", 4) == 0);
}

Result<SceneDescription> describe(const std::filesystem::path& file) {
  const bool hair = file.extension() == ".hair";
  const auto bytes = read_input_file(file, hair ? "a .hair file" : "a scene (JSON or .hair)", most_hair_bytes);
  if (!bytes) return bytes.error();
  if (is_hair_file(file, *bytes)) return bare_hair_file(file);
  if (bytes->size() > most_scene_bytes)
    return Error{file.string(), "", fmt::format("a scene of at most {} bytes", most_scene_bytes),
                 fmt::format("{}", bytes->size())};
  return parse_scene_file(*bytes, file.string());
}

}  // namespace

Result<Scene> load_scene(const std::filesystem::path& file, const Overrides& overrides) {
  auto described = describe(file);
  if (!described) return described.error();
  SceneDescription& description = *described;
  if (auto error = apply(overrides, &description)) return *error;

  Scene scene;
  scene.source = file.string();
  scene.image = description.image;
  scene.environment_visible = description.environment_visible;
  scene.lights = std::move(description.lights);
  if (const auto sun = sun_of(description.environment)) scene.lights.push_back(*sun);
  scene.materials = std::move(description.materials);
  const auto folder = file.parent_path();
  auto environment = make_environment(description.environment, folder, &scene);
  if (!environment) return environment.error();
  scene.environment = std::move(*environment);
  for (const auto& mesh_description : description.meshes) {
    auto mesh = make_mesh(mesh_description, folder, &scene);
    if (!mesh) return mesh.error();
    if (!mesh->triangles.empty()) scene.meshes.push_back(std::move(*mesh));
  }
  for (const auto& groom_description : description.grooms) {
    auto groom = make_groom(groom_description, folder, &scene);
    if (!groom) return groom.error();
    apply_taper(groom_description.taper, &*groom);
    groom->linear = groom_description.linear;
    groom->material = groom_description.material;
    if (groom->strand_count() == 0)
      scene.warnings.push_back(groom->name + ": no strand is left to draw");
    else
      scene.grooms.push_back(std::move(*groom));
  }
  if (auto error = assign_fibers(&scene)) return *error;
  const auto camera = camera_at(description.camera, overrides.frame, scene.grooms, scene.image, file.string());
  if (!camera) return camera.error();
  scene.camera = *camera;
  if (overrides.frame && description.camera.keys.empty() && !description.camera.turntable)
    scene.notes.push_back(fmt::format("{}: the camera does not move, every frame is the same", file.string()));
  if (description.camera.framed && !scene.grooms.empty())
    scene.notes.push_back(
        fmt::format("camera framed on the hair: eye ({:.2f}, {:.2f}, {:.2f}), look_at ({:.2f}, {:.2f}, {:.2f})",
                    scene.camera.eye.x, scene.camera.eye.y, scene.camera.eye.z, scene.camera.look_at.x,
                    scene.camera.look_at.y, scene.camera.look_at.z));
  return scene;
}

}  // namespace tress::scene
