// Instances: copies of a groom that share its strands.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "scene/model/shutter.h"

namespace tress::scene {

/// A rotation, a uniform scale > 0 and a translation, from the coordinates of a groom to those of the scene.
struct Similarity {
  glm::mat3 turn{1.0f};  ///< rotation
  float scale = 1;
  glm::vec3 offset{0.0f};  ///< cm

  glm::vec3 point(const glm::vec3& local) const { return scale * (turn * local) + offset; }
  glm::vec3 local_point(const glm::vec3& point) const { return (point - offset) * turn / scale; }
  friend bool operator==(const Similarity&, const Similarity&) = default;
};

/// One instance of a groom, at each of the shutter's moments.
struct Instance {
  Similarity first;
  std::vector<Similarity> later = {};  ///< at the later moments; empty if it does not move

  /// Its place at a time in [0, 1], from the opening of the shutter to its closing. Matrices change linearly between
  /// moments, as they do for rays; where that shears it, this is near, without the shear.
  Similarity at(float time) const {
    if (later.empty()) return first;
    const BetweenMoments between(time, 1 + later.size());
    const Similarity &a = between.before == 0 ? first : later[between.before - 1], &b = later[between.before];
    const float s = between.share;
    const glm::mat3 mixed = (1 - s) * a.scale * a.turn + s * b.scale * b.turn;
    const glm::vec3 x = glm::normalize(mixed[0]);
    const glm::vec3 y = glm::normalize(mixed[1] - glm::dot(mixed[1], x) * x);
    return {{x, y, glm::cross(x, y)}, std::cbrt(glm::determinant(mixed)), (1 - s) * a.offset + s * b.offset};
  }
};

}  // namespace tress::scene
