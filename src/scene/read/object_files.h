// Makes grooms and meshes of a scene from their files, at the moments of the shutter.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scene/model/scene.h"
#include "scene/read/load_scene.h"
#include "scene/read/scene_file.h"
#include "tress/base/error.h"

namespace tress::scene {

/// The sources of a scene's files: memory first, else relative to a folder.
struct Sources {
  std::filesystem::path folder;
  FilesInMemory memory = {};
};

struct FrameMoments {
  /// The frames at which objects are evaluated, at least one: that of the picture if the shutter is closed, else those
  /// of its moments.
  std::vector<double> frames;
  bool is_asked = false;  ///< by a frame or an open shutter; otherwise animated files give their first samples
  std::optional<double> frames_per_second = {};
  glm::dvec3 origin{0.0};  ///< Scene::origin
};

/// The placements of an object at each of the moments.
std::vector<ObjectTransform> transforms(const ObjectPath& path, const FrameMoments& moments);

/// Makes a groom in the world: one, or one for each set of strands that its file shares between instances. A name with
/// #### stands for one file a frame, interpolated linearly between two of them. Fails if the strands of the files
/// differ: they must be as many, with as many points each, in the same order or, if all files have an id for each
/// strand, with the same ids.
Result<std::vector<Groom>> make_grooms(const GroomDescription& description, const FrameMoments& moments, Sources& from,
                                       Scene* scene);

/// Makes a mesh in the world in the same way; the files of the frames must have the same faces.
Result<Mesh> make_mesh(const MeshDescription& description, const FrameMoments& moments, const Sources& from,
                       Scene* scene);

}  // namespace tress::scene
