#include "references/models/deon2011_azimuth.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/gauss_legendre.h"
#include "base/pi.h"
#include "base/quarter_sine.h"
#include "fiber/surface_fresnel.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float least_mass = 1e-30f;

/// asin x, 0 <= x <= 1: Abramowitz and Stegun 4.4.46, absolute error some 2e-7 in floats.
Float4 arc_sine(Float4 x) {
  const Float4 series =
      1.5707963050f +
      x * (-0.2145988016f +
           x * (0.0889789874f +
                x * (-0.0501743046f +
                     x * (0.0308918810f + x * (-0.0170881256f + x * (0.0066700901f + x * -0.0012624911f))))));
  return 1.5707963268f - sqrt4(max4(1 - x, splat(0))) * series;
}

/// |wrap(x)|, the distance of x from the nearest multiple of 2 pi; |x| up to some hundred turns.
Float4 distance_from_0(Float4 x) {
  const Float4 turns = abs4(x) * inverse_two_pi_f;
  const Float4 whole = __builtin_convertvector(__builtin_convertvector(turns + 0.5f, Int4), Float4);
  return abs4(turns - whole) * (2 * pi_f);
}

/// What is the same for all offsets at one theta_d.
struct Plane {
  Plane(const CircularFiber& fiber, float theta_d) : eta2(fiber.eta * fiber.eta) {
    const float s = quarter_sine(theta_d), c = std::max(quarter_cosine(theta_d), 1e-6f);
    eta_prime2 = (eta2 - s * s) / (c * c);
    inverse_eta_prime = 1 / std::sqrt(eta_prime2);
    const float path = 2 / std::sqrt(1 - s * s / eta2);  // per cos gamma_t
    for (int channel = 0; channel < 3; ++channel) depth[channel] = -fiber.sigma_a[channel] * path;
  }
  float eta2, eta_prime2, inverse_eta_prime;
  glm::vec3 depth;
};

/// The surface at four offsets. A ray loses the same at every bounce: A_0 = F, A_p = (1 - F)^2 F^(p-1) T^p.
struct Surface {
  Surface(const Plane& plane, Float4 h) {
    const Float4 cosine = sqrt4(1 - h * h), inside = sqrt4(plane.eta_prime2 - h * h);
    reflected = SurfaceFresnel::reflectance(plane.eta2, cosine, inside);
    cos_gamma_t = inside * plane.inverse_eta_prime;
  }
  Float4 transmitted(const Plane& plane, int channel) const {
    return exp_of_negative(cos_gamma_t * plane.depth[channel]);
  }
  Float4 reflected, cos_gamma_t;
};

}  // namespace

OffsetQuadrature::OffsetQuadrature(int points) {
  const GaussLegendre rule = gauss_legendre(points);
  const std::size_t n = rule.node.size(), half = (n + 1) / 2;
  groups.assign((half + 3) / 4, Group{splat(0), splat(0), splat(0)});
  for (std::size_t i = 0; i < half; ++i) {
    Group& group = groups[i / 4];
    const double h = rule.node[n - 1 - i], weight = 0.5 * rule.weight[i];
    group.h[i % 4] = static_cast<float>(h);
    group.gamma[i % 4] = static_cast<float>(std::asin(h));
    group.weight[i % 4] = static_cast<float>(2 * i + 1 == n ? 0.5 * weight : weight);  // the middle is both sides
  }
}

std::array<glm::vec3, detected_orders + 1> circle_energies(const OffsetQuadrature& quadrature,
                                                           const CircularFiber& fiber, float theta_d) {
  const Plane plane(fiber, theta_d);
  Float4 sums[detected_orders + 1][3] = {};
  for (const OffsetQuadrature::Group& group : quadrature.groups) {
    const Surface surface(plane, group.h);
    const Float4 f = surface.reflected, weight = 2 * group.weight, entered = weight * (1 - f) * (1 - f);
    for (int channel = 0; channel < 3; ++channel) {
      const Float4 t = surface.transmitted(plane, channel), bounce = f * t;
      Float4 left = entered * t;
      sums[0][channel] += weight * f;
      for (int p = 1; p < detected_orders; ++p) {
        sums[p][channel] += left;
        left *= bounce;
      }
      sums[detected_orders][channel] += left / max4(1 - bounce, splat(1e-7f));
    }
  }
  std::array<glm::vec3, detected_orders + 1> energies{};
  for (std::size_t p = 0; p < energies.size(); ++p) {
    for (int channel = 0; channel < 3; ++channel) energies[p][channel] = sum4(sums[p][channel]);
  }
  return energies;
}

void AzimuthalTrace::trace(const OffsetQuadrature& quadrature, const CircularFiber& fiber, float theta_d) {
  const Plane plane(fiber, theta_d);
  Float4 sums[detected_orders][3] = {};
  for (Order& order : orders_) order.groups.resize(quadrature.groups.size());
  for (std::size_t i = 0; i < quadrature.groups.size(); ++i) {
    const OffsetQuadrature::Group& group = quadrature.groups[i];
    const Surface surface(plane, group.h);
    const Float4 gamma_t = arc_sine(group.h * plane.inverse_eta_prime);
    const Float4 f = surface.reflected, entered = group.weight * (1 - f) * (1 - f);
    // Phi_p = 2 p gamma_t - 2 gamma_i + p pi
    for (std::size_t p = 0; p < detected_orders; ++p) {
      const auto order = static_cast<float>(p);
      orders_[p].groups[i].azimuth = distance_from_0(order * (2 * gamma_t + pi_f) - 2 * group.gamma);
    }
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const Float4 t = surface.transmitted(plane, static_cast<int>(channel)), bounce = f * t;
      Float4 leaving = entered * t;
      const Float4 reflected = group.weight * f;
      sums[0][channel] += orders_[0].groups[i].weight[channel] = reflected;
      for (std::size_t p = 1; p < detected_orders; ++p) {
        sums[p][channel] += orders_[p].groups[i].weight[channel] = leaving;
        leaving *= bounce;
      }
    }
  }
  for (std::size_t p = 0; p < detected_orders; ++p) {
    Order& order = orders_[p];
    order.sigma = fiber.sigma[static_cast<int>(p)];
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const float mass = 2 * sum4(sums[p][channel]);
      order.mass[static_cast<int>(channel)] = mass;
      order.inverse_mass[static_cast<int>(channel)] = mass > least_mass ? 1 / mass : 0;
    }
  }
}

glm::vec3 AzimuthalTrace::shape(int p, float phi) const {
  const Order& order = orders_[static_cast<std::size_t>(p)];
  const float at = std::abs(phi), slope = -0.5f / (order.sigma * order.sigma);
  // At pi the next turn's Gaussian is e^-16 of the peak for sigma = 0.55; the one after that e^-72 for 45 degrees.
  const bool wide = order.sigma > 0.55f;
  Float4 red = splat(0), green = splat(0), blue = splat(0);
  for (const Group& group : order.groups) {
    const Float4 near = at - group.azimuth, sum = at + group.azimuth;
    const Float4 far = sum > splat(pi_f) ? 2 * pi_f - sum : sum;  // from the mirrored ray's exit
    Float4 detected = exp_of_negative(near * near * slope) + exp_of_negative(far * far * slope);
    if (wide) {
      const Float4 near_turned = 2 * pi_f - abs4(near), far_turned = 2 * pi_f - far;
      detected += exp_of_negative(near_turned * near_turned * slope) + exp_of_negative(far_turned * far_turned * slope);
    }
    red += group.weight[0] * detected;
    green += group.weight[1] * detected;
    blue += group.weight[2] * detected;
  }
  const Float4 total = sums4(red, green, blue);
  const float height = 1 / (order.sigma * std::sqrt(2 * pi_f));
  glm::vec3 shape;
  for (int channel = 0; channel < 3; ++channel) {
    const float inverse = order.inverse_mass[channel];
    shape[channel] = inverse > 0 ? total[channel] * inverse * height : inverse_two_pi_f;
  }
  return shape;
}

float AzimuthalTrace::sample(int p, const glm::vec3& channel_weights, float u, float normal) const {
  const Order& order = orders_[static_cast<std::size_t>(p)];
  const glm::vec3 scale = channel_weights * order.inverse_mass;
  // u picks a side, then runs over the rays of that side, which have half of the mass; dark channels come first.
  const float side = u < 0.5f ? -1.0f : 1.0f;
  float left = (u < 0.5f ? 2 * u : 2 * u - 1);
  for (int channel = 0; channel < 3; ++channel) {
    if (order.inverse_mass[channel] > 0) continue;
    if (left < channel_weights[channel]) {
      return adaptive::wrap_angle(side * pi_f * std::min(left / channel_weights[channel], 1.0f));
    }
    left -= channel_weights[channel];
  }
  left *= 0.5f;
  float azimuth = 0;  // where rounding leaves something of u: the last that has light
  const auto find = [&] {
    for (const Group& group : order.groups) {
      const Float4 share = scale.r * group.weight[0] + scale.g * group.weight[1] + scale.b * group.weight[2];
      for (int k = 0; k < 4; ++k) {
        if (!(share[k] > 0)) continue;
        azimuth = group.azimuth[k];
        if (left < share[k]) return;
        left -= share[k];
      }
    }
  };
  find();
  return adaptive::wrap_angle(side * azimuth + order.sigma * normal);
}

}  // namespace tress::inline v0_2::fiber
