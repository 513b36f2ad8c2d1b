// Fresnel reflectance of R by the half azimuth, in single precision: exact, or a variant from the paper's figure 5.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/quarter_sine.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// The reflectance for one known inclination. Immutable plain data; any thread.
class SurfaceFresnel {
 public:
  /// theta_r within +-pi/2.
  SurfaceFresnel(float eta, float theta_r, ReflectionFresnel kind) : kind_(kind), eta2_(eta * eta) {
    const float c = std::max(quarter_cosine(theta_r), 1e-6f);
    eta_prime2_ = 1 + (eta2_ - 1) / (c * c);
    if (kind == ReflectionFresnel::longitudinal) at_normal_ = exact(1);
  }

  /// The reflectance, in [0, 1]. cosine: |cos(d/2)|, of the angle of incidence in the normal plane, in [0, 1].
  float operator()(float cosine) const {
    switch (kind_) {
      case ReflectionFresnel::exact:
        return exact(cosine);
      case ReflectionFresnel::longitudinal:
        return at_normal_;
      case ReflectionFresnel::bravais:
        return bravais(cosine);
      case ReflectionFresnel::none:
        break;
    }
    return 1;
  }

  /// Exact Fresnel for a float or for lanes: cosine of the angle of incidence in the normal plane, inside = eta' times
  /// that of refraction. eta' cos gamma_t = sqrt(eta'^2 - sin^2 gamma), with one common denominator.
  template <class Float>
  static Float reflectance(float eta2, Float cosine, Float inside) {
    const Float scaled = eta2 * cosine, a = cosine + inside, b = scaled + inside;
    const Float s = (cosine - inside) * b, p = (scaled - inside) * a, both = a * b;
    return 0.5f * (s * s + p * p) / (both * both);
  }

  /// Sine of the angle of incidence where F has a kink, because p is totally reflected from there on: eta'' of
  /// `bravais`; 1 or more without a kink.
  float total_reflection() const { return kind_ == ReflectionFresnel::bravais ? eta2_ / std::sqrt(eta_prime2_) : 1; }

 private:
  static float square(float x) { return x * x; }

  float exact(float cosine) const { return reflectance(eta2_, cosine, std::sqrt(eta_prime2_ - 1 + cosine * cosine)); }

  /// Marschner et al. 2003: two-dimensional, with eta' for s and eta'' = eta^2/eta' for p. At steep inclinations eta''
  /// is below 1 and p is totally reflected.
  float bravais(float cosine) const {
    const float inside = std::sqrt(eta_prime2_ - 1 + cosine * cosine);
    const float s = square((cosine - inside) / (cosine + inside));
    const float other2 = eta2_ * eta2_ / eta_prime2_, inside2 = other2 - 1 + cosine * cosine;
    if (!(inside2 > 0)) return 0.5f * (s + 1);
    const float other_inside = std::sqrt(inside2), scaled = other2 * cosine;
    return 0.5f * (s + square((scaled - other_inside) / (scaled + other_inside)));
  }

  ReflectionFresnel kind_;
  float eta2_, eta_prime2_;
  float at_normal_ = 1;
};

}  // namespace tress::inline v0_2::fiber
