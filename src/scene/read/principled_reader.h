// Reads the keys "principled" and "chiang_hair_bsdf" of a material: the hair of other renderers' nodes, in the nodes'
// own numbers.
#pragma once

#include "scene/read/json_reader.h"
#include "scene/read/scene_file.h"

namespace tress::scene {

/// Whether `node`, a key of the material, is the only one that describes its fiber; false and an error otherwise.
bool is_alone(const JsonReader& material_json, const char* node);

/// Fills the fiber and the variation of a material that has the key; other keys of the material with the same purpose
/// are errors beside it.
void read_principled(const JsonReader& material_json, Material* material);

/// The same for "chiang_hair_bsdf", MaterialX's node.
void read_chiang_hair_bsdf(const JsonReader& material_json, Material* material);

}  // namespace tress::scene
