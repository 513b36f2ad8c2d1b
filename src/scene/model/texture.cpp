#include "scene/model/texture.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/gtc/packing.hpp>
#include <utility>

namespace tress::scene {
namespace {

/// The two pixels beside a coordinate, and its position from the middle of the first to that of the second, [0, 1].
struct Between {
  std::size_t first, second;
  float share;
};

/// x: in widths (heights) of the picture.
Between between(float x, std::size_t size) {
  const auto pixels = static_cast<float>(size);
  const float place = (x - std::floor(x)) * pixels - 0.5f;  // -0.5 .. size - 0.5
  const float low = std::floor(place);
  const auto first = low < 0 ? size - 1 : std::min(static_cast<std::size_t>(low), size - 1);
  return {first, first + 1 == size ? 0 : first + 1, place - low};
}

}  // namespace

int udim_tile(const glm::vec2& uv) {
  const float column = std::floor(uv.x), row = std::floor(uv.y);
  if (!(column >= 0 && column < 10 && row >= 0 && row < 100)) return 0;
  const int number = first_udim_tile + static_cast<int>(column) + 10 * static_cast<int>(row);
  return number <= last_udim_tile ? number : 0;
}

Texture::Texture(int width, int height, const std::vector<glm::vec3>& pixels)
    : width_(static_cast<std::size_t>(width)), height_(static_cast<std::size_t>(height)) {
  halves_.reserve(3 * pixels.size());
  glm::dvec3 sum(0.0);
  for (const glm::vec3& pixel : pixels) {
    for (int c = 0; c < 3; ++c) halves_.push_back(glm::packHalf1x16(pixel[c]));
    sum += glm::dvec3(pixel);
  }
  mean_ = glm::vec3(sum / static_cast<double>(pixels.size()));
}

Texture::Texture(std::map<int, Texture> tiles) : tiles_(std::move(tiles)) {
  glm::dvec3 sum(0.0);
  for (const auto& [number, tile] : tiles_) sum += glm::dvec3(tile.mean());
  mean_ = glm::vec3(sum / static_cast<double>(tiles_.size()));
}

std::size_t Texture::bytes() const {
  std::size_t bytes = halves_.size() * sizeof(std::uint16_t);
  for (const auto& [number, tile] : tiles_) bytes += tile.bytes();
  return bytes;
}

glm::vec3 Texture::pixel(std::size_t column, std::size_t row) const {
  const std::uint16_t* half = &halves_[3 * (row * width_ + column)];
  return {glm::unpackHalf1x16(half[0]), glm::unpackHalf1x16(half[1]), glm::unpackHalf1x16(half[2])};
}

glm::vec3 Texture::at(const glm::vec2& uv) const {
  if (!tiles_.empty()) {
    const auto tile = tiles_.find(udim_tile(uv));
    return tile == tiles_.end() ? mean_ : tile->second.at(uv);
  }
  const Between across = between(uv.x, width_), down = between(1 - (uv.y - std::floor(uv.y)), height_);
  const glm::vec3 top = glm::mix(pixel(across.first, down.first), pixel(across.second, down.first), across.share);
  const glm::vec3 bottom = glm::mix(pixel(across.first, down.second), pixel(across.second, down.second), across.share);
  return glm::mix(top, bottom, down.share);
}

}  // namespace tress::scene
