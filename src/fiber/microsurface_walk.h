// All the microfacets that light meets before it leaves a rough interface: the energy that one event masks is not lost.
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "fiber/beckmann.h"
#include "tress/base/random.h"

namespace tress::fiber {

struct Departure {
  glm::vec3 direction;  ///< unit, that light leaves in: above the surface, or below it if `refracted`
  bool refracted;
};

/// The random walk of Heitz, Hanika, d'Eon and Dachsbacher 2016 ("Multiple-Scattering Microfacet BSDFs with the Smith
/// Model") on a surface of uniform heights: light goes from height to height, a facet's visible normal and its exact
/// Fresnel reflectance at each, until nothing is met any more. No energy is lost or won: every departure has the weight
/// 1. w: unit, towards where light comes from; facing: the mean normal on that side, w.facing > 0. index: that of the
/// far side over that of the side of w. u_facet and u_choice serve the first facet, `random` what is needed besides.
Departure walk_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                            const std::array<float, 2>& u_facet, float u_choice, RandomStream& random);

/// Both ways that light may go at its first facet, each followed until it leaves.
struct SplitDeparture {
  float share_reflected = 0;       ///< of the light, by the first facet
  Departure reflected, refracted;  ///< what became of either; arbitrary where its share is 0
};

/// The same walk without a choice at the first facet: an expectation over it is taken exactly.
SplitDeparture split_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                                  const std::array<float, 2>& u_facet, RandomStream& random);

/// A direction that is looked at, and how dense the light is that leaves towards it.
struct Outlook {
  glm::vec3 direction;  ///< unit
  bool refracted;       ///< the side that it leaves on, as Departure::refracted
  float density = 0;    ///< per steradian; its mean over walks is that of all departures
};

/// The same walk, which adds to outlook.density at every facet that it meets: the density of turning there towards the
/// direction, times the chance that nothing is then met (Heitz et al. 2016, section 5).
SplitDeparture split_microsurface(const Beckmann& facets, float index, const glm::vec3& w, const glm::vec3& facing,
                                  const std::array<float, 2>& u_facet, RandomStream& random, Outlook& outlook);

}  // namespace tress::fiber
