// Random shapes that generated grooms share.
#pragma once

#include <glm/vec3.hpp>

#include "tress/base/random.h"

namespace tress::scene {

/// Uniform in [low, high).
inline float uniform(RandomStream& random, float low, float high) { return low + (high - low) * random.next(); }

/// About normal, mean 0, standard deviation 1, within 3.5: a sum of four uniforms.
inline float kernel(RandomStream& random) {
  const float sum = random.next() + random.next() + random.next() + random.next();
  return (sum - 2.0f) * 1.7320508f;
}

/// A smooth wander of a strand sideways: two slow waves of random phase and direction.
class Wander {
 public:
  explicit Wander(RandomStream& random);
  /// t in [0, 1] along the strand; about unit amplitude.
  glm::vec3 at(float t) const;

 private:
  glm::vec3 slow_, fast_;
  glm::vec3 slow_phase_, fast_phase_;
};

}  // namespace tress::scene
