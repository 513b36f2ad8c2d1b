// What options make of the materials and the light of a scene.
#pragma once

#include <optional>
#include <vector>

#include "scene/model/scene.h"
#include "scene/read/overrides.h"

namespace tress::scene {

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

/// To a scene whose materials and light are as its file has them: their look, and the fibers of all strands.
std::optional<Error> apply_look(const Overrides& overrides, Scene* scene);

}  // namespace tress::scene
