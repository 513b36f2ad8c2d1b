// Meshes of a scene file: what they are said to be, and how they come into the world.
#pragma once

#include <string>
#include <vector>

#include "scene/model/scene.h"
#include "scene/read/json_reader.h"
#include "scene/read/obj_file.h"

namespace tress::scene {

struct MeshDescription {
  std::string file;           ///< as written
  bool y_up = false;          ///< y of the file becomes z, its z becomes -y
  double cm_per_unit = 1;     ///< before translation
  glm::vec3 translate{0.0f};  ///< cm, in the world's axes
  glm::vec3 albedo = Mesh{}.albedo;
};

/// One element of /meshes.
MeshDescription read_mesh(const JsonReader& json);

/// The mesh in the world. Triangles without area are left out, which is a warning. Fails where the placed mesh leaves a
/// world of 10^6 cm. `name` is the file.
Result<Mesh> place_mesh(const ObjFile& file, const MeshDescription& description, const std::string& name,
                        std::vector<std::string>* warnings);

}  // namespace tress::scene
