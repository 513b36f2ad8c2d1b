// A sequence of pixels whose first ones, however many, are spread evenly over an image.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>

#include "scene/model/scene.h"

namespace tress::integrate {

/// Pixel i, from 0, of the R2 sequence (Roberts 2018): multiples of two numbers that spread evenly over a square.
inline glm::ivec2 spread_pixel(std::uint64_t i, const scene::Image& image) {
  const double u = static_cast<double>(i) * 0.7548776662466927 + 0.5,
               v = static_cast<double>(i) * 0.5698402909980532 + 0.5;
  return {std::min(image.width - 1, static_cast<int>((u - std::floor(u)) * image.width)),
          std::min(image.height - 1, static_cast<int>((v - std::floor(v)) * image.height))};
}

}  // namespace tress::integrate
