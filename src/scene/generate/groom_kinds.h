// The generators behind generate_groom() and the random shapes that they share; head_grooms.h has those with a head.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <string>

#include "scene/model/scene.h"
#include "tress/base/random.h"

namespace tress::scene {

/// A recipe with every value filled in.
struct GroomShape {
  std::uint32_t strands = 1;
  std::uint64_t seed = 0;
  float radius_cm = 0.004f;
  std::uint32_t points = 16;             ///< per strand
  std::map<std::string, double> values;  ///< by key of shape_parameters()

  /// Returns 0 for a key that the kind does not have.
  float operator[](const char* key) const {
    const auto found = values.find(key);
    return found == values.end() ? 0.0f : static_cast<float>(found->second);
  }
};

Groom curly_lock(const GroomShape& shape);
Groom curtain(const GroomShape& shape);
Groom fur_ball(const GroomShape& shape);
Groom single_fiber(const GroomShape& shape);

/// Returns 0 below 0, 1 above 1, and a smooth transition between.
inline float smooth_step(float x) {
  if (!(x > 0)) return 0;
  return x < 1 ? x * x * (3 - 2 * x) : 1;
}

/// Uniform in [low, high).
inline float uniform(RandomStream& random, float low, float high) { return low + (high - low) * random.next(); }

/// Approximately normal, mean 0, standard deviation 1, within 3.5: a sum of four uniforms.
inline float kernel(RandomStream& random) {
  const float sum = random.next() + random.next() + random.next() + random.next();
  return (sum - 2.0f) * 1.7320508f;
}

/// A smooth sideways wander of a strand: two slow waves of random phase and direction.
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
