// One rough elliptical dielectric fiber, traced in three dimensions. Without a tilt, and with masked light lost, it is
// the model that made ../shared/reference/fiber3d.csv. Light enters along a known direction and is followed through
// every order until it leaves, is absorbed or is masked.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "fiber/beckmann.h"
#include "fiber/interior.h"
#include "tress/base/random.h"
#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// The place where a ray meets the fiber, in the fiber's frame (u, v, w) with major semi-axis 1.
struct RoughEntry {
  glm::vec3 direction;  ///< unit, away from the fiber
  glm::vec2 point;      ///< (x, y/e) of the cross-section, on the unit circle
};

/// The end of a path.
struct RoughExit {
  int order = 0;                  ///< number of times it was inside before it left: 0 R, 1 TT, 2 TRT, ...
  glm::vec3 direction{0, 1, 0};   ///< unit, away from the fiber
  glm::vec3 throughput{0.0f};     ///< linear RGB, for unit flux; 0: absorbed or masked
  float way = 0;                  ///< path length in the cortex, major semi-axes
  FiberExit place;                ///< where it leaves
  FiberDirection angles() const;  ///< angles of `direction`
};

/// A part of a path's light that has left.
struct SplitExit {
  int order;
  float weight, path;   ///< for unit flux without absorption; path length in the cortex, major semi-axes
  glm::vec3 direction;  ///< unit, away from the fiber; past longest_way, that of the last event
};

/// The rules by which trace_split() ends a path.
struct SplitRules {
  float roulette_below = 0.15f;  ///< share of unit flux: a smaller weight survives with the probability of that weight
  float longest_way = 200;       ///< major semi-axes: light inside past this and TRRT leaves where it is
};

/// The treatment of light that a microfacet sends against another one.
enum class Masked {
  meets_others,  ///< it goes on until it leaves, so a clear fiber returns all light (microsurface_walk.h)
  is_lost,       ///< one facet a hit, separable Smith, as in ../shared/reference/fiber3d.csv
};

/// At every hit a microfacet's normal m is drawn from Beckmann's visible normals; exact unpolarised Fresnel reflectance
/// at m chooses between reflection and refraction. Then light meets the next facet, or, if masked light is lost, gets
/// the weight G1 of the direction in which it leaves (0 on the wrong side). Inside, light travels in straight lines and
/// is absorbed by exp(-sigma_a l), l the path length in three dimensions. Paths that keep less than `roulette_below` of
/// their flux in every channel survive with the probability of what they keep.
///
/// The cuticle of tilt tau consists of scales whose faces rise towards the tip, with the normal n cos tau - u sin tau,
/// and of the steps where they end, with the normal u and the area tan tau; both are rough. Light meets one of them in
/// proportion to the area that it sees, inside and out, and light that then heads for the surface meets it again. A
/// tilted normal alone would lose half the light at 60 degrees, which the rising faces guide along the fiber. (The idea
/// of the second face: Schuessler et al. 2017.) Without a tilt the fiber is that of fiber3d.csv.
///
/// A medulla (FiberParameters) is entered without refraction. In it, and in a cortex that scatters, light makes free
/// flights and scatters between them by Henyey and Greenstein's law. It keeps exp(-medulla_absorption l) over its
/// length l in the medulla; sigma_a absorbs in the cortex only. Scattered light keeps its order: the number of times it
/// was inside.
///
/// Water (FiberParameters::wetness) is a film without thickness: at each hit from outside or from inside the fiber
/// light meets it with the probability of its share. The film's outer surface, between air and water, has no scales and
/// the roughness film_roughness(). Under it the fiber's own surface lies between water and hair. Light is reflected
/// between the two, at one place, until it leaves the film.
///
/// Left out: diffraction, polarisation between events (tests/fiber/wave_optics_test.cpp has what both come to).
///
/// Immutable plain data; any thread.
class RoughFiber {
 public:
  static constexpr float roulette_below = 0.02f;
  static constexpr int most_events = 1 << 16;  ///< a path that meets more surfaces counts as absorbed

  /// Reads eta, eccentricity, roughness (alpha of every event but at water), tilt, sigma_a, the medulla, the cortex and
  /// the wetness.
  explicit RoughFiber(const FiberParameters& parameters, Masked masked = Masked::meets_others);

  float tan_tilt() const { return tan_tilt_; }
  float cos_tilt() const { return cos_tilt_; }

  /// wr: theta within +-pi/2. h in [-1, 1]: the offset over the projected half width, towards rising azimuth.
  RoughEntry entry(const FiberDirection& wr, float h) const;

  /// Traces one path. `u` gives the facet and the choice at the entry and the first choice inside; all other numbers
  /// come from `random`. Ends with probability 1; finite for every input.
  /// kept_inside: about the share of the light that enters that will leave again, (0, 1]. It makes the first facet
  /// reflect more often in dark fibers, and changes no mean.
  RoughExit trace(const RoughEntry& entry, const std::array<float, 4>& u, RandomStream& random,
                  float kept_inside = 1) const;

  /// The density, per steradian, of the first facet that light meets turning it towards wi by trace().
  float first_reflection(const RoughEntry& entry, const FiberDirection& wi, float kept_inside) const;

  /// Numbers for the facet at the entry and for the first two facets that light meets from inside.
  using FacetNumbers = std::array<std::array<float, 2>, 3>;
  /// Follows all orders of a clear fiber in one path. At every facet the light that leaves is appended to `exits` and
  /// the rest goes on, so expectations over reflection and refraction are exact. Weights sum on average to 1, minus
  /// what a medulla absorbs. Their mean is that of trace(), except for light that leaves because a rule ends its path.
  /// Ignores sigma_a and Masked: only the medulla absorbs light.
  void trace_split(const RoughEntry& entry, const FacetNumbers& u, RandomStream& random, std::vector<SplitExit>& exits,
                   const SplitRules& rules = {}) const;

  /// Estimates S at wi without bias, in 1/rad^2 (a density in dtheta dphi), by lobe (R, TT, TRT, TRRT, the residual)
  /// and channel. The mean over paths is S from this entry, and the mean over entries that of the whole fiber. It
  /// follows one path as trace_split() does, and at every facet adds the light that would turn there towards wi and
  /// leave (split_microsurface() with an outlook), under absorption. Reads all that trace() reads, except
  /// Masked::is_lost. The variance is large for small roughness: the smooth fiber's S is infinite. wi: theta within
  /// +-pi/2.
  LobeColors estimate(const RoughEntry& entry, const FiberDirection& wi, const FacetNumbers& u,
                      RandomStream& random) const;
  /// The same, of light that leaves from one place: that of one of the path's facets, chosen in proportion to what it
  /// sends towards wi, whose light stands for all of it. It sets `place`.
  LobeColors estimate(const RoughEntry& entry, const FiberDirection& wi, const FacetNumbers& u, RandomStream& random,
                      FiberExit& place) const;

 private:
  class Exits;
  class Estimate;
  enum class Medium { air, film, fiber };
  /// A surface between two media that light meets from one of them.
  struct Interface {
    const Beckmann& facets;
    float eta;  ///< index of its inner medium over that of its outer one
    Medium outer, inner;
    bool from_inside;
    bool has_scales() const { return inner == Medium::fiber; }
    float index() const { return from_inside ? 1 / eta : eta; }  ///< of the far side over this side
    float side() const { return from_inside ? -1.0f : 1.0f; }
    Medium after(bool refracted) const { return refracted == from_inside ? outer : inner; }
  };
  /// The surfaces of the fiber without water, of the film, and of the fiber under it.
  Interface bare(bool from_inside) const { return {facets_, eta_, Medium::air, Medium::fiber, from_inside}; }
  Interface film(bool from_inside) const { return {film_, eta_of_water, Medium::air, Medium::film, from_inside}; }
  Interface under_film(bool from_inside) const {
    return {facets_, eta_ / eta_of_water, Medium::film, Medium::fiber, from_inside};
  }
  /// The surface that light meets. outwards: whether it heads away from the axis.
  Interface met(Medium from, bool outwards, RandomStream& random) const {
    if (from == Medium::film) return outwards ? film(true) : under_film(false);
    const bool inside = from == Medium::fiber;
    if (!(wetness_ > 0) || !(random.next() < wetness_)) return bare(inside);
    return inside ? under_film(true) : film(false);
  }
  /// Follows a path without choices at first facets; the visitor gets the light that leaves, and may look at a
  /// direction.
  template <class Visitor>
  void follow_split(const RoughEntry& entry, const FacetNumbers& u, RandomStream& random, const SplitRules& rules,
                    Visitor& visitor) const;
  struct Event {
    glm::vec3 direction;  ///< unit, in which light leaves
    bool refracted;
    float weight;  ///< 0 if masked
  };
  /// Scatters light at the surface with the normal `outward`. w: unit, back to where the light comes from.
  Event scatter(const Interface& at, const glm::vec3& w, const glm::vec3& outward, const std::array<float, 2>& u_facet,
                float u_choice, RandomStream& random) const;
  /// Moves a ray that is inside and heads for the surface to its next hit, and returns its way.
  InnerWay cross(InnerRay& ray, RandomStream& random) const;
  /// The direction as a surface sees it: clamped to its horizon.
  static glm::vec3 toward_face(const glm::vec3& w, const glm::vec3& facing);
  /// The normal of the face of the surface that light from w meets, on its side.
  glm::vec3 face(const Interface& at, const glm::vec3& w, const glm::vec3& outward, RandomStream& random) const;
  glm::vec3 outward_normal(const glm::vec2& point) const;
  /// The way along the axis from a point of the surface to where a line through it passes nearest to the axis.
  float to_middle(const glm::vec2& point, const glm::vec3& direction) const;
  FiberExit place_of(const glm::vec2& point, const glm::vec3& direction, float along) const;
  /// The event at the first facet, reflected with another probability than Fresnel's, as weights make up for.
  Event scatter_first(const Interface& at, const glm::vec3& w, const glm::vec3& outward, const std::array<float, 4>& u,
                      RandomStream& random, float kept_inside) const;
  float first_reflection(const Interface& at, const RoughEntry& entry, const FiberDirection& wi,
                         float kept_inside) const;

  Masked masked_;
  Beckmann facets_, film_;
  float eta_, eccentricity_, tan_tilt_, cos_tilt_;
  TracedParts parts_;
  float wetness_;
  glm::vec3 sigma_a_;
};

}  // namespace tress::inline v0_2::fiber
