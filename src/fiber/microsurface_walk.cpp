#include "fiber/microsurface_walk.h"

#include <algorithm>
#include <cmath>

#include "fiber/fresnel.h"

namespace tress::fiber {
namespace {

constexpr int most_facets = 256;  // a path in some 1e30 meets more: it leaves in the direction it has
constexpr float lowest = 1e-6f;   // share of the heights that lie below a place
constexpr float level = 1e-4f;    // cosine of a direction that stays at its height

/// Light at a place of the microsurface. `below`: the share of the heights that lie below, of `up`, the side it is on.
struct Walker {
  glm::vec3 direction, up;
  float below = 1;
  bool beyond = false;  ///< on the far side of the interface

  /// On to the next facet; false: there is none, it leaves.
  bool advance(const Beckmann& facets, float u) {
    const float cosine = glm::dot(direction, up);
    if (std::abs(cosine) < level) return true;
    const float lambda = facets.lambda(cosine);
    if (cosine > 0) {
      if (!(lambda > 0)) return false;
      if (u >= 1 - std::pow(below, lambda)) return false;
    }
    below = std::clamp(below * std::pow(1 - u, -1 / lambda), lowest, 1.0f);
    return true;
  }
};

}  // namespace

Departure walk_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                            const std::array<float, 2>& u_facet, float u_choice, RandomStream& random) {
  Walker light{-w, facing};
  for (int facet = 0; facet < most_facets && light.advance(facets, random.next()); ++facet) {
    const std::array<float, 2> u = facet == 0 ? u_facet : std::array<float, 2>{random.next(), random.next()};
    const glm::vec3 m = facets.visible_normal_within(-light.direction, light.up, u, random);
    // Entering what is denser or leaving it; of what is beyond, the other way round.
    const float ratio = light.beyond ? 1 / index : index;
    const double cos_i = std::clamp(static_cast<double>(-glm::dot(light.direction, m)), 0.0, 1.0);
    double cos_t;
    const double reflected = ratio > 1 ? fresnel_entering(ratio, ratio, cos_i, &cos_t)
                                       : fresnel_leaving(1.0 / ratio, 1.0 / ratio, cos_i, &cos_t);
    const float choice = facet == 0 ? u_choice : random.next();
    if (static_cast<double>(choice) < reflected) {
      light.direction += static_cast<float>(2 * cos_i) * m;
    } else {
      light.direction = light.direction / ratio + static_cast<float>(cos_i / static_cast<double>(ratio) - cos_t) * m;
      light.up = -light.up;
      light.below = std::max(1 - light.below, lowest);
      light.beyond = !light.beyond;
    }
    light.direction = glm::normalize(light.direction);
  }
  return {light.direction, light.beyond};
}

}  // namespace tress::fiber
