// A picture as the texture of a mesh or of the roots of strands.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <vector>

namespace tress::scene {

/// The number of the tile of UDIM in which uv lies: 1001 for [0, 1)^2, 1 more per unit of u up to 9, 10 more per unit
/// of v; 0 if it lies in none.
int udim_tile(const glm::vec2& uv);
inline constexpr int first_udim_tile = 1001, last_udim_tile = 1999;

/// Linear RGB in [0, 1], bilinear between the middles of its pixels, repeated in both directions; or tiles of UDIM,
/// each such a picture. It is stored as half floats: 6 bytes per pixel, in steps of at most 0.0005. Immutable;
/// thread-safe.
class Texture {
 public:
  /// pixels: width x height values, row-major, top row first, in [0, 1]. Both sides at least 1.
  Texture(int width, int height, const std::vector<glm::vec3>& pixels);
  /// Tiles by their numbers, at least one.
  explicit Texture(std::map<int, Texture> tiles);

  /// The value at uv as in OBJ: (0, 0) is the lower left corner of the picture, (1, 1) the upper right one; mean()
  /// where there is no tile. Finite.
  glm::vec3 at(const glm::vec2& uv) const;
  /// Whether it has a picture at uv.
  bool is_at(const glm::vec2& uv) const { return tiles_.empty() || tiles_.contains(udim_tile(uv)); }
  const std::map<int, Texture>& tiles() const { return tiles_; }
  const glm::vec3& mean() const { return mean_; }
  std::size_t bytes() const;

 private:
  glm::vec3 pixel(std::size_t column, std::size_t row) const;

  std::size_t width_ = 0, height_ = 0;
  std::vector<std::uint16_t> halves_;
  std::map<int, Texture> tiles_;  ///< empty if it is one picture
  glm::vec3 mean_;
};

}  // namespace tress::scene
