#include "scene/read/load_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/ext/vector_double3.hpp>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

#include "base/numbered_file.h"
#include "scene/generate/generated_environments.h"
#include "scene/model/camera.h"
#include "scene/model/light.h"
#include "scene/model/parameters.h"
#include "scene/model/strand_fibers.h"
#include "scene/read/assembly.h"
#include "scene/read/environment_file.h"
#include "scene/read/groom_files.h"
#include "scene/read/groom_looks.h"
#include "scene/read/grooms/groom_formats.h"
#include "scene/read/input_files.h"
#include "scene/read/look.h"
#include "scene/read/object_files.h"
#include "scene/read/parts_folder.h"
#include "scene/read/scene_file.h"
#include "scene/read/texture_file.h"

namespace tress::scene {
namespace {

constexpr std::uintmax_t most_scene_bytes = std::uintmax_t{64} << 20;

/// The scene of a bare file of strands.
Result<SceneDescription> describe_groom(const std::filesystem::path& file, const Overrides& overrides) {
  constexpr std::string_view text = R"({"grooms": [{"file": "-"}]})";  // a path may have bytes that JSON has not
  auto scene = parse_scene_file({reinterpret_cast<const unsigned char*>(text.data()), text.size()}, file.string(),
                                nullptr, overrides.settings);
  if (!scene) return scene;
  GroomDescription& groom = scene->grooms[0];
  if (groom.file == "-" && file != "-") groom.file = std::filesystem::absolute(file).string();
  groom.placement.guess_up = !groom.placement.y_up;
  return scene;
}

std::optional<Error> apply(const Overrides& overrides, SceneDescription* scene) {
  if (auto error = fault_of(overrides)) return error;
  for (auto& groom : scene->grooms) {
    if (!groom.file) continue;
    if (overrides.y_up) groom.placement.y_up = *overrides.y_up;
    groom.placement.strict = overrides.strict;
    if (overrides.cm_per_unit) groom.placement.cm_per_unit = *overrides.cm_per_unit;
    if (overrides.radius_cm) groom.placement.radius_cm = *overrides.radius_cm;
    if (overrides.widths) {
      groom.placement.widths = *width_use_of(*overrides.widths);
      groom.placement.radius_cm = overrides.radius_cm;
    }
  }
  const Shutter& shutter = scene->camera.shutter;
  if (shutter.close < shutter.open)
    return Error{"", "/camera/shutter", "a shutter that closes after it has opened",
                 fmt::format("one that opens at {:g} and closes at {:g}", shutter.open, shutter.close)};
  auto& image = scene->image;
  image.width = overrides.width.value_or(image.width);
  image.height = overrides.height.value_or(image.height);
  image.samples = overrides.samples.value_or(image.samples);
  const std::int64_t pixels = std::int64_t{image.width} * image.height;
  if (pixels > most_image_pixels)
    return Error{"", "--resolution", fmt::format("at most {} pixels", most_image_pixels), fmt::format("{}", pixels)};
  return std::nullopt;
}

/// Makes the environment at a frame.
Result<Environment> make_environment(const EnvironmentDescription& description, double frame, Sources& from,
                                     Scene* scene) {
  using Kind = EnvironmentDescription::Kind;
  const double rotate_rad = description.turn_at(frame) * std::numbers::pi / 180;
  if (description.kind == Kind::constant) return Environment(description.constant * description.scale);
  if (description.kind == Kind::studio) return studio_environment(rotate_rad, description.scale);
  if (description.kind == Kind::sky) return gradient_environment(description.sky, description.scale);
  if (const auto found = from.memory.environments.find(description.file); found != from.memory.environments.end())
    return make_environment(std::move(found->second), description.file, rotate_rad, description.scale,
                            &scene->warnings);
  return load_environment(from.folder / description.file, rotate_rad, description.scale, &scene->warnings);
}

/// Its rotation at the moments relative to the first of them; empty if it rests.
std::vector<float> environment_turns(const EnvironmentDescription& description, const FrameMoments& moments) {
  const double first = description.turn_at(moments.frames.front());
  std::vector<float> turns;
  for (const double frame : moments.frames)
    turns.push_back(static_cast<float>((description.turn_at(frame) - first) * std::numbers::pi / 180));
  if (std::ranges::all_of(turns, [](float turn) { return turn == 0; })) turns.clear();
  return turns;
}

/// Reads the textures of sources.
std::optional<Error> load_textures(const Sources& from, std::vector<std::string>* warnings, Source* source) {
  if (source->kind == Source::Kind::texture) {
    auto texture = load_texture(from.folder / source->file, warnings, source->is_encoded);
    if (!texture) return texture.error();
    source->texture = std::make_shared<const Texture>(std::move(*texture));
  }
  for (Source& part : source->parts)
    if (auto error = load_textures(from, warnings, &part)) return error;
  return std::nullopt;
}

/// The error for a groom with roots that have no place on the textures of its materials and of their shares.
std::optional<Error> fault_of_roots(const Groom& groom, const std::vector<GroomLook>& looks,
                                    const std::vector<Material>& materials) {
  std::optional<Error> fault;
  const auto ask = [&](const Source& source, const std::string& user) {
    source.for_each_texture([&](const Texture& texture) {
      const auto missing = std::ranges::find_if(groom.root_uv, [&](const glm::vec2& uv) { return !texture.is_at(uv); });
      if (fault || (!groom.root_uv.empty() && missing == groom.root_uv.end())) return;
      fault = Error{groom.name, "root uv", "those of its strands, for the texture of " + user, "none"};
      if (groom.root_uv.empty()) return;
      std::vector<int> tiles;
      for (const auto& [number, tile] : texture.tiles()) tiles.push_back(number);
      fault->expected = fmt::format("places on the tiles {} of the texture of {}", fmt::join(tiles, ", "), user);
      fault->found = fmt::format("({:g}, {:g})", missing->x, missing->y);
    });
  };
  const auto ask_material = [&](const Material& material) {
    for_each_source(material, [&](const Source& source) { ask(source, "\"" + material.name + "\""); });
  };
  ask_material(materials[groom.material]);
  for (const GroomLook& look : looks) {
    ask_material(materials[look.material]);
    ask(look.share, "the share of \"" + materials[look.material].name + "\"");
  }
  return fault;
}

/// Makes the lights of the scene, including the sun of its sky.
Result<std::vector<Light>> make_lights(const SceneDescription& description, const FrameMoments& moments,
                                       const std::string& name) {
  std::vector<Light> lights;
  for (const auto& [light, path] : description.lights) {
    lights.push_back(light);
    const std::string place = fmt::format("/lights/{}", lights.size() - 1);
    if (auto error = move_light(transforms(path, moments), name, place, &lights.back())) return *error;
  }
  const auto sun_at = [&](double frame) {
    return sun_of(description.environment, description.environment.turn_at(frame));
  };
  if (auto sun = sun_at(moments.frames.front())) {
    if (!environment_turns(description.environment, moments).empty())
      for (const double frame : std::span(moments.frames).subspan(1)) sun->later.push_back(*sun_at(frame));
    lights.push_back(std::move(*sun));
  }
  return lights;
}

/// The name of an object in mattes: the scene's, else `usual`, with a number if another object has it.
std::string object_name(const std::optional<std::string>& name, const std::string& usual,
                        const std::set<std::string>& taken) {
  if (name) return *name;
  std::string free = usual;
  for (int number = 2; taken.contains(free); ++number) free = fmt::format("{} {}", usual, number);
  return free;
}

/// The error for a light whose links name what is not among the objects.
std::optional<Error> fault_of_links(const SceneDescription& description, const std::set<std::string>& objects,
                                    const std::string& file) {
  std::optional<Error> fault;
  const auto check = [&](const ObjectList& list, const std::string& place) {
    for (std::size_t i = 0; i < list.names.size() && !fault; ++i) {
      if (objects.contains(list.names[i])) continue;
      const std::vector<std::string> known(objects.begin(), objects.end());
      const std::size_t shown = std::min<std::size_t>(known.size(), 16);
      fault = Error{file, fmt::format("{}/{}/{}", place, list.is_only ? "include" : "exclude", i),
                    fmt::format("the name of a groom or mesh (the nearest is \"{}\"; there are \"{}\"{})",
                                nearest_name(list.names[i], known), fmt::join(std::span(known).first(shown), "\", \""),
                                shown < known.size() ? ", ..." : ""),
                    "\"" + list.names[i].substr(0, 64) + "\""};
    }
  };
  const auto check_both = [&](const LightLinks& links, const std::string& place) {
    check(links.lit, place + "/light_link");
    check(links.blocking, place + "/shadow_link");
  };
  check_both(description.environment.links, "/environment");
  for (std::size_t i = 0; i < description.lights.size(); ++i)
    check_both(description.lights[i].light.links, fmt::format("/lights/{}", i));
  return fault;
}

/// Places the moving parts of a scene.
class Motion {
 public:
  Motion(const SceneDescription& description, std::optional<int> frame, const std::string& name,
         const glm::dvec3& origin)
      : camera_(description.camera),
        environment_(description.environment),
        shutter_(description.camera.shutter),
        name_(name),
        frame_(frame.value_or(camera_.keys.empty() ? 0 : camera_.keys.front().frame)) {
    moments_.origin = origin;
    for (int i = 0; i < (shutter_.is_open() ? shutter_.samples : 1); ++i)
      moments_.frames.push_back(shutter_.is_open() ? frame_ + shutter_.moment(i) : frame_);
    moments_.is_asked = frame || shutter_.is_open();
    moments_.frames_per_second = camera_.frames_per_second;
  }

  const FrameMoments& moments() const { return moments_; }

  /// Places the camera of the picture, and its moments while the shutter is open.
  std::optional<Error> place_camera(Scene* scene) const {
    const auto camera = camera_at(camera_, frame_, scene->grooms, scene->image, name_);
    if (!camera) return camera.error();
    scene->camera = *camera;
    scene->shutter = shutter_;
    auto moments = cameras_of(0, *scene);
    if (!moments) return moments.error();
    scene->camera_moments = std::move(*moments);
    return std::nullopt;
  }

  /// Places the camera of the next frame. If it cannot be placed there, it is taken to rest, with a warning.
  void look_ahead(Scene* scene) const {
    const double turn_deg = environment_.turn_at(frame_ + 1) - environment_.turn_at(frame_);
    if (!camera_moves() && !objects_move(*scene) && turn_deg == 0) return;
    const auto next = camera_at(camera_, frame_ + 1, scene->grooms, scene->image, name_);
    auto moments = cameras_of(1, *scene);
    for (const auto* error : {next ? nullptr : &next.error(), moments ? nullptr : &moments.error()})
      if (error != nullptr) {
        scene->warnings.push_back(error->message() + "; the layer forward is 0");
        scene->next = {scene->camera, {}, scene->camera_moments, 0};
        return;
      }
    ObjectTurn turn = object_turn_at(camera_, frame_ + 1, scene->grooms);
    turn.turn_rad -= object_turn_at(camera_, frame_, scene->grooms).turn_rad;
    scene->next = {*next, turn, std::move(*moments), turn_deg * std::numbers::pi / 180};
  }

  void turn_objects(Scene* scene) const {
    std::vector<ObjectTurn> turns;
    for (const double frame : moments_.frames) turns.push_back(object_turn_at(camera_, frame, scene->grooms));
    scene::turn_objects(turns, &scene->grooms, &scene->meshes);
  }

  bool camera_moves() const { return !camera_.keys.empty() || camera_.turntable; }
  static bool objects_move(const Scene& scene) {
    const auto instances_move = [](const Groom& groom) {
      return std::ranges::any_of(groom.instances, [](const Instance& instance) { return !instance.later.empty(); });
    };
    return std::ranges::any_of(scene.grooms, [](const Groom& groom) { return !groom.later.empty(); }) ||
           std::ranges::any_of(scene.grooms, instances_move) ||
           std::ranges::any_of(scene.meshes, [](const Mesh& mesh) { return !mesh.later.empty(); }) ||
           std::ranges::any_of(scene.lights, [](const Light& light) { return light.visible && !light.later.empty(); });
  }

 private:
  /// The cameras at the moments of the shutter, this many frames ahead; empty if the camera rests.
  Result<std::vector<Camera>> cameras_of(int frames_on, const Scene& scene) const {
    std::vector<Camera> cameras;
    const bool moves = !camera_.keys.empty() || (camera_.turntable && camera_.turntable->turns_camera);
    if (!moves || !shutter_.is_open()) return cameras;
    for (const double moment : moments_.frames) {
      const auto camera = camera_at(camera_, moment + frames_on, scene.grooms, scene.image, name_);
      if (!camera) return camera.error();
      cameras.push_back(*camera);
    }
    return cameras;
  }

  const CameraDescription& camera_;
  const EnvironmentDescription& environment_;
  const Shutter& shutter_;
  const std::string& name_;
  int frame_;
  FrameMoments moments_;
};

/// Whether the file may be a JSON scene, which begins with a brace. Other kinds are handled before it is read as JSON.
bool may_be_json(const std::filesystem::path& file, std::span<const unsigned char> start) {
  if (!known_kind_of(start).empty()) return false;
  constexpr std::string_view blanks = " \t\r\n\xef\xbb\xbf";  // including the byte order mark of UTF-8
  const auto first =
      std::ranges::find_if(start, [&](unsigned char c) { return blanks.find(static_cast<char>(c)) == blanks.npos; });
  return file.extension() == ".json" || first == start.end() || *first == '{';
}

bool is_folder(const std::filesystem::path& path) {
  std::error_code unknown;
  return std::filesystem::is_directory(path, unknown);
}

/// The texts for set_keys(). The name of the environment stands in a text of its own, as it may have bytes that JSON
/// has not.
std::vector<std::string> settings_of(const Overrides& overrides) {
  std::vector<std::string> settings = overrides.settings;
  if (overrides.environment_file)
    settings.insert(
        settings.begin(),
        {"environment={}", "environment/file=" + std::filesystem::absolute(*overrides.environment_file).string()});
  return settings;
}

Result<SceneDescription> describe(const std::filesystem::path& file, const Overrides& overrides) {
  std::error_code unknown;
  if (is_folder(file))
    return std::filesystem::exists(file / "scene.json", unknown) ? describe(file / "scene.json", overrides)
                                                                 : describe_parts(file, overrides);

  if (file == "-") return describe_groom(file, overrides);  // standard input
  const std::string wanted = "a scene (JSON) or a groom (" + groom_endings() + ")";
  const auto start = read_file_start(file, wanted, bytes_of_kind);
  if (!start) return start.error();
  if (is_groom_file(file)) return describe_groom(file, overrides);
  if (!may_be_json(file, *start)) return Error{file.string(), "", wanted, kind_of(*start)};
  const auto bytes =
      read_input_file(file, fmt::format("a scene of at most {} bytes", most_scene_bytes), most_scene_bytes);
  if (!bytes) return bytes.error();
  return parse_scene_file(*bytes, file.string(), nullptr, overrides.settings);
}

/// Counts the places of a camera that is far from 0 from a point near it. Returns that point, or 0.
glm::dvec3 bring_near(CameraDescription* camera) {
  constexpr float far_cm = 4096;  ///< floats there are 0.0005 cm apart, an eighth of a hair's radius
  std::optional<glm::vec3> seen;
  if (!camera->keys.empty())
    seen = camera->keys.front().camera.look_at;
  else if (camera->turntable)
    seen = camera->turntable->look_at;
  else if (!camera->framed)
    seen = camera->camera.look_at;
  if (!seen || glm::length(*seen) < far_cm) return glm::dvec3(0.0);
  const glm::vec3 origin = glm::round(*seen);
  const auto shift = [&](glm::vec3& point) { point = glm::vec3(glm::dvec3(point) - glm::dvec3(origin)); };
  const auto shift_view = [&](Camera& view) {
    shift(view.eye);
    shift(view.look_at);
  };
  shift_view(camera->camera);
  for (CameraKey& key : camera->keys) shift_view(key.camera);
  if (camera->turntable && camera->turntable->look_at) shift(*camera->turntable->look_at);
  if (camera->lens.focus_point) shift(*camera->lens.focus_point);
  return glm::dvec3(origin);
}

/// Whether some frames differ from others.
bool moves(const SceneDescription& description) {
  const auto has_keys = [](const auto& object) { return !object.path.keys.empty(); };
  return !description.camera.keys.empty() || description.camera.turntable || !description.environment.keys.empty() ||
         std::ranges::any_of(description.lights, has_keys) ||
         std::ranges::any_of(description.grooms,
                             [&](const auto& groom) {
                               return has_keys(groom) || names_frames(groom.file.value_or("")) ||
                                      std::ranges::any_of(groom.instances,
                                                          [](const ObjectPath& path) { return !path.keys.empty(); });
                             }) ||
         std::ranges::any_of(description.meshes,
                             [&](const auto& mesh) { return has_keys(mesh) || names_frames(mesh.file); });
}

/// Warns of hair that is hardly visible, usually because of a wrong unit or width. Strands cover less than a pixel of
/// 50,000 of the picture, or less than a hundredth of it and more than a tenth of them are thinner than a tenth of a
/// pixel. It checks up to 2000 strands per groom.
void warn_of_thin_strands(Scene* scene) {
  constexpr std::uint32_t most_measured = 2000;
  const Camera& camera = scene->camera;
  const glm::dvec3 eye(camera.eye), along = glm::normalize(glm::dvec3(camera.look_at) - eye);
  const double half = std::tan(camera.vertical_fov_deg / 2 * std::numbers::pi / 180);
  double covered = 0, thin = 0, strands = 0;
  for (const Groom& groom : scene->grooms) {
    const std::size_t all = std::size_t{groom.strand_count()} * groom.times(), step = all / most_measured + 1;
    for (std::size_t i = 0; i < all; i += step) {
      const auto s = static_cast<std::uint32_t>(i % groom.strand_count());
      const Similarity place = groom.place(i / groom.strand_count());
      const std::uint32_t begin = groom.first_point[s], end = groom.first_point[s + 1];
      const double depth = glm::dot(glm::dvec3(place.point(groom.points[(begin + end) / 2])) - eye, along);
      const double high = camera.orthographic_height_cm > 0 ? double{camera.orthographic_height_cm} : 2 * half * depth;
      if (!(high > 0)) continue;
      double length = 0, radius = 0;
      for (std::uint32_t at = begin; at < end; ++at) {
        if (at > begin) length += glm::distance(groom.points[at - 1], groom.points[at]);
        radius = std::max(radius, double{groom.radius_cm[at]});
      }
      length *= double{place.scale};
      radius *= double{place.scale};
      const double pixel = high / scene->image.height;
      covered += static_cast<double>(step) * std::min(length, high) / pixel * (2 * radius / pixel);
      strands += static_cast<double>(step);
      if (2 * radius < 0.1 * pixel) thin += static_cast<double>(step);
    }
  }
  covered /= double(scene->image.width) * scene->image.height;
  if (strands == 0 || !(covered < 2e-5 || (covered < 0.01 && thin > 0.1 * strands))) return;
  scene->warnings.push_back(fmt::format(
      "the picture is all but empty: strands cover some {:.2g} % of it, and {:.0f} of {:.0f} are thinner than "
      "a tenth of a pixel; `cm_per_unit`, `widths` or `radius_cm` of the groom may be what is wrong",
      100 * covered, thin, strands));
}

/// Builds the scene of a description. `name`: the file that it was loaded from.
Result<Scene> build(SceneDescription description, const std::string& name, Sources from, const Overrides& overrides,
                    Unstyled* unstyled) {
  if (auto error = apply(overrides, &description)) return *error;

  Scene scene;
  scene.source = name;
  scene.image = description.image;
  scene.integrator = description.integrator;
  scene.environment_visible = description.environment_visible;
  scene.environment_group = description.environment.group;
  scene.environment_links = description.environment.links;
  scene.materials = std::move(description.materials);
  std::optional<Error> fault;
  for (const Material& material : scene.materials)
    if (!material.left_out.empty())
      scene.warnings.push_back(fmt::format("material {}: left out, as fibers have nothing of the kind: {}",
                                           material.name, fmt::join(material.left_out, ", ")));
  for (Material& material : scene.materials)
    for_each_source(material, [&](Source& source) {
      if (!fault) fault = load_textures(from, &scene.warnings, &source);
    });
  if (fault) return *fault;
  scene.origin = bring_near(&description.camera);
  const Motion motion(description, overrides.frame, name, scene.origin);
  auto lights = make_lights(description, motion.moments(), name);
  if (!lights) return lights.error();
  scene.lights = std::move(*lights);
  auto environment = make_environment(description.environment, motion.moments().frames.front(), from, &scene);
  if (!environment) return environment.error();
  scene.environment = std::move(*environment);
  scene.environment_turns_rad = environment_turns(description.environment, motion.moments());
  std::set<std::string> taken;  // names of objects
  for (const auto& mesh_description : description.meshes) {
    auto mesh = make_mesh(mesh_description, motion.moments(), from, &scene);
    if (!mesh) return mesh.error();
    mesh->object =
        object_name(mesh_description.name, std::filesystem::path(mesh_description.file).stem().string(), taken);
    taken.insert(mesh->object);
    if (!mesh->triangles.empty()) scene.meshes.push_back(std::move(*mesh));
  }
  for (auto& groom_description : description.grooms) {
    for (GroomLook& look : groom_description.looks)
      if (auto error = load_textures(from, &scene.warnings, &look.share)) return *error;
    auto grooms = make_grooms(groom_description, motion.moments(), from, &scene);
    if (!grooms) return grooms.error();
    const std::string usual = groom_description.file ? std::filesystem::path(*groom_description.file).stem().string()
                                                     : groom_description.recipe.kind;
    const std::string object = object_name(groom_description.name, usual, taken);
    taken.insert(object);
    for (Groom& groom : *grooms) {
      groom.object = object;
      groom.visibility = groom_description.visibility;
      apply_taper(groom_description.taper, &groom);
      groom.material = groom_description.material;
      if (auto error = fault_of_roots(groom, groom_description.looks, scene.materials)) return *error;
      if (groom.strand_count() == 0)
        scene.warnings.push_back(groom.name + ": no strand is left to draw");
      else
        for (Groom& part : divided(std::move(groom), groom_description.looks)) {
          apply_thickness(scene.materials[part.material], &part);
          scene.grooms.push_back(std::move(part));
        }
    }
  }
  if (auto error = fault_of_links(description, taken, name)) return *error;
  if (unstyled != nullptr) *unstyled = {scene.materials, scene.lights, scene.environment};
  if (auto error = apply_look(overrides, &scene)) return *error;
  if (auto error = motion.place_camera(&scene)) return *error;
  warn_of_thin_strands(&scene);
  motion.look_ahead(&scene);
  motion.turn_objects(&scene);
  if (const std::size_t groups = light_groups(scene).size(); groups > most_light_groups)
    return Error{name, "/lights", fmt::format("at most {} groups of light", most_light_groups),
                 fmt::format("{}", groups)};
  const bool has_samples = std::ranges::any_of(scene.grooms, [](const Groom& groom) { return groom.is_animated; });
  if (overrides.frame && !moves(description) && !has_samples)
    scene.notes.push_back(
        fmt::format("{}: neither the camera nor an object moves, every frame is the same but for its grain", name));
  if (description.camera.framed && !scene.grooms.empty())
    scene.notes.push_back(
        fmt::format("camera framed on the hair: eye ({:.2f}, {:.2f}, {:.2f}), look_at ({:.2f}, {:.2f}, {:.2f})",
                    scene.camera.eye.x, scene.camera.eye.y, scene.camera.eye.z, scene.camera.look_at.x,
                    scene.camera.look_at.y, scene.camera.look_at.z));
  return scene;
}

}  // namespace

Result<Scene> load_scene(const std::filesystem::path& file, const Overrides& overrides, Unstyled* unstyled) {
  Overrides all = overrides;
  all.settings = settings_of(overrides);
  auto description = describe(file, all);
  if (!description) return description.error();
  return build(std::move(*description), file.string(), {is_folder(file) ? file : file.parent_path()}, overrides,
               unstyled);
}

Result<Scene> load_scene(std::span<const unsigned char> text, const std::string& name,
                         const std::filesystem::path& folder, FilesInMemory files, const Overrides& overrides) {
  auto description = parse_scene_file(text, name, nullptr, settings_of(overrides));
  if (!description) return description.error();
  return build(std::move(*description), name, {folder, std::move(files)}, overrides, nullptr);
}

}  // namespace tress::scene
