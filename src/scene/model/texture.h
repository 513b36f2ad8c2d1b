// A picture as the texture of a mesh or of the roots of strands.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tress::scene {

/// Linear RGB in [0, 1], bilinear between the middles of its pixels, repeated in both directions. It is stored as half
/// floats: 6 bytes a pixel, in steps of at most 0.0005. Immutable; thread-safe.
class Texture {
 public:
  /// pixels: width x height values, row-major, top row first, in [0, 1]. Both sides at least 1.
  Texture(int width, int height, const std::vector<glm::vec3>& pixels);

  /// The value at uv as in OBJ: (0, 0) is the lower left corner of the picture, (1, 1) the upper right one. Finite.
  glm::vec3 at(const glm::vec2& uv) const;
  const glm::vec3& mean() const { return mean_; }
  std::size_t bytes() const { return halves_.size() * sizeof(std::uint16_t); }

 private:
  glm::vec3 pixel(std::size_t column, std::size_t row) const;

  std::size_t width_, height_;
  std::vector<std::uint16_t> halves_;
  glm::vec3 mean_;
};

}  // namespace tress::scene
