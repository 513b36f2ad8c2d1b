// The packets of tev's protocol, which HDRView also supports: little endian, starting with the length of the whole
// packet. The viewer never answers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/picture.h"

namespace tress::live {

/// Creates an image of this size; one of the same name is replaced.
std::string create_image_packet(const std::string& name, int width, int height,
                                const std::vector<std::string>& channels);

/// Updates the pixels of `tile` in some channels (type 5, planar). channels: all of one size, `width` pixels across,
/// which contains the tile.
std::string update_image_packet(const std::string& name, const std::vector<const image::Channel*>& channels, int width,
                                const image::Window& tile);

/// The channels of a picture by layer, in its order. One packet has one layer, so that no color channel is shown
/// without the others.
std::vector<std::vector<const image::Channel*>> channels_by_layer(const image::Picture& picture);

/// Tiles of 128 pixels a side, smaller at the right and lower edge, row by row.
std::vector<image::Window> tiles_of(int width, int height);

/// Hash of the tile's pixels in these channels, to detect changes.
std::uint64_t tile_hash(const std::vector<const image::Channel*>& channels, int width, const image::Window& tile);

}  // namespace tress::live
