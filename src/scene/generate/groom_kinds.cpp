// The smallest kind, and the wander that the other kinds share.
#include "scene/generate/groom_kinds.h"

#include <cmath>

#include "base/pi.h"

namespace tress::scene {
namespace {

glm::vec3 in_box(RandomStream& random, float half) {
  const float x = uniform(random, -half, half), y = uniform(random, -half, half), z = uniform(random, -half, half);
  return {x, y, z};
}

}  // namespace

Wander::Wander(RandomStream& random)
    : slow_(in_box(random, 1.0f)),
      fast_(in_box(random, 0.35f)),
      slow_phase_(in_box(random, two_pi_f)),
      fast_phase_(in_box(random, two_pi_f)) {}

glm::vec3 Wander::at(float t) const {
  glm::vec3 p;
  for (int c = 0; c < 3; ++c)
    p[c] = slow_[c] * std::sin(5.0f * t + slow_phase_[c]) + fast_[c] * std::sin(14.0f * t + fast_phase_[c]);
  return p;
}

Groom single_fiber(const GroomShape& shape) {
  constexpr float apart_cm = 0.1f;
  const float length_cm = shape["length_cm"];
  Groom groom;
  groom.first_point.push_back(0);
  for (std::uint32_t s = 0; s < shape.strands; ++s) {
    const float x = apart_cm * (static_cast<float>(s) - 0.5f * static_cast<float>(shape.strands - 1));
    for (std::uint32_t i = 0; i < shape.points; ++i) {
      groom.points.emplace_back(x, 0.0f, -length_cm * static_cast<float>(i) / static_cast<float>(shape.points - 1));
      groom.radius_cm.push_back(shape.radius_cm);
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  return groom;
}

}  // namespace tress::scene
