// A folder of parts as a scene: hair, brows, beard and the head they grow on, each in a file.
#pragma once

#include <filesystem>

#include "scene/read/load_scene.h"
#include "scene/read/scene_file.h"

namespace tress::scene {

/// Describes the scene of a folder. Every file of strands in it is a groom and every .obj a mesh, in the order of their
/// names; anything else, including folders, is ignored. A groom has the material of materials.json (an array, like
/// "materials" of a scene) whose name is the file's without its ending, else the first one, else brown hair. All share
/// one unit and one up axis, those of each file, else 1 cm and z, unless `overrides` set others, also for meshes. Paths
/// are relative to the folder. Fails if there is no groom.
Result<SceneDescription> describe_parts(const std::filesystem::path& folder, const Overrides& overrides);

}  // namespace tress::scene
