// The lobes of a fiber and the values that each lobe has.
#pragma once

#include <array>
#include <glm/vec3.hpp>

namespace tress::inline v0_2::fiber {

/// glint is the part of TRT about its caustics; it is 0 unless the fiber splits it off, and TRT is then the rest.
enum class Lobe { r = 0, tt = 1, trt = 2, trrt = 3, residual = 4, glint = 5 };
constexpr int lobe_count = 6;
constexpr std::array<const char*, lobe_count> lobe_names{"R", "TT", "TRT", "TRRT", "residual", "GLINT"};

/// The library is compiled without glm's aligned types: with GLM_FORCE_DEFAULT_ALIGNED_GENTYPES a host would read other
/// bytes than were written.
static_assert(sizeof(glm::vec3) == 3 * sizeof(float) && alignof(glm::vec3) == alignof(float),
              "tress needs glm's packed types: include its headers without GLM_FORCE_DEFAULT_ALIGNED_GENTYPES");
/// Nor with constructors that initialize, or members for swizzles: both pass a vector in other registers.
static_assert(std::is_trivial_v<glm::vec3> && GLM_CONFIG_SWIZZLE != GLM_SWIZZLE_OPERATOR,
              "tress needs glm's plain types: include its headers without GLM_FORCE_CTOR_INIT and GLM_FORCE_SWIZZLE");

/// Linear RGB per lobe.
using LobeColors = std::array<glm::vec3, lobe_count>;

/// Where light leaves a fiber, if the model knows it, in major semi-axes: the line on which it leaves passes the axis
/// at the offset `across` along (direction x tangent), and `along` towards the tip from where the ray that came passed
/// it.
struct FiberExit {
  float across = 0, along = 0;
  bool is_known = false;
};

/// A direction in the fiber's frame (u tangent root to tip, v major axis, w minor axis), pointing away from it.
/// theta in [-pi/2, pi/2] from the normal plane towards u; phi in [-pi, pi) from v towards w. Radians.
struct FiberDirection {
  float theta = 0;
  float phi = 0;
};

}  // namespace tress::inline v0_2::fiber
