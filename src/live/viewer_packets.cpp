#include "live/viewer_packets.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <map>
#include <string_view>

#include "base/content_hash.h"

namespace tress::live {
namespace {

static_assert(std::endian::native == std::endian::little, "floats are copied as they are in memory");

enum class PacketType : char { create_image = 4, update_image_planar = 5 };

constexpr int tile_side = 128;

class Packet {
 public:
  explicit Packet(PacketType type) : bytes_(4, '\0') {
    bytes_ += static_cast<char>(type);
    bytes_ += '\0';  // the viewer's window stays where it is
  }
  void text(const std::string& text) { bytes_.append(text.c_str(), text.size() + 1); }
  void number(std::int32_t value) { append(&value, sizeof value); }
  void append(const void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }
  void reserve(std::size_t size) { bytes_.reserve(bytes_.size() + size); }

  std::string take() {
    const auto size = static_cast<std::uint32_t>(bytes_.size());
    std::memcpy(bytes_.data(), &size, sizeof size);
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
};

/// The tile's part of row y.
const float* row_of(const image::Channel& channel, int width, const image::Window& tile, int y) {
  return channel.pixels.data() + static_cast<std::size_t>(tile.top + y) * static_cast<std::size_t>(width) +
         static_cast<std::size_t>(tile.left);
}

}  // namespace

std::string create_image_packet(const std::string& name, int width, int height,
                                const std::vector<std::string>& channels) {
  Packet packet(PacketType::create_image);
  packet.text(name);
  packet.number(width);
  packet.number(height);
  packet.number(static_cast<std::int32_t>(channels.size()));
  for (const std::string& channel : channels) packet.text(channel);
  return packet.take();
}

std::string update_image_packet(const std::string& name, const std::vector<const image::Channel*>& channels, int width,
                                const image::Window& tile) {
  Packet packet(PacketType::update_image_planar);
  const std::size_t row_bytes = sizeof(float) * static_cast<std::size_t>(tile.width);
  packet.reserve(1024 + channels.size() * static_cast<std::size_t>(tile.height) * row_bytes);
  packet.text(name);
  packet.number(static_cast<std::int32_t>(channels.size()));
  for (const image::Channel* channel : channels) packet.text(channel->name);
  for (const int number : {tile.left, tile.top, tile.width, tile.height}) packet.number(number);
  for (const image::Channel* channel : channels) {
    for (int y = 0; y < tile.height; ++y) packet.append(row_of(*channel, width, tile, y), row_bytes);
  }
  return packet.take();
}

std::vector<std::vector<const image::Channel*>> channels_by_layer(const image::Picture& picture) {
  std::vector<std::vector<const image::Channel*>> layers;
  std::map<std::string, std::size_t> place;
  for (const image::Channel& channel : picture.channels) {
    const auto [found, is_new] = place.emplace(image::layer_of(channel.name), layers.size());
    if (is_new) layers.emplace_back();
    layers[found->second].push_back(&channel);
  }
  return layers;
}

std::vector<image::Window> tiles_of(int width, int height) {
  std::vector<image::Window> tiles;
  for (int top = 0; top < height; top += tile_side) {
    for (int left = 0; left < width; left += tile_side)
      tiles.push_back({left, top, std::min(tile_side, width - left), std::min(tile_side, height - top)});
  }
  return tiles;
}

std::uint64_t tile_hash(const std::vector<const image::Channel*>& channels, int width, const image::Window& tile) {
  std::vector<std::uint64_t> rows;
  rows.reserve(channels.size() * static_cast<std::size_t>(tile.height));
  for (const image::Channel* channel : channels) {
    for (int y = 0; y < tile.height; ++y) {
      rows.push_back(content_hash({reinterpret_cast<const char*>(row_of(*channel, width, tile, y)),
                                   sizeof(float) * static_cast<std::size_t>(tile.width)}));
    }
  }
  return content_hash({reinterpret_cast<const char*>(rows.data()), sizeof(std::uint64_t) * rows.size()});
}

}  // namespace tress::live
