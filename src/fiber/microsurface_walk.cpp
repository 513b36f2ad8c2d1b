#include "fiber/microsurface_walk.h"

#include <algorithm>
#include <cmath>

#include "fiber/fresnel.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr int most_facets = 256;  // some one path in 1e30 meets more: it leaves in the direction it has
constexpr float lowest = 1e-6f;   // least share of the heights that lie below a place
constexpr float level = 1e-4f;    // cosine below which a direction stays at its height

/// Light at a place of the microsurface. `below`: the share of the heights that lie below it, on the side `up`.
struct Walker {
  glm::vec3 direction, up;
  float below = 1;
  bool beyond = false;  ///< whether it is on the far side of the interface

  /// Moves to the next facet. False if the light leaves without meeting one.
  bool advance(const Beckmann& facets, float u) {
    const float cosine = glm::dot(direction, up);
    if (std::abs(cosine) < level) return true;
    // Most light leaves at once, which this shows without Lambda: 1 - b^Lambda <= Lambda (1 - b)/b.
    if (cosine > 0 && u * below >= facets.lambda_at_most(cosine) * (1 - below)) return false;
    const float lambda = facets.lambda(cosine);
    if (cosine > 0) {
      if (!(lambda > 0)) return false;
      if (u >= 1 - std::pow(below, lambda)) return false;
    }
    below = std::clamp(below * (lambda == -1 ? 1 - u : std::pow(1 - u, -1 / lambda)), lowest, 1.0f);
    return true;
  }
};

/// A facet that light meets.
struct Facet {
  glm::vec3 normal;
  double cos_i, cos_t, reflected;
  float ratio;  ///< index beyond the facet over the index on the light's side
};

/// cosine: between the normal and the light's direction backwards; ratio: as in Facet.
Facet facet_along(const glm::vec3& normal, float cosine, float ratio) {
  Facet facet;
  facet.normal = normal;
  facet.ratio = ratio;
  facet.cos_i = std::clamp(static_cast<double>(cosine), 0.0, 1.0);
  const double denser = facet.ratio > 1 ? static_cast<double>(facet.ratio) : 1.0 / facet.ratio;
  facet.reflected = facet.ratio > 1 ? fresnel_entering(denser, denser, facet.cos_i, &facet.cos_t)
                                    : fresnel_leaving(denser, denser, facet.cos_i, &facet.cos_t);
  return facet;
}

Facet meet(const Walker& light, const Beckmann& facets, float index, const std::array<float, 2>& u,
           RandomStream& random) {
  const glm::vec3 normal = facets.visible_normal_within(-light.direction, light.up, u, random);
  // The light enters the denser side or leaves it; if it is already beyond, the ratio is inverted.
  return facet_along(normal, -glm::dot(light.direction, normal), light.beyond ? 1 / index : index);
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

/// For light at a facet whose normal is not drawn yet: the density, per steradian, of turning towards a direction and
/// leaving.
float density_towards(const glm::vec3& direction, bool beyond, const Walker& light, const Beckmann& facets,
                      float index) {
  const bool reflects = beyond == light.beyond;
  const float rises = glm::dot(direction, reflects ? light.up : -light.up);
  if (!(rises > level)) return 0;
  const glm::vec3 w = -light.direction;
  const float ratio = light.beyond ? 1 / index : index;
  const glm::vec3 half = reflects ? w + direction : w + ratio * direction;
  const float half2 = glm::dot(half, half);
  if (!(half2 > 0)) return 0;
  glm::vec3 normal = half / std::sqrt(half2);
  if (glm::dot(w, normal) < 0) normal = -normal;
  const float toward = glm::dot(w, normal), along = glm::dot(direction, normal);
  const float seen = facets.seen_area(glm::dot(w, light.up));
  if (!(toward > 0) || !(seen > 0) || (along > 0) != reflects) return 0;
  const float facing = facets.facet_area(glm::dot(normal, light.up)) / seen;
  if (!(facing > 0)) return 0;
  const auto reflected = static_cast<float>(facet_along(normal, toward, ratio).reflected);
  const float below = reflects ? light.below : std::max(1 - light.below, lowest);
  const float leaves = std::pow(below, facets.lambda(rises));
  if (reflects) return leaves * reflected * facing / 4;
  return leaves * (1 - reflected) * facing * toward * ratio * ratio * -along / half2;
}

/// A visitor that looks at no direction.
struct NoOutlook {
  void meets(const Walker&, float) const {}
};

struct Looking {
  Outlook& outlook;
  const Beckmann& facets;
  float index;
  /// Called at a facet before light turns there; share: of the light.
  void meets(const Walker& light, float share) const {
    outlook.density += share * density_towards(outlook.direction, outlook.refracted, light, facets, index);
  }
};

/// Follows the light after its first facet, from facet to facet, until it meets none.
template <class Looks>
Departure leave(Walker& light, const Beckmann& facets, float index, RandomStream& random, const Looks& looks,
                float share) {
  for (int met = 1; met < most_facets && light.advance(facets, random.next()); ++met) {
    looks.meets(light, share);
    const std::array<float, 2> u{random.next(), random.next()};
    const Facet facet = meet(light, facets, index, u, random);
    turn(light, facet, static_cast<double>(random.next()) < facet.reflected);
  }
  return {light.direction, light.beyond};
}

template <class Looks>
SplitDeparture split(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                     const std::array<float, 2>& u_facet, RandomStream& random, const Looks& looks) {
  Walker light{-w, facing};
  SplitDeparture split;
  if (!light.advance(facets, random.next())) return {1, {light.direction, false}, {}};
  looks.meets(light, 1);
  const Facet facet = meet(light, facets, index, u_facet, random);
  split.share_reflected = static_cast<float>(facet.reflected);
  Walker reflected = light, refracted = light;
  if (split.share_reflected > 0) {
    turn(reflected, facet, true);
    split.reflected = leave(reflected, facets, index, random, looks, split.share_reflected);
  }
  if (split.share_reflected < 1) {
    turn(refracted, facet, false);
    split.refracted = leave(refracted, facets, index, random, looks, 1 - split.share_reflected);
  }
  return split;
}

}  // namespace

Departure walk_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                            const std::array<float, 2>& u_facet, float u_choice, RandomStream& random) {
  Walker light{-w, facing};
  if (!light.advance(facets, random.next())) return {light.direction, false};
  const Facet facet = meet(light, facets, index, u_facet, random);
  turn(light, facet, static_cast<double>(u_choice) < facet.reflected);
  return leave(light, facets, index, random, NoOutlook{}, 1);
}

SplitDeparture split_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                                  const std::array<float, 2>& u_facet, RandomStream& random) {
  return split(facets, index, w, facing, u_facet, random, NoOutlook{});
}

SplitDeparture split_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                                  const std::array<float, 2>& u_facet, RandomStream& random, Outlook& outlook) {
  return split(facets, index, w, facing, u_facet, random, Looking{outlook, facets, index});
}

}  // namespace tress::inline v0_2::fiber
