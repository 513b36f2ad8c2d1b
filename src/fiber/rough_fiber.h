// One rough elliptical dielectric fiber, traced in three dimensions: the definition that
// ../shared/reference/fiber3d.csv was made by, with a tilted cuticle. Light enters along a known direction and is
// followed through every order until it leaves, is absorbed or masked.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "fiber/beckmann.h"
#include "fiber/medulla.h"
#include "tress/base/random.h"
#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::fiber {

/// Where a ray meets the fiber. In the fiber's frame (u, v, w); major semi-axis 1.
struct RoughEntry {
  glm::vec3 direction;  ///< unit, away from the fiber
  glm::vec2 point;      ///< (x, y/e) of the cross-section, on the unit circle
};

/// How a path ended.
struct RoughExit {
  int order = 0;                  ///< how often it was inside before it left: 0 R, 1 TT, 2 TRT, ...
  glm::vec3 direction{0, 1, 0};   ///< unit, away from the fiber
  glm::vec3 throughput{0.0f};     ///< linear RGB, of unit flux; 0: absorbed or masked
  float way = 0;                  ///< in the cortex, major semi-axes
  FiberDirection angles() const;  ///< of `direction`
};

/// A part of a path's light that left.
struct SplitExit {
  int order;
  float weight, path;   ///< of unit flux, where sigma_a is 0; way in the cortex, major semi-axes
  glm::vec3 direction;  ///< unit, away from the fiber; of what left for the length of its way, that of its last event
};

/// Where trace_split() lets go of a path.
struct SplitRules {
  float roulette_below = 0.15f;  ///< of unit flux: what keeps less survives with the probability of what it keeps
  float longest_way = 200;       ///< major semi-axes: what is still inside, and past TRRT, leaves where it is
};

/// What becomes of light that a microfacet sends against another one.
enum class Masked {
  meets_others,  ///< it goes on until it leaves: a clear fiber returns all light (microsurface_walk.h)
  is_lost,       ///< one facet a hit, separable Smith: how ../shared/reference/fiber3d.csv was made
};

/// At every hit a microfacet's normal m by Beckmann's visible ones and exact unpolarised Fresnel at m, which chooses
/// between reflection and refraction; then the next facet, or, if masked light is lost, the weight G1 of the direction
/// it leaves by, 0 on the wrong side. Inside, light travels in straight lines and is absorbed by exp(-sigma_a l), l the
/// way in three dimensions. Paths that keep less than `roulette_below` of their flux in every channel survive with the
/// probability of what they keep.
///
/// The cuticle of tilt tau is made of scales whose faces rise towards the tip, with the normal n cos tau - u sin tau,
/// and of the steps where they end, with the normal u and the area tan tau; both are rough. Light meets one of them in
/// proportion to the area that it sees, inside and out, and what then goes on towards the surface meets it again: a
/// tilted normal alone would lose half the light at 60 degrees, that which the rising faces guide along the fiber. (The
/// idea of the second face: Schuessler et al. 2017.) Without a tilt it is the fiber of the file.
///
/// A medulla (FiberParameters) is met without refraction. In it light goes on in free flights, turned between them by
/// Henyey and Greenstein's law, and keeps exp(-medulla_absorption l) of its length l; sigma_a colors the way in the
/// cortex only. What it scatters has the order that it would have without: how often it was inside.
///
/// Left out: diffraction, polarisation between events, the displacement along the fiber between entry and exit.
///
/// Immutable plain data; any thread.
class RoughFiber {
 public:
  static constexpr float roulette_below = 0.02f;
  static constexpr int most_events = 1 << 16;  ///< a path that meets more surfaces counts as absorbed

  /// Reads eta, eccentricity, roughness (alpha of every event), tilt, sigma_a and the medulla.
  explicit RoughFiber(const FiberParameters& parameters, Masked masked = Masked::meets_others);

  float tan_tilt() const { return tan_tilt_; }
  float cos_tilt() const { return cos_tilt_; }

  /// wr: theta within +-pi/2. h in [-1, 1]: the offset over the projected half width, towards rising azimuth.
  RoughEntry entry(const FiberDirection& wr, float h) const;

  /// The path that these uniforms make: the facet and the choice where it enters and the first choice inside are by u,
  /// the rest by `random`. Ends with probability 1; finite for every input.
  RoughExit trace(const RoughEntry& entry, const std::array<float, 4>& u, RandomStream& random) const;

  /// The facets where it enters and where it first and next meets the surface from inside.
  using FacetNumbers = std::array<std::array<float, 2>, 3>;
  /// All orders of a clear fiber from one path: at every facet what leaves is appended to `exits` and the rest goes on,
  /// so that expectations over choices of reflection and refraction are exact. Weights sum on average to 1, less
  /// what a medulla absorbs, and
  /// are what trace() gives in the mean, but for what leaves where rules let go of it. sigma_a and Masked are not read:
  /// no light is lost but in the medulla.
  void trace_split(const RoughEntry& entry, const FacetNumbers& u, RandomStream& random, std::vector<SplitExit>& exits,
                   const SplitRules& rules = {}) const;

  /// An unbiased value of S at wi, 1/rad^2 (a density in dtheta dphi), by lobe (R, TT, TRT, TRRT, the residual) and
  /// channel: its mean over paths from this entry, and over entries that of the whole fiber. One path as trace_split()
  /// follows it, which at every facet that it meets looks whether light would turn there towards wi and leave
  /// (split_microsurface() with an outlook), under absorption. Reads all that trace() does but for Masked::is_lost.
  /// Wide where the roughness is small: the smooth fiber's S is infinite. wi: theta within +-pi/2.
  LobeColors estimate(const RoughEntry& entry, const FiberDirection& wi, const FacetNumbers& u,
                      RandomStream& random) const;

 private:
  class Exits;
  class Estimate;
  /// A path without choices at first facets; the visitor is told what leaves, and looks where it wants to.
  template <class Visitor>
  void follow_split(const RoughEntry& entry, const FacetNumbers& u, RandomStream& random, const SplitRules& rules,
                    Visitor& visitor) const;
  struct Event {
    glm::vec3 direction;  ///< unit, that light leaves in
    bool refracted;
    float weight;  ///< 0: masked
  };
  /// Light meets the surface that has `outward` as its normal from w, a unit direction that points back to where the
  /// light is from.
  Event scatter(const glm::vec3& w, const glm::vec3& outward, bool from_inside, const std::array<float, 2>& u_facet,
                float u_choice, RandomStream& random) const;
  /// Where light that is inside and heads for the surface meets it: moves the ray there, tells the way.
  InnerWay cross(InnerRay& ray, RandomStream& random) const;
  /// The direction as a surface sees it: not past its horizon.
  static glm::vec3 toward_face(const glm::vec3& w, const glm::vec3& facing);
  /// The normal, to the side that light from w arrives on, of the face of the cuticle that it meets; side: -1 inside.
  glm::vec3 face(const glm::vec3& w, const glm::vec3& outward, float side, RandomStream& random) const;
  glm::vec3 outward_normal(const glm::vec2& point) const;

  Masked masked_;
  Beckmann facets_;
  float eta_, eccentricity_, tan_tilt_, cos_tilt_;
  Medulla medulla_;
  glm::vec3 sigma_a_;
};

}  // namespace tress::fiber
