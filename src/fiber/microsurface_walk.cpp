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

/// A facet that light meets.
struct Facet {
  glm::vec3 normal;
  double cos_i, cos_t, reflected;
  float ratio;  ///< index beyond the facet over that of the side that the light is on
};

Facet meet(const Walker& light, const Beckmann& facets, float index, const std::array<float, 2>& u,
           RandomStream& random) {
  Facet facet;
  facet.normal = facets.visible_normal_within(-light.direction, light.up, u, random);
  // Entering what is denser or leaving it; of what is beyond, the other way round.
  facet.ratio = light.beyond ? 1 / index : index;
  facet.cos_i = std::clamp(static_cast<double>(-glm::dot(light.direction, facet.normal)), 0.0, 1.0);
  const double denser = facet.ratio > 1 ? static_cast<double>(facet.ratio) : 1.0 / facet.ratio;
  facet.reflected = facet.ratio > 1 ? fresnel_entering(denser, denser, facet.cos_i, &facet.cos_t)
                                    : fresnel_leaving(denser, denser, facet.cos_i, &facet.cos_t);
  return facet;
}

void turn(Walker& light, const Facet& facet, bool reflect) {
  if (reflect) {
    light.direction += static_cast<float>(2 * facet.cos_i) * facet.normal;
  } else {
    light.direction = light.direction / facet.ratio +
                      static_cast<float>(facet.cos_i / static_cast<double>(facet.ratio) - facet.cos_t) * facet.normal;
    light.up = -light.up;
    light.below = std::max(1 - light.below, lowest);
    light.beyond = !light.beyond;
  }
  light.direction = glm::normalize(light.direction);
}

/// From facet to facet until there is none, after the first.
Departure leave(Walker& light, const Beckmann& facets, float index, RandomStream& random) {
  for (int met = 1; met < most_facets && light.advance(facets, random.next()); ++met) {
    const std::array<float, 2> u{random.next(), random.next()};
    const Facet facet = meet(light, facets, index, u, random);
    turn(light, facet, static_cast<double>(random.next()) < facet.reflected);
  }
  return {light.direction, light.beyond};
}

}  // namespace

Departure walk_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                            const std::array<float, 2>& u_facet, float u_choice, RandomStream& random) {
  Walker light{-w, facing};
  if (!light.advance(facets, random.next())) return {light.direction, false};
  const Facet facet = meet(light, facets, index, u_facet, random);
  turn(light, facet, static_cast<double>(u_choice) < facet.reflected);
  return leave(light, facets, index, random);
}

SplitDeparture split_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                                  const std::array<float, 2>& u_facet, RandomStream& random) {
  Walker light{-w, facing};
  SplitDeparture split;
  if (!light.advance(facets, random.next())) return {1, {light.direction, false}, {}};
  const Facet facet = meet(light, facets, index, u_facet, random);
  split.share_reflected = static_cast<float>(facet.reflected);
  Walker reflected = light, refracted = light;
  if (split.share_reflected > 0) {
    turn(reflected, facet, true);
    split.reflected = leave(reflected, facets, index, random);
  }
  if (split.share_reflected < 1) {
    turn(refracted, facet, false);
    split.refracted = leave(refracted, facets, index, random);
  }
  return split;
}

}  // namespace tress::fiber
