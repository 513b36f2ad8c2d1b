#include "references/models/deon2022.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <numbers>
#include <utility>
#include <vector>

#include "base/color.h"
#include "base/exp_of_negative.h"
#include "base/pi.h"
#include "fiber/circle_ray.h"
#include "fiber/event_constants.h"
#include "fiber/fiber_ids.h"
#include "fiber/longitudinal.h"
#include "fiber/row_axes.h"
#include "models/lobes/lobe_choice.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr std::size_t r = 0, tt = 1, lobe_kinds = 3;  // then TRT
constexpr float any_azimuth = 0.1f;                   // share of the draws of TT
constexpr int energy_steps = 48, energy_points = 48;
using ByLobe = std::array<glm::vec3, lobe_kinds>;

float root(float x) { return std::sqrt(std::max(x, 0.0f)); }

float gaussian(float x, float width) {
  constexpr float peak = 0.5f * std::numbers::inv_sqrtpi_v<float> * std::numbers::sqrt2_v<float>;
  return peak / width * exp_of_negative(-0.5f * (x / width) * (x / width));
}

float schlick(float eta, float cosine) {
  const float at_normal = (eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1)), c = 1 - std::clamp(cosine, 0.0f, 1.0f);
  return at_normal + (1 - at_normal) * c * c * c * c * c;
}

glm::vec3 kept(const glm::vec3& sigma_a, float length) {
  return {exp_of_negative(-sigma_a.x * length), exp_of_negative(-sigma_a.y * length),
          exp_of_negative(-sigma_a.z * length)};
}

/// 1/eta' for an inclination.
float inverse_index(float eta, float theta_d) {
  const float s = std::sin(theta_d);
  return std::cos(theta_d) / std::sqrt(eta * eta - s * s);
}

/// Offset, >= 0, whose TT leaves at phi. It is 1 where none does.
float offset_of(float a, float phi) {
  const float c = std::cos(phi);
  return std::min(root((0.5f + 0.5f * c) / (1 + a * a - 2 * a * root(0.5f - 0.5f * c))), 1.0f);
}

/// Density of the azimuth of TT for uniform offsets.
float smooth_density(float a, float phi) {
  if (std::abs(phi) < 2.001f * std::asin(a)) return 0;
  const float h = offset_of(a, phi);
  const float across = root(1 - h * h);
  return across > 0 ? 1 / (4 * (1 / across - a / root(1 - a * a * h * h))) : 0;
}

/// The three Gaussians of TRT.
struct Bumps {
  float place, weight_beside, weight_middle, width_beside, width_middle;

  Bumps(float roughness, float theta_d) {
    const float t = std::abs(theta_d), t2 = t * t;
    float squares_beside, squares_middle;
    if (t < 0.525f) {
      place = std::cos(t) - 0.733f;
      weight_beside = 0.00023939f + 0.000111282f * t * (0.103125f - t) + std::pow(t, 15.7265f);
      weight_middle = 0.000322755f * (0.991977f + (t - std::pow(1.80972f * t, 16.7669f)) * std::tan(t));
      squares_beside = 0.00597578f + 0.000428897f * std::cos(5.41149f * t);
      squares_middle = 0.0181f * std::tan(std::cos(2.121f * t));
    } else if (t < 1.1f) {
      place = std::max(0.0f, 0.00493f + 0.579f * t - 0.775f * t2);
      weight_beside = 0.00108f - 0.0014f * t + 0.0003937f * t2;
      weight_middle = -0.00119f + 0.00219f * t;
      squares_beside = 0.0391f - 0.0888f * t + 0.0581f * t2;
      squares_middle = 0.384f - 1.14f * t + 0.942f * t2;
    } else {
      place = weight_beside = 0;
      weight_middle = 0.000239f + 0.00139f * t2 * t - 0.00053124f * t2 * t2 * t;
      squares_beside = 1;
      squares_middle = -1.86f + 2.73f * t - 0.7437f * t2;
    }
    width_beside = roughness / 0.06f * root(squares_beside);
    width_middle = roughness / 0.06f * root(squares_middle);
  }
  float density(float phi) const {
    const float beside = gaussian(phi - place, width_beside) + gaussian(phi + place, width_beside);
    return std::max(200 / pi_f * (weight_beside * beside + weight_middle * gaussian(phi, width_middle)), 0.0f);
  }
};

/// Cosine of the inclination inside.
float inner_cosine(float eta, float theta_d) {
  const float s = std::sin(theta_d) / eta;
  return std::sqrt(1 - s * s);
}

/// Standard deviations of M in theta_h.
float width_of(std::size_t lobe, float eta, float roughness, float theta_i, float phi) {
  if (lobe == r) return roughness * (std::numbers::sqrt2_v<float> / 2) * std::max(0.01f, std::cos(0.5f * phi));
  if (lobe == tt) return 0.25f * roughness * std::sqrt(eta * eta - 1) / std::max(std::cos(theta_i), 1e-5f);
  return 0.5f * roughness * (2 + std::pow(std::abs(theta_i), 1.5f));
}

float tilt_of(std::size_t lobe, float tilt) { return lobe == r ? -tilt : lobe == tt ? 0.5f * tilt : 1.5f * tilt; }

struct Fiber {
  glm::vec3 sigma_a{0.0f};  ///< per radius
  std::array<ByLobe, energy_steps + 1> energy;
};

class Deon2022 final : public FiberModel {
 public:
  std::string name() const override { return "deon2022"; }

  FiberId make_fiber(const FiberParameters& parameters) override {
    const auto [id, is_new] = ids_.find_or_add(parameters);
    if (!is_new) return id;
    Fiber fiber;
    fiber.sigma_a = parameters.sigma_a * circle_radius(parameters.eccentricity);
    for (int i = 0; i <= energy_steps; ++i)
      fiber.energy[static_cast<std::size_t>(i)] =
          energies(parameters, fiber.sigma_a, half_pi * (2 * static_cast<float>(i) / energy_steps - 1));
    fibers_.push_back(fiber);
    return id;
  }

  FiberEvent make_event(FiberId id, const FiberDirection& wr, float xi1, float xi2, float /*h*/) const override {
    const FiberParameters& parameters = ids_[id];
    FiberEvent event;
    event.fiber = id;
    event.wr = clamped(wr);
    event.xi1 = xi1;
    event.xi2 = xi2;
    const float theta_r = event.wr.theta, x = (theta_r / half_pi + 1) * (0.5f * energy_steps);
    const auto i = static_cast<std::size_t>(std::clamp(x, 0.0f, energy_steps - 1.0f));
    const float part = std::clamp(x - static_cast<float>(i), 0.0f, 1.0f);
    new (place_of<Deon2022Draws>(event)) Deon2022Draws(parameters.eta, parameters.roughness, theta_r);
    float sum = 0;
    for (std::size_t p = 0; p < lobe_kinds; ++p) {
      const auto& table = fibers_[id].energy;
      event.energy[p] = parameters.gain[p] * ((1 - part) * table[i][p] + part * table[i + 1][p]);
      sum += event.selection[p] = luminance(event.energy[p]);
    }
    if (!(sum > smallest_pdf)) event.selection[r] = sum = 1;
    for (std::size_t p = 0; p < lobe_kinds; ++p) event.selection[p] /= sum;
    return event;
  }

  FiberSample sample_event(const FiberEvent& event, const std::array<float, 4>& u) const override {
    const Deon2022Draws& draws = constants_in<Deon2022Draws>(event);
    const std::size_t p = choose_lobe(event, u[0]);
    FiberSample sample;
    sample.lobe = static_cast<Lobe>(p);
    const float phi =
        p == r ? 2 * std::asin(std::clamp(2 * u[2] - 1, -1.0f, 1.0f)) : draws.sample(static_cast<int>(p), u[2], u[3]);
    sample.wi.theta = proposal(event, p, phi).sample(u[1]);
    sample.wi.phi = adaptive::wrap_angle(event.wr.phi + phi);
    sample.value = value_at(event, sample.wi);
    return sample;
  }

  FiberValue evaluate_event(const FiberEvent& event, const FiberDirection& wi) const override {
    return value_at(event, clamped(wi));
  }

  std::size_t bytes() const override {
    return fibers_.capacity() * sizeof(Fiber) + ids_.size() * sizeof(FiberParameters);
  }

 private:
  /// S of a lobe without gain.
  static glm::vec3 value_of(std::size_t p, const FiberParameters& fiber, const glm::vec3& sigma_a, float theta_r,
                            float theta_i, float phi) {
    const float theta_h = 0.5f * (theta_i + theta_r), theta_d = 0.5f * (theta_r - theta_i);
    const float cos_d = std::max(std::cos(theta_d), 1e-9f), ratio = std::min(std::cos(theta_i) / cos_d, 2.0f);
    const float m = gaussian(theta_h - tilt_of(p, fiber.tilt), width_of(p, fiber.eta, fiber.roughness, theta_i, phi));
    const float longitudinal = 0.5f * m * ratio * ratio;
    if (p != r)
      return longitudinal * deon2022_azimuthal(static_cast<int>(p), fiber.eta, fiber.roughness, sigma_a, theta_d, phi);
    const float between = std::sin(theta_i) * std::sin(theta_r) + std::cos(theta_i) * std::cos(theta_r) * std::cos(phi);
    const float reflected = schlick(fiber.eta, root(0.5f + 0.5f * between));
    return glm::vec3(longitudinal * reflected * 0.25f * std::max(std::cos(0.5f * phi), 0.0f));
  }

  /// Integrals of value_of() over all directions, by midpoints, of theta_i about each lobe.
  static ByLobe energies(const FiberParameters& fiber, const glm::vec3& sigma_a, float theta_r) {
    ByLobe sum{};
    for (std::size_t p = 0; p < lobe_kinds; ++p) {
      for (int k = 0; k < energy_points; ++k) {
        const float phi = pi_f * (static_cast<float>(k) + 0.5f) / energy_points;  // the other half is alike
        const float width = 12 * width_of(p, fiber.eta, fiber.roughness, theta_r, phi),
                    middle = 2 * tilt_of(p, fiber.tilt) - theta_r;
        const float from = std::clamp(middle - width, -half_pi, half_pi),
                    to = std::clamp(middle + width, -half_pi, half_pi);
        const float step = (to - from) / energy_points, weight = 2 * step * pi_f / energy_points;
        for (int i = 0; i < energy_points; ++i)
          sum[p] += weight * value_of(p, fiber, sigma_a, theta_r, from + (static_cast<float>(i) + 0.5f) * step, phi);
      }
    }
    return sum;
  }

  LongitudinalLobe proposal(const FiberEvent& event, std::size_t p, float phi) const {
    const FiberParameters& fiber = ids_[event.fiber];
    const float width = std::min(width_of(p, fiber.eta, fiber.roughness, event.wr.theta, phi), 1.0f);
    return {event.wr.theta, tilt_of(p, fiber.tilt), width * lambda_of_cauchy, LongitudinalShape::cauchy};
  }

  FiberValue value_at(const FiberEvent& event, const FiberDirection& wi) const {
    const Deon2022Draws& draws = constants_in<Deon2022Draws>(event);
    const FiberParameters& fiber = ids_[event.fiber];
    const float phi = adaptive::wrap_angle(wi.phi - event.wr.phi);
    const glm::vec3& sigma_a = fibers_[event.fiber].sigma_a;
    const std::array<float, lobe_kinds> azimuthal{0.25f * std::max(std::cos(0.5f * phi), 0.0f), draws.density(1, phi),
                                                  draws.density(2, phi)};
    FiberValue value;
    for (std::size_t p = 0; p < lobe_kinds; ++p) {
      value.s[p] = fiber.gain[p] * value_of(p, fiber, sigma_a, event.wr.theta, wi.theta, phi);
      if (event.selection[p] > 0)
        value.pdf += event.selection[p] * azimuthal[p] * proposal(event, p, phi).density(wi.theta);
    }
    value.pdf = std::max(value.pdf, smallest_pdf);
    return value;
  }

  FiberIds ids_;
  std::vector<Fiber> fibers_;  ///< by id
};

}  // namespace

glm::vec3 deon2022_azimuthal(int p, float eta, float roughness, const glm::vec3& sigma_a, float theta_d, float phi) {
  const float cos_t = inner_cosine(eta, theta_d);
  if (p == 2) return Bumps(roughness, theta_d).density(phi) * kept(sigma_a, 3.75f / cos_t);
  const float a = inverse_index(eta, theta_d), density = smooth_density(a, phi);
  if (!(density > 0)) return glm::vec3(0.0f);
  const float h = offset_of(a, phi), entering = 1 - schlick(eta, std::cos(theta_d) * root(1 - h * h));
  return density * entering * entering * kept(sigma_a, 2 * root(1 - a * a * h * h) / cos_t);
}

Deon2022Draws::Deon2022Draws(float eta, float roughness, float theta_d) : a_(inverse_index(eta, theta_d)) {
  constexpr float least_width = 0.01f;
  const Bumps bumps(roughness, theta_d);
  beside_ = AzimuthalBump(bumps.place, std::max(bumps.width_beside, least_width));
  middle_ = AzimuthalBump(0, std::max(bumps.width_middle, least_width));
}

float Deon2022Draws::density(int p, float phi) const {
  if (p == 2) return 0.5f * (beside_.pdf(phi) + middle_.pdf(phi));
  return any_azimuth / (2 * pi_f) + (1 - any_azimuth) * smooth_density(a_, phi);
}

float Deon2022Draws::sample(int p, float u_phi, float u_other) const {
  if (p == 2) return (u_other < 0.5f ? beside_ : middle_).sample(u_phi);
  const float x = 2 * u_phi - 1;
  return adaptive::wrap_angle(u_other < any_azimuth ? pi_f * x : pi_f + 2 * std::asin(x) - 2 * std::asin(a_ * x));
}

std::unique_ptr<FiberModel> make_deon2022(const ModelSettings&) { return std::make_unique<Deon2022>(); }

}  // namespace tress::inline v0_2::fiber
