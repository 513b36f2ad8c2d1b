// The generators behind generate_groom(), one file each.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "scene/model/scene.h"

namespace tress::scene {

/// A recipe with every value filled in.
struct GroomShape {
  std::uint32_t strands = 1;
  std::uint64_t seed = 0;
  float radius_cm = 0.004f;
  std::uint32_t points = 16;             ///< per strand
  std::map<std::string, double> values;  ///< by key of shape_parameters()

  /// 0 for a key that the kind has not.
  float operator[](const char* key) const {
    const auto found = values.find(key);
    return found == values.end() ? 0.0f : static_cast<float>(found->second);
  }
};

Groom curly_lock(const GroomShape& shape);
Groom head_groom(const GroomShape& shape);
Groom fur_ball(const GroomShape& shape);
Groom single_fiber(const GroomShape& shape);

/// 0 below 0, 1 above 1, smooth between.
inline float smooth_step(float x) {
  if (!(x > 0)) return 0;
  return x < 1 ? x * x * (3 - 2 * x) : 1;
}

}  // namespace tress::scene
