// Loads files into a scene.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "scene/model/scene.h"
#include "scene/read/environment_file.h"
#include "scene/read/grooms/groom_file.h"
#include "scene/read/input_files.h"
#include "scene/read/look.h"
#include "scene/read/obj_file.h"
#include "scene/read/overrides.h"
#include "tress/base/error.h"

namespace tress::scene {

/// Loads a scene JSON file, a bare file of strands (groom_files.h), or a folder: the scene.json in it, or else its
/// parts (parts_folder.h). Errors name the file and the JSON path or byte. unstyled: filled for restyle(); may be null.
Result<Scene> load_scene(const std::filesystem::path& file, const Overrides& overrides = {},
                         Unstyled* unstyled = nullptr);

/// Data in the host's memory that replace files, by the names that stand for files in its scene. They must be valid as
/// results of the readers of such files: their guarantees are a precondition.
struct FilesInMemory {
  std::map<std::string, GroomFile> grooms;
  std::map<std::string, ObjFile> meshes;
  std::map<std::string, HdrPicture> environments;
};

/// Loads a scene from a JSON text. Its file names are looked up first in `files`, then relative to `folder`. `name` is
/// its name in errors and in Scene::source. Strands are moved out of `files` the first time that they are named.
Result<Scene> load_scene(std::span<const unsigned char> text, const std::string& name,
                         const std::filesystem::path& folder, FilesInMemory files, const Overrides& overrides = {});

}  // namespace tress::scene
