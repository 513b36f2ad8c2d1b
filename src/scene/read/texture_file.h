// Textures of meshes and of the roots of strands.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "scene/model/texture.h"
#include "tress/base/error.h"

namespace tress::scene {

/// The tiles of a name with <UDIM> that exist, by their numbers; empty for another name.
std::map<int, std::filesystem::path> udim_files(const std::filesystem::path& file);

/// Loads a color picture: PNG, whose values are sRGB, or OpenEXR with linear R, G, B, detected by its first bytes. At
/// most 2^26 pixels. Values outside [0, 1] are clamped, with a warning, because an albedo is a share. A name with
/// <UDIM> stands for the files that have the number of a tile in its place, of which there must be one.
Result<Texture> load_texture(const std::filesystem::path& file, std::vector<std::string>* warnings,
                             bool is_encoded = true);

}  // namespace tress::scene
