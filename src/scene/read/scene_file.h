// The scene JSON file, read and checked but with nothing loaded yet (scenes/README.md).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene/model/camera_motion.h"
#include "scene/model/scene.h"
#include "scene/read/environment_reader.h"
#include "scene/read/groom_reader.h"
#include "scene/read/json_reader.h"
#include "scene/read/mesh_reader.h"

namespace tress::scene {

struct SceneDescription {
  CameraDescription camera;
  Image image;
  EnvironmentDescription environment;
  bool environment_visible = true;
  std::vector<Light> lights;
  std::vector<MeshDescription> meshes;
  std::vector<Material> materials;
  std::vector<GroomDescription> grooms;
};

/// Errors name the JSON path, or the byte where the text is not JSON. Every value of the result is in range. `keys`,
/// where given, gets the keys that each object of the document may have.
Result<SceneDescription> parse_scene_file(std::span<const unsigned char> text, const std::string& name,
                                          KnownKeys* keys = nullptr);

}  // namespace tress::scene
