// The scene JSON file and its parts, read and checked, with no other file loaded yet (scenes/KEYS.md).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene/generate/generated_environments.h"
#include "scene/model/camera.h"
#include "scene/model/scene.h"
#include "scene/read/assembly.h"
#include "scene/read/groom_reader.h"
#include "scene/read/json_reader.h"
#include "scene/read/light_reader.h"
#include "tress/base/error.h"

namespace tress::scene {

struct TurnKey {
  int frame = 0;
  double rotate_deg = 0;
};

struct EnvironmentDescription {
  enum class Kind { studio, constant, file, sky } kind = Kind::studio;
  std::string file;  ///< as written
  glm::vec3 constant{1.0f};
  GradientSky sky;
  std::optional<Light> sun;  ///< sun of the sky: a distant light, before rotation and scale
  double rotate_deg = 0;
  std::vector<TurnKey> keys;  ///< if there are any, they replace `rotate_deg`
  float scale = 1;
  std::string group;  ///< the Light::group of it and its sun
  LightLinks links;   ///< the Light::links of both

  /// The rotation in degrees, linear between keys and constant before and after them.
  double turn_at(double frame) const;
};

struct SceneDescription {
  CameraDescription camera;
  Image image;
  Integrator integrator;
  EnvironmentDescription environment;
  bool environment_visible = true;
  std::vector<LightDescription> lights;
  std::vector<MeshDescription> meshes;
  std::vector<Material> materials;
  std::vector<GroomDescription> grooms;
};

/// Parses a scene file. Errors name the JSON path, or the byte if the text is not JSON. Every value of the result is in
/// range. `keys`, if given, gets the keys that each object of the document may have. settings: texts for
/// parse_setting(), which are set in the document first; errors of their values name them.
Result<SceneDescription> parse_scene_file(std::span<const unsigned char> text, const std::string& name,
                                          KnownKeys* keys = nullptr, std::span<const std::string> settings = {});

/// Checks that frame numbers rise: sets the error if `frame` is not after `before`, the key before it.
void check_rising(const JsonReader& key, int frame, std::optional<int> before);

constexpr std::size_t most_keys = 100'000;  ///< most keyframes of anything that moves

// The readers of its parts. Each takes the value of its key; an error becomes the error of the document.

CameraDescription read_camera(const JsonReader& json);
EnvironmentDescription read_environment(const JsonReader& json);

/// The sun as a light of the scene: scaled with its sky and turned by `rotate_deg` with it.
std::optional<Light> sun_of(const EnvironmentDescription& environment, double rotate_deg);

/// The keys of a groom or a mesh that hide it from rays.
Visibility read_visibility(const JsonReader& json);

/// Reads the scale, rotation and place of a groom, a mesh or a light, and its keyframes.
ObjectPath read_path(const JsonReader& json);

/// Reads one element of /meshes.
MeshDescription read_mesh(const JsonReader& json);

}  // namespace tress::scene
