// Grooms and meshes of a scene from their files, at the moments of the shutter.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scene/model/scene.h"
#include "scene/read/load_scene.h"
#include "scene/read/scene_file.h"
#include "tress/base/error.h"

namespace tress::scene {

/// Where what a scene names as files comes from: memory first, else relative to a folder.
struct Sources {
  std::filesystem::path folder;
  FilesInMemory memory = {};
};

struct FrameMoments {
  /// At which objects are looked up, at least one: that of the picture where the shutter is closed, else those of its
  /// moments.
  std::vector<double> frames;
  bool is_asked = false;  ///< by a frame or an open shutter; else animated files give their first samples
  std::optional<double> frames_per_second = {};
};

/// Where an object is at each of the moments.
std::vector<ObjectTransform> transforms(const ObjectPath& path, const FrameMoments& moments);

/// In the world. A name with #### stands for a file a frame, linear between two of them. Fails where the strands of one
/// are not those of the others: as many, with as many points each, in the same order or, where all files have an id for
/// each strand, with the same ids.
Result<Groom> make_groom(const GroomDescription& description, const FrameMoments& moments, Sources& from, Scene* scene);

/// In the world, likewise; the files of the frames must have the same faces.
Result<Mesh> make_mesh(const MeshDescription& description, const FrameMoments& moments, const Sources& from,
                       Scene* scene);

}  // namespace tress::scene
