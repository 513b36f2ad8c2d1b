// Files into a scene.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "scene/model/scene.h"
#include "scene/read/grooms/groom_file.h"
#include "scene/read/input_files.h"
#include "scene/read/look.h"
#include "scene/read/overrides.h"
#include "tress/base/error.h"

namespace tress::scene {

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
