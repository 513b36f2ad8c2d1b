// Follows light over all microfacets until it leaves a rough interface, so that masked light is not lost.
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "fiber/beckmann.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::fiber {

struct Departure {
  glm::vec3 direction;  ///< unit, in which light leaves: above the surface, or below it if `refracted`
  bool refracted;
};

/// The random walk of Heitz, Hanika, d'Eon and Dachsbacher 2016 ("Multiple-Scattering Microfacet BSDFs with the Smith
/// Model") on a surface of uniform heights. Light goes from height to height, with a visible normal and exact Fresnel
/// reflectance at each facet, until it meets none. Energy is conserved: every departure has the weight 1. w: unit,
/// towards where light comes from; facing: the mean normal on that side, w.facing > 0. index: of the far side over that
/// of the side of w. u_facet and u_choice serve the first facet; more numbers come from `random`.
Departure walk_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                            const std::array<float, 2>& u_facet, float u_choice, RandomStream& random);

/// Both ways of light at its first facet, each followed until it leaves.
struct SplitDeparture {
  float share_reflected = 0;       ///< share of the light that the first facet reflects
  Departure reflected, refracted;  ///< where either goes; arbitrary if its share is 0
};

/// The same walk without a choice at the first facet, so that the expectation over that choice is exact.
SplitDeparture split_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                                  const std::array<float, 2>& u_facet, RandomStream& random);

/// A direction of interest, and the density of light that leaves towards it.
struct Outlook {
  glm::vec3 direction;  ///< unit
  bool refracted;       ///< the side on which it leaves, as in Departure::refracted
  float density = 0;    ///< per steradian; its mean over walks is the density of all departures
};

/// The same walk. At every facet that it meets it adds to outlook.density: the density of turning there towards the
/// direction, times the probability of meeting no further facet (Heitz et al. 2016, section 5).
SplitDeparture split_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                                  const std::array<float, 2>& u_facet, RandomStream& random, Outlook& outlook);

}  // namespace tress::inline v0_2::fiber
