// Files into a scene.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scene/model/scene.h"
#include "scene/read/grooms/groom_file.h"
#include "scene/read/input_files.h"
#include "tress/base/error.h"

namespace tress::scene {

/// What the command line sets over the scene.
struct Overrides {
  std::optional<std::string> environment_file = {};
  std::optional<double> environment_rotate_deg = {};
  std::optional<glm::vec3> color = {};
  std::optional<std::pair<float, float>> melanin = {};
  std::optional<glm::vec3> sigma_a = {};
  std::optional<std::string> hair = {};  ///< of hair_color_names()
  std::optional<float> eccentricity = {}, roughness = {};
  std::optional<double> tilt_deg = {};     ///< of the cuticle scales
  std::optional<double> light_scale = {};  ///< of the environment and every light
  std::optional<bool> y_up = {};
  std::optional<double> cm_per_unit = {};
  std::optional<int> width = {}, height = {}, samples = {};
  std::optional<bool> transparent = {};
  std::optional<double> exposure_stops = {};
  std::optional<image::View> view = {};
  std::optional<int> frame = {};                          ///< of what moves
  std::optional<std::pair<double, double>> shutter = {};  ///< when it opens and closes, frames from that one on
  std::optional<int> motion_samples = {};
  std::optional<double> frames_per_second = {};
  std::optional<double> turn_deg = {};  ///< of a camera that is placed to see the hair
};

/// What a scene has before the look that the overrides give it.
struct Unstyled {
  std::vector<Material> materials;
  std::vector<Light> lights;
  Environment environment;
};

/// Gives a scene the look of the overrides: its materials, fibers and light, as if it had been loaded with them, to the
/// bit. unstyled: of the same scene. All other overrides are left aside. Error as of load_scene, out of a range or of
/// assign_fibers: the scene is then half changed.
std::optional<Error> restyle(const Unstyled& unstyled, const Overrides& overrides, Scene* scene);

/// A scene JSON file, a bare file of strands (groom_files.h), or a folder: the scene.json in it, else its parts
/// (parts_folder.h). Errors name the file and the JSON path or byte. unstyled: filled for restyle(); null: nobody asks.
Result<Scene> load_scene(const std::filesystem::path& file, const Overrides& overrides = {},
                         Unstyled* unstyled = nullptr);

/// What a host has in memory in place of files, by the names that stand for files in its scene. As the readers of such
/// files would have made them: what these promise is a precondition.
struct FilesInMemory {
  std::map<std::string, GroomFile> grooms;
  std::map<std::string, ObjFile> meshes;
  std::map<std::string, HdrPicture> environments;
};

/// A scene that is no file: the text of one (JSON), whose file names are first those of `files`, then relative to
/// `folder`. `name` is what errors call it and Scene::source has. Strands are moved out of `files`, the first time that
/// they are named.
Result<Scene> load_scene(std::span<const unsigned char> text, const std::string& name,
                         const std::filesystem::path& folder, FilesInMemory files, const Overrides& overrides = {});

}  // namespace tress::scene
