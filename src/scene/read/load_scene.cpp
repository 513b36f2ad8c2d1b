#include "scene/read/load_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "scene/generate/generated_environments.h"
#include "scene/model/camera.h"
#include "scene/model/hair_colors.h"
#include "scene/model/light.h"
#include "scene/model/parameters.h"
#include "scene/model/strand_fibers.h"
#include "scene/read/assembly.h"
#include "scene/read/groom_files.h"
#include "scene/read/grooms/groom_formats.h"
#include "scene/read/input_files.h"
#include "scene/read/scene_file.h"
#include "tress/fiber/lock_color.h"

namespace tress::scene {
namespace {

constexpr std::uintmax_t most_scene_bytes = std::uintmax_t{64} << 20;
constexpr std::uintmax_t most_obj_bytes = std::uintmax_t{2} << 30;

SceneDescription bare_groom(const std::filesystem::path& file) {
  SceneDescription scene;
  scene.materials.emplace_back();
  scene.grooms.emplace_back();
  scene.grooms[0].file = std::filesystem::absolute(file).string();
  scene.grooms[0].placement.guess_up = true;
  return scene;
}

/// Of an option that a caller gave a value out of the range of its parameter; the command line has checked them.
std::optional<Error> fault_of(const Overrides& o) {
  std::optional<Error> error;
  const auto check = [&](const char* option, const auto& value) {
    const Parameter& parameter = option_parameter(option);
    const auto one = [&](const auto x) {
      Range range = parameter.range;  // its ends as the type of the value has them
      range.least = static_cast<double>(static_cast<decltype(x)>(range.least));
      range.most = static_cast<double>(static_cast<decltype(x)>(range.most));
      if (!error && !range.contains(x))
        error = Error{"", option, words(parameter), fmt::format("{:g}", static_cast<double>(x))};
    };
    if constexpr (requires { value->length(); }) {
      for (int c = 0; value && c < 3; ++c) one((*value)[c]);
    } else if constexpr (requires { value->second; }) {
      if (value) one(value->first), one(value->second);
    } else if (value) {
      one(*value);
    }
  };
  check("--rotate", o.environment_rotate_deg);
  check("--color", o.color);
  check("--melanin", o.melanin);
  check("--sigma-a", o.sigma_a);
  check("--eccentricity", o.eccentricity);
  check("--roughness", o.roughness);
  check("--cm-per-unit", o.cm_per_unit);
  check("--resolution", o.width);
  check("--resolution", o.height);
  check("--spp", o.samples);
  check("--frame", o.frame);
  check("--turn", o.turn_deg);
  check("--exposure", o.exposure_stops);
  return error;
}

std::optional<Error> apply(const Overrides& overrides, SceneDescription* scene) {
  using Kind = EnvironmentDescription::Kind;
  if (auto error = fault_of(overrides)) return error;
  if (overrides.environment_file) {
    scene->environment = EnvironmentDescription{};
    scene->environment.kind = Kind::file;
    scene->environment.file = std::filesystem::absolute(*overrides.environment_file).string();
  }
  if (overrides.environment_rotate_deg) scene->environment.rotate_deg = *overrides.environment_rotate_deg;
  for (auto& material : scene->materials) {
    auto& fiber = material.fiber;
    const bool pigment = overrides.melanin || overrides.sigma_a || overrides.hair;
    if (overrides.color || pigment) material.color_from_file = false;
    if (overrides.eccentricity) fiber.eccentricity = *overrides.eccentricity;
    if (overrides.roughness) fiber.roughness = *overrides.roughness;
    if (pigment) material.color.reset();
    if (overrides.color) material.color = overrides.color;
    if (material.color) fiber.sigma_a = fiber::sigma_a_of_lock(*material.color, fiber);
    if (overrides.melanin)
      fiber.sigma_a = fiber::sigma_a_from_melanin(overrides.melanin->first, overrides.melanin->second);
    if (overrides.sigma_a) fiber.sigma_a = *overrides.sigma_a;
    if (overrides.hair) fiber.sigma_a = sigma_a_of_hair(*overrides.hair).value_or(fiber.sigma_a);
  }
  for (auto& groom : scene->grooms) {
    if (!groom.file) continue;
    if (overrides.y_up) groom.placement.y_up = *overrides.y_up;
    if (overrides.cm_per_unit) groom.placement.cm_per_unit = *overrides.cm_per_unit;
  }
  if (overrides.turn_deg) {
    if (!scene->camera.framed)
      return Error{"", "--turn", "a camera that is placed to see the hair", "one that the scene places"};
    scene->camera.turn_rad = *overrides.turn_deg * std::numbers::pi / 180;
  }
  auto& image = scene->image;
  image.width = overrides.width.value_or(image.width);
  image.height = overrides.height.value_or(image.height);
  image.samples = overrides.samples.value_or(image.samples);
  image.transparent = overrides.transparent.value_or(image.transparent);
  image.exposure_stops = overrides.exposure_stops.value_or(image.exposure_stops);
  image.view = overrides.view.value_or(image.view);
  const std::int64_t pixels = std::int64_t{image.width} * image.height;
  if (pixels > most_image_pixels)
    return Error{"", "--resolution", fmt::format("at most {} pixels", most_image_pixels), fmt::format("{}", pixels)};
  return std::nullopt;
}

/// Where what a scene names as files comes from: memory first, else relative to a folder.
struct Sources {
  std::filesystem::path folder;
  FilesInMemory memory = {};
};

Result<Environment> make_environment(const EnvironmentDescription& description, Sources& from, Scene* scene) {
  using Kind = EnvironmentDescription::Kind;
  const double rotate_rad = description.rotate_deg * std::numbers::pi / 180;
  if (description.kind == Kind::constant) return Environment(description.constant * description.scale);
  if (description.kind == Kind::studio) return studio_environment(rotate_rad, description.scale);
  if (description.kind == Kind::sky) return gradient_environment(description.sky, description.scale);
  if (const auto found = from.memory.environments.find(description.file); found != from.memory.environments.end())
    return make_environment(std::move(found->second), description.file, rotate_rad, description.scale,
                            &scene->warnings);
  return load_environment(from.folder / description.file, rotate_rad, description.scale, &scene->warnings);
}

Result<Groom> make_groom(const GroomDescription& description, Sources& from, Scene* scene) {
  if (!description.file) {
    Groom groom = generate_groom(description.recipe);
    groom.basis = description.placement.basis.value_or(groom.basis);
    return groom;
  }
  if (auto strands = from.memory.grooms.extract(*description.file))
    return assemble_groom(std::move(strands.mapped()), description.placement, *description.file, &scene->notes,
                          &scene->warnings);
  const auto file = from.folder / *description.file;
  auto strands = read_groom_file(file, description.points_per_strand);
  if (!strands) return strands.error();
  return assemble_groom(std::move(*strands), description.placement, file.string(), &scene->notes, &scene->warnings);
}

Result<ObjFile> read_mesh_file(const std::filesystem::path& file) {
  const auto bytes = read_input_file(file, "an .obj file", most_obj_bytes);
  if (!bytes) return bytes.error();
  return parse_obj_file(*bytes, file.string());
}

Result<Mesh> make_mesh(const MeshDescription& description, const Sources& from, Scene* scene) {
  const auto in_memory = from.memory.meshes.find(description.file);
  const bool is_read = in_memory == from.memory.meshes.end();
  const auto file = is_read ? from.folder / description.file : std::filesystem::path(description.file);
  const auto obj = is_read ? read_mesh_file(file) : Result<ObjFile>(in_memory->second);
  if (!obj) return obj.error();
  auto mesh = place_mesh(*obj, description, file.string(), &scene->warnings);
  if (!mesh || !description.albedo_file) return mesh;
  auto texture = load_texture(from.folder / *description.albedo_file, &scene->warnings);
  if (!texture) return texture.error();
  if (mesh->corner_uvs.empty())
    return Error{file.string(), "", "faces with texture coordinates (v/vt) under \"albedo_file\"", "none"};
  mesh->texture = std::move(*texture);
  return mesh;
}

/// What mattes call an object: as the scene says, else `usual`, with a number where another object has it.
std::string object_name(const std::optional<std::string>& name, const std::string& usual,
                        const std::set<std::string>& taken) {
  if (name) return *name;
  std::string free = usual;
  for (int number = 2; taken.contains(free); ++number) free = fmt::format("{} {}", usual, number);
  return free;
}

/// A camera that could not be in the next frame rests until then, which is a warning.
NextFrame next_frame(const CameraDescription& camera, std::optional<int> frame, Scene* scene, const std::string& name) {
  const int now = frame.value_or(camera.keys.empty() ? 0 : camera.keys.front().frame);
  const auto next = camera_at(camera, now + 1, scene->grooms, scene->image, name);
  if (!next) scene->warnings.push_back(next.error().message() + "; the layer forward is 0");
  ObjectTurn turn = object_turn_at(camera, now + 1, scene->grooms);
  turn.turn_rad -= object_turn_at(camera, now, scene->grooms).turn_rad;
  return {next ? *next : scene->camera, turn};
}

/// A scene is JSON, and that of a scene begins with a brace: whatever else there is, is told before it is read as JSON.
bool may_be_json(const std::filesystem::path& file, std::span<const unsigned char> start) {
  if (!known_kind_of(start).empty()) return false;
  constexpr std::string_view blanks = " \t\r\n\xef\xbb\xbf";  // with the mark of UTF-8
  const auto first =
      std::ranges::find_if(start, [&](unsigned char c) { return blanks.find(static_cast<char>(c)) == blanks.npos; });
  return file.extension() == ".json" || first == start.end() || *first == '{';
}

Result<SceneDescription> describe(const std::filesystem::path& file) {
  const std::string wanted = "a scene (JSON) or a groom (" + groom_endings() + ")";
  const auto start = read_file_start(file, wanted, bytes_of_kind);
  if (!start) return start.error();
  if (is_groom_file(file)) return bare_groom(file);
  if (!may_be_json(file, *start)) return Error{file.string(), "", wanted, kind_of(*start)};
  const auto bytes =
      read_input_file(file, fmt::format("a scene of at most {} bytes", most_scene_bytes), most_scene_bytes);
  if (!bytes) return bytes.error();
  return parse_scene_file(*bytes, file.string());
}

/// The scene of a description. `name`: what it was loaded from.
Result<Scene> build(SceneDescription description, const std::string& name, Sources from, const Overrides& overrides) {
  if (auto error = apply(overrides, &description)) return *error;

  Scene scene;
  scene.source = name;
  scene.image = description.image;
  scene.environment_visible = description.environment_visible;
  scene.environment_group = description.environment.group;
  scene.lights = std::move(description.lights);
  if (const auto sun = sun_of(description.environment)) scene.lights.push_back(*sun);
  scene.materials = std::move(description.materials);
  auto environment = make_environment(description.environment, from, &scene);
  if (!environment) return environment.error();
  scene.environment = std::move(*environment);
  std::set<std::string> taken;  // names of objects
  for (const auto& mesh_description : description.meshes) {
    auto mesh = make_mesh(mesh_description, from, &scene);
    if (!mesh) return mesh.error();
    mesh->object =
        object_name(mesh_description.name, std::filesystem::path(mesh_description.file).stem().string(), taken);
    taken.insert(mesh->object);
    if (!mesh->triangles.empty()) scene.meshes.push_back(std::move(*mesh));
  }
  for (const auto& groom_description : description.grooms) {
    auto groom = make_groom(groom_description, from, &scene);
    if (!groom) return groom.error();
    if (auto error = move_groom(groom_description.placement, &*groom)) return *error;
    const std::string usual = groom_description.file ? std::filesystem::path(*groom_description.file).stem().string()
                                                     : groom_description.recipe.kind;
    groom->object = object_name(groom_description.name, usual, taken);
    taken.insert(groom->object);
    apply_taper(groom_description.taper, &*groom);
    groom->material = groom_description.material;
    if (groom->strand_count() == 0)
      scene.warnings.push_back(groom->name + ": no strand is left to draw");
    else
      scene.grooms.push_back(std::move(*groom));
  }
  if (auto error = assign_fibers(&scene)) return *error;
  const auto camera = camera_at(description.camera, overrides.frame, scene.grooms, scene.image, name);
  if (!camera) return camera.error();
  scene.camera = *camera;
  if (!description.camera.keys.empty() || description.camera.turntable)
    scene.next = next_frame(description.camera, overrides.frame, &scene, name);
  turn_objects(object_turn_at(description.camera, overrides.frame, scene.grooms), &scene.grooms, &scene.meshes);
  if (const std::size_t groups = light_groups(scene).size(); groups > most_light_groups)
    return Error{name, "/lights", fmt::format("at most {} groups of light", most_light_groups),
                 fmt::format("{}", groups)};
  if (overrides.frame && description.camera.keys.empty() && !description.camera.turntable)
    scene.notes.push_back(fmt::format("{}: the camera does not move, every frame is the same but for its grain", name));
  if (description.camera.framed && !scene.grooms.empty())
    scene.notes.push_back(
        fmt::format("camera framed on the hair: eye ({:.2f}, {:.2f}, {:.2f}), look_at ({:.2f}, {:.2f}, {:.2f})",
                    scene.camera.eye.x, scene.camera.eye.y, scene.camera.eye.z, scene.camera.look_at.x,
                    scene.camera.look_at.y, scene.camera.look_at.z));
  return scene;
}

}  // namespace

Result<Scene> load_scene(const std::filesystem::path& file, const Overrides& overrides) {
  auto description = describe(file);
  if (!description) return description.error();
  return build(std::move(*description), file.string(), {file.parent_path()}, overrides);
}

Result<Scene> load_scene(std::span<const unsigned char> text, const std::string& name,
                         const std::filesystem::path& folder, FilesInMemory files, const Overrides& overrides) {
  auto description = parse_scene_file(text, name);
  if (!description) return description.error();
  return build(std::move(*description), name, {folder, std::move(files)}, overrides);
}

}  // namespace tress::scene
