// Reads the key "marschner" of a material: RenderMan's PxrMarschnerHair and PxrHairColor, in their own names and
// numbers.
#pragma once

#include "scene/read/json_reader.h"
#include "scene/read/scene_file.h"

namespace tress::scene {

/// Fills the fiber, the absorption and the presence of a material that has the key; other keys of the material with the
/// same purpose are errors beside it. What fibers cannot do is named in material->left_out.
///
/// Cone angles are taken as standard deviations of theta_h: that of R, s, makes the roughness sqrt(2) s, and each makes
/// the lambda of its lobe. specularGlintWidth is the blur of TRT in azimuth. Colors are the lobes' tints, over clear
/// fibers; with "hair_color" the fibers have its melanin (eumelanin) instead, or the absorption of a lock of its color.
/// The node has no lobes after TRT, and their gain is 0.
void read_marschner(const JsonReader& material_json, Material* material);

}  // namespace tress::scene
