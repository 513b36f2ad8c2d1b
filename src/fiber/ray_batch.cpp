#include "fiber/ray_batch.h"

#include <cmath>
#include <numbers>

// Loops over lanes are compiled twice, the second time for vectors of four doubles without fused operations, so the
// bits are the same. Sanitized builds have one version only, because sanitizers run before target clones can be
// resolved.
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define TRESS_SANITIZED
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TRESS_SANITIZED
#endif
#if defined(__x86_64__) && defined(__linux__) && !defined(TRESS_SANITIZED)
#define TRESS_WIDE [[gnu::target_clones("avx2", "default")]]
#else
#define TRESS_WIDE
#endif

namespace tress::inline v0_2::fiber {
namespace {

/// atan2 from the Cephes polynomial of atanf (error 1e-7), branch-free; 0 for (0, 0).
inline double arc_tangent(double y, double x) {
  constexpr double pi = std::numbers::pi;
  const double ax = std::abs(x), ay = std::abs(y);
  const double small = ax < ay ? ax : ay, big = ax < ay ? ay : ax;
  // tan(pi/8): above it atan r = pi/4 + atan((r - 1)/(r + 1)).
  const bool upper = small > 0.41421356237309503 * big;
  const double t = (upper ? small - big : small) / ((upper ? small + big : big) + 1e-300);
  const double z = t * t;
  double a = (((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z - 3.33329491539e-1) * z * t + t;
  a += upper ? pi / 4 : 0;
  a = ax < ay ? pi / 2 - a : a;
  a = x < 0 ? pi - a : a;
  return y < 0 ? -a : a;
}

inline double reflectance(double eta2, double eta_prime, double cos_air, double cos_inside) {
  const double inside = eta_prime * cos_inside, scaled = eta2 * cos_air;
  const double s = cos_air + inside, p = scaled + inside, inverse = 1 / (s * p);
  const double rs = (cos_air - inside) * p * inverse, rp = (scaled - inside) * s * inverse;
  return 0.5 * (rs * rs + rp * rp);
}

}  // namespace

RayBatch::RayBatch(const CrossSection& section, double h_0, double h_step, bool with_rates)
    : section_(section), with_rates_(with_rates) {
  const double e = section.eccentricity, eta_prime = section.eta_prime, eta2 = section.eta * section.eta;
  const double cos_phi = section.cos_phi_, sin_phi = section.sin_phi_;
  const double cos_entry = section.cos_entry_, sin_entry = section.sin_entry_, ratio = 1 / eta_prime;
  for (int i = 0; i < lanes; ++i) {
    const double h = h_0 + i * h_step, cos2_h = 1 - h * h;
    const double cos_h = std::sqrt(cos2_h > 0 ? cos2_h : 0);
    const double qx = cos_entry * cos_h - sin_entry * h, qy = sin_entry * cos_h + cos_entry * h;
    const double scale = 1 / std::sqrt(e * e * qx * qx + qy * qy);
    const double nx = e * qx * scale, ny = qy * scale;
    const double facing = nx * cos_phi + ny * sin_phi, cos_in = facing > 0 ? facing : 0;
    const double sin2_in = 1 - cos_in * cos_in;
    const double cos_t = std::sqrt(1 - (sin2_in > 0 ? sin2_in : 0) * ratio * ratio);
    const double reflected = reflectance(eta2, eta_prime, cos_in, cos_t);
    const double along = cos_in * ratio - cos_t;
    qx_[i] = qx;
    qy_[i] = qy;
    dx_[i] = along * nx - cos_phi * ratio;
    dy_[i] = along * ny - sin_phi * ratio;
    exit_x_[i] = 2 * cos_in * nx - cos_phi;
    exit_y_[i] = 2 * cos_in * ny - sin_phi;
    weight_[i] = reflected;
    left_[i] = 1 - reflected;
    path_[i] = 0;
    // Normals turn by e/(e^2 q_x^2 + q_y^2) of t; t turns by 1/cos_h of h.
    rate_t_[i] = 1 / (cos_h > 1e-12 ? cos_h : 1e-12);
    rate_delta_[i] = e * scale * scale * rate_t_[i] * (1 - cos_in * ratio / cos_t);
  }
}

template <bool with_rates>
[[gnu::always_inline]] inline void RayBatch::step() {
  const double e = section_.eccentricity, inverse_e = 1 / e, eta_prime = section_.eta_prime;
  const double eta2 = section_.eta * section_.eta, eta_prime2 = eta_prime * eta_prime;
  const double to_3d = section_.inverse_cos_theta_t_;
  for (int i = 0; i < lanes; ++i) {
    double dx = dx_[i], dy = dy_[i], qx = qx_[i], qy = qy_[i];
    const double dqy = dy * inverse_e;
    const double inverse_square = 1 / (dx * dx + dqy * dqy);
    const double across = -2 * (qx * dx + qy * dqy) * inverse_square;
    const double chord = across > 0 ? across : 0;
    path_[i] += chord * to_3d;
    qx += chord * dx;
    qy += chord * dqy;
    const double onto_circle = 1.5 - 0.5 * (qx * qx + qy * qy);
    qx *= onto_circle;
    qy *= onto_circle;
    const double scale = 1 / std::sqrt(e * e * qx * qx + qy * qy);
    const double nx = e * qx * scale, ny = qy * scale;
    const double cos_inside = dx * nx + dy * ny;
    const double sin2 = (1 - cos_inside * cos_inside) * eta_prime2, cos2_t = sin2 > 0 ? 1 - sin2 : 1;
    const double cos_t = std::sqrt(cos2_t > 0 ? cos2_t : 0);
    const double kept = reflectance(eta2, eta_prime, cos_t, cos_inside);
    const double normal = cos_t - eta_prime * cos_inside;
    exit_x_[i] = eta_prime * dx + normal * nx;
    exit_y_[i] = eta_prime * dy + normal * ny;
    if constexpr (with_rates) {
      const double rate_t = 2 * rate_delta_[i] * inverse_e * inverse_square - rate_t_[i];
      const double rate_nu = e * scale * scale * rate_t;
      cos_exit_[i] = cos_t;
      spread_[i] = rate_nu * cos_t + eta_prime * cos_inside * (rate_delta_[i] - rate_nu);
      rate_t_[i] = rate_t;
      rate_delta_[i] = 2 * rate_nu - rate_delta_[i];
    }
    weight_[i] = left_[i] * (1 - kept);
    left_[i] *= kept;
    dx -= 2 * cos_inside * nx;
    dy -= 2 * cos_inside * ny;
    const double onto_unit = 1.5 - 0.5 * (dx * dx + dy * dy);
    qx_[i] = qx;
    qy_[i] = qy;
    dx_[i] = dx * onto_unit;
    dy_[i] = dy * onto_unit;
  }
}

TRESS_WIDE void RayBatch::step_without_rates() { step<false>(); }
TRESS_WIDE void RayBatch::step_with_rates() { step<true>(); }

void RayBatch::advance() { with_rates_ ? step_with_rates() : step_without_rates(); }

void RayBatch::glint_shares(double sigma, double* out) const {
  for (int i = 0; i < lanes; ++i) {
    const double reach = 4 * sigma * cos_exit_[i], reach2 = reach * reach;
    out[i] = reach2 / (reach2 + spread_[i] * spread_[i] + 1e-300);
  }
}

void RayBatch::azimuths(float* out) const {
  const double cos_phi = section_.cos_phi_, sin_phi = section_.sin_phi_;
  for (int i = 0; i < lanes; ++i) {
    out[i] = static_cast<float>(
        arc_tangent(cos_phi * exit_y_[i] - sin_phi * exit_x_[i], cos_phi * exit_x_[i] + sin_phi * exit_y_[i]));
  }
}

}  // namespace tress::inline v0_2::fiber
