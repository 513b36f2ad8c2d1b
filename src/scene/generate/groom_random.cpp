#include "scene/generate/groom_random.h"

#include <cmath>
#include <numbers>

namespace tress::scene {
namespace {

constexpr float two_pi = 2 * std::numbers::pi_v<float>;

glm::vec3 in_box(RandomStream& random, float half) {
  const float x = uniform(random, -half, half), y = uniform(random, -half, half), z = uniform(random, -half, half);
  return {x, y, z};
}

}  // namespace

Wander::Wander(RandomStream& random)
    : slow_(in_box(random, 1.0f)),
      fast_(in_box(random, 0.35f)),
      slow_phase_(in_box(random, two_pi)),
      fast_phase_(in_box(random, two_pi)) {}

glm::vec3 Wander::at(float t) const {
  glm::vec3 p;
  for (int c = 0; c < 3; ++c)
    p[c] = slow_[c] * std::sin(5.0f * t + slow_phase_[c]) + fast_[c] * std::sin(14.0f * t + fast_phase_[c]);
  return p;
}

}  // namespace tress::scene
