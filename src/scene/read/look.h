// Applies options to the materials and the light of a scene.
#pragma once

#include <optional>
#include <vector>

#include "scene/model/scene.h"
#include "scene/read/overrides.h"

namespace tress::scene {

/// The parts of a scene before the overrides change them.
struct Unstyled {
  std::vector<Material> materials;
  std::vector<Light> lights;
  Environment environment;
};

/// Gives a scene the look of the overrides: its materials, fibers and light, as if it had been loaded with them, to the
/// bit. unstyled: of the same scene. All other overrides are ignored. Errors are those of load_scene, a value out of
/// range or those of assign_fibers; the scene is then half changed.
std::optional<Error> restyle(const Unstyled& unstyled, const Overrides& overrides, Scene* scene);

/// Applies the look to a scene whose materials and light are as its file has them, and assigns the fibers of all
/// strands.
std::optional<Error> apply_look(const Overrides& overrides, Scene* scene);

}  // namespace tress::scene
