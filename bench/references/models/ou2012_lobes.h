// What the artist-friendly lobes of one fiber are, before any direction is known.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// Gaussian g of height 1, and Cauchy law of the same scale, on |x| of a circle, x the distance in azimuth from the
/// known direction: about +-centre, two lobes unless the centre is 0 or pi. Radians.
struct AzimuthalBump {
  AzimuthalBump() = default;
  /// centre in [0, pi], width > 0.
  AzimuthalBump(float centre, float width);

  /// phi in [-pi, pi): g(|phi| - centre).
  float height(float phi) const;
  /// The integral of height() over the circle.
  float mass() const;
  /// Cauchy density of |phi| about the centre, cut to [0, pi], the sign a coin's: mass 1.
  float pdf(float phi) const;
  /// Draws from it. In [-pi, pi).
  float sample(float u) const;

 private:
  float centre_ = 0, width_ = 1;
  float from_ = 0, span_ = 1;  ///< atan at 0, and from there to pi
};

/// One M_p, of constant width.
struct LongitudinalBump {
  float tilt, beta;

  /// g times (cos theta_i / cos theta_d)^2, theta within half_pi.
  float height(float theta_r, float theta_i) const;
  /// Its integral over theta_i.
  float mass(float theta_r) const;
};

/// mass(theta_r) at equal steps of theta_r over [-pi/2, pi/2], linear between them.
class LongitudinalMasses {
 public:
  explicit LongitudinalMasses(const LongitudinalBump& bump);
  float at(float theta_r) const;

 private:
  static constexpr int steps = 128;
  std::array<float, steps + 1> mass_;
};

/// Far field of the circular fiber at normal incidence.
struct CircleFarField {
  /// sigma_a per radius; sigma_trt: blur of TRT, by which it is shared.
  CircleFarField(float eta, const glm::vec3& sigma_a, float sigma_trt);

  glm::vec3 tt{0.0f}, trt{0.0f}, glint{0.0f};  ///< energies; trt without glint
  float deviation_tt = 0;                      ///< of the exits of clear TT from pi
  float caustic = 0;                           ///< |azimuth| of TRT's caustic
};

}  // namespace tress::inline v0_2::fiber
