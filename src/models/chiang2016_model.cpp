#include "tress/fiber/chiang2016_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <numbers>
#include <vector>

#include "base/color.h"
#include "base/exp_of_negative.h"
#include "base/pi.h"
#include "fiber/circle_ray.h"
#include "fiber/energy_table.h"
#include "fiber/event_constants.h"
#include "fiber/fiber_ids.h"
#include "fiber/lobe_widths.h"
#include "models/lobes/energy_conserving_lobe.h"
#include "models/lobes/lobe_choice.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {
namespace {

/// The lobes by order p; the last is everything after TRT.
constexpr std::array<Lobe, 4> lobes{Lobe::r, Lobe::tt, Lobe::trt, Lobe::residual};

/// Logistic of scale s about mu, truncated to the circle, with mass 1. Radians.
struct TrimmedLogistic {
  float mu = 0, inverse_s = 1;
  float mass = 1;  ///< tanh(pi/(2 s)), of the logistic within half a turn

  float density(float phi) const {
    const float e = exp_of_negative(-std::abs(adaptive::wrap_angle(phi - mu)) * inverse_s);
    return e * inverse_s / (mass * (1 + e) * (1 + e));
  }
  float sample(float u) const {
    const float v = std::clamp((2 * u - 1) * mass, -0.99999994f, 0.99999994f);
    return adaptive::wrap_angle(mu + std::clamp(2 * std::atanh(v) / inverse_s, -pi_f, pi_f));
  }
};

struct EventConstants {
  std::array<EnergyConservingLobe, 4> longitudinal;
  std::array<TrimmedLogistic, 3> azimuthal;
};

/// The data of a fiber that do not depend on the direction.
struct Fiber {
  LobeWidths widths;
  glm::vec3 sigma_a;  ///< per radius of the circle
  std::array<TrimmedLogistic, 3> azimuthal;
};

/// Replaces widths by the published ones, if the fiber was given by them.
FiberParameters as_published(FiberParameters fiber) {
  if (!fiber.published_widths) return fiber;
  std::ranges::copy(fiber.published_widths->longitudinal_lambda, fiber.longitudinal_lambda.begin());
  std::ranges::copy(fiber.published_widths->azimuthal_sigma, fiber.azimuthal_sigma.begin());
  return fiber;
}

class Chiang2016 final : public FiberModel {
 public:
  std::string name() const override { return "chiang2016"; }

  FiberId make_fiber(const FiberParameters& given) override {
    const auto [id, is_new] = ids_.find_or_add(given);
    if (!is_new) return id;
    const FiberParameters parameters = as_published(given);
    Fiber fiber{LobeWidths(parameters), parameters.sigma_a * circle_radius(parameters.eccentricity), {}};
    const auto sigmas = azimuthal_sigmas(parameters);
    const float of_r = std::sqrt(EnergyConservingLobe::variance_of(longitudinal_lambda(parameters, 0, 0)));
    for (std::size_t p = 0; p < fiber.azimuthal.size(); ++p) {
      float sigma = sigmas[p == 0 ? 0 : p - 1];
      if (p == 0 && !parameters.azimuthal_sigma[0]) sigma = std::min(of_r, 0.25f * pi_f);
      const float inverse_s = pi_f * std::numbers::inv_sqrt3_v<float> / sigma;
      fiber.azimuthal[p] = {0, inverse_s, std::tanh(0.5f * pi_f * inverse_s)};
    }
    fibers_.push_back(fiber);
    return id;
  }

  FiberEvent make_event(FiberId id, const FiberDirection& wr, float xi1, float xi2, float h) const override {
    const Fiber& fiber = fibers_[id];
    const FiberParameters& parameters = ids_[id];
    FiberEvent event;
    event.fiber = id;
    event.wr = clamped(wr);
    event.xi1 = xi1;
    event.xi2 = xi2;

    const CircleRay ray(parameters.eta, event.wr.theta, h);
    const glm::vec3 one_way = ray.transmittance(fiber.sigma_a);
    const float f = ray.reflectance, in_and_out = (1 - f) * (1 - f);
    std::array<glm::vec3, 4> energy{glm::vec3(f), in_and_out * one_way, in_and_out * f * one_way * one_way,
                                    glm::vec3(0.0f)};
    for (int c = 0; c < 3; ++c) {
      const float once_more = f * one_way[c];
      if (once_more < 1) energy[3][c] = energy[2][c] * once_more / (1 - once_more);
    }
    float sum = 0;
    for (std::size_t p = 0; p < lobes.size(); ++p) {
      const auto lobe = static_cast<std::size_t>(lobes[p]);
      event.energy[lobe] = energy[p] * parameters.gain[lobe];
      sum += event.selection[lobe] = luminance(event.energy[lobe]);
    }
    if (!(sum > 0)) sum = event.selection[0] = 1;
    for (float& probability : event.selection) probability /= sum;

    const LobeWidths::At widths = fiber.widths.at(event.wr.theta);
    const auto longitudinal = [&](int p) {
      const int lane = LobeWidths::lane_of(p);
      return EnergyConservingLobe(event.wr.theta, widths.tilt[lane],
                                  EnergyConservingLobe::variance_of(widths.lambda[lane]));
    };
    auto* constants = new (place_of<EventConstants>(event))
        EventConstants{{longitudinal(0), longitudinal(1), longitudinal(2), longitudinal(3)}, fiber.azimuthal};
    for (int p = 0; p < 3; ++p)
      constants->azimuthal[static_cast<std::size_t>(p)].mu = adaptive::wrap_angle(event.wr.phi + ray.exit_azimuth(p));
    return event;
  }

  FiberSample sample_event(const FiberEvent& event, const std::array<float, 4>& u) const override {
    const EventConstants& constants = constants_in<EventConstants>(event);
    std::size_t p = 0;
    float below = 0;
    for (std::size_t k = 0; k < lobes.size(); ++k) {
      const float probability = event.selection[static_cast<std::size_t>(lobes[k])];
      if (!(probability > 0)) continue;
      p = k;
      if (u[0] < (below += probability)) break;
    }
    FiberSample sample;
    sample.lobe = lobes[p];
    sample.wi.theta = constants.longitudinal[p].sample(u[1], u[3]);
    sample.wi.phi = p < constants.azimuthal.size() ? constants.azimuthal[p].sample(u[2])
                                                   : adaptive::wrap_angle(pi_f * (2 * u[2] - 1));
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
  static FiberValue value_at(const FiberEvent& event, const FiberDirection& wi) {
    const EventConstants& constants = constants_in<EventConstants>(event);
    FiberValue value;
    for (std::size_t p = 0; p < lobes.size(); ++p) {
      const auto lobe = static_cast<std::size_t>(lobes[p]);
      if (!(event.selection[lobe] > 0)) continue;
      const float azimuthal = p < constants.azimuthal.size() ? constants.azimuthal[p].density(wi.phi)
                                                             : 0.5f * std::numbers::inv_pi_v<float>;
      const float density = constants.longitudinal[p].density(wi.theta) * azimuthal;
      value.s[lobe] = event.energy[lobe] * density;
      value.pdf += event.selection[lobe] * density;
    }
    value.pdf = std::max(value.pdf, smallest_pdf);
    return value;
  }

  FiberIds ids_;
  std::vector<Fiber> fibers_;  ///< by id
};

}  // namespace

std::unique_ptr<FiberModel> make_chiang2016_model() { return std::make_unique<Chiang2016>(); }

}  // namespace tress::inline v0_2::fiber
