// The packets of tev's protocol, which HDRView reads too: little endian, the length of the whole packet first. The
// viewer never answers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/picture.h"

namespace tress::live {

/// A new image of this size; one of that name is replaced.
std::string create_image_packet(const std::string& name, int width, int height,
                                const std::vector<std::string>& channels);

/// The pixels of `tile` of some channels (type 5, planar). channels: of one size, `width` pixels across, which has the
/// tile inside.
std::string update_image_packet(const std::string& name, const std::vector<const image::Channel*>& channels, int width,
                                const image::Window& tile);

/// The channels of a picture by layer, in its order: what one packet has, so that no color is seen without the others.
std::vector<std::vector<const image::Channel*>> channels_by_layer(const image::Picture& picture);

/// 128 pixels a side, fewer at the right and lower edge, row by row.
std::vector<image::Window> tiles_of(int width, int height);

/// Of the tile's pixels in these channels, to tell whether they have changed.
std::uint64_t tile_hash(const std::vector<const image::Channel*>& channels, int width, const image::Window& tile);

}  // namespace tress::live
