// A folder of parts as a scene: hair, brows, beard and the head they grow on, each a file.
#pragma once

#include <filesystem>

#include "scene/read/load_scene.h"
#include "scene/read/scene_file.h"

namespace tress::scene {

/// Every file of strands in the folder is a groom and every .obj a mesh, in the order of their names; what else is
/// there is let be, folders too. Grooms have the material of materials.json (an array, as "materials" of a scene) that
/// is named as the file without its ending, else the first, else brown hair. All share one unit and one axis: what a
/// file says of itself, else 1 cm and z, unless `overrides` say otherwise, for meshes too. Paths are relative to the
/// folder. Fails where there is no groom.
Result<SceneDescription> describe_parts(const std::filesystem::path& folder, const Overrides& overrides);

}  // namespace tress::scene
