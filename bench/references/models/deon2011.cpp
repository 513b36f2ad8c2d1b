#include "references/models/deon2011.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "base/color.h"
#include "base/pi.h"
#include "fiber/circle_ray.h"
#include "fiber/energy_table.h"
#include "fiber/event_constants.h"
#include "fiber/fiber_ids.h"
#include "fiber/lobe_widths.h"
#include "models/lobes/energy_conserving_lobe.h"
#include "models/lobes/lobe_choice.h"
#include "references/models/deon2011_azimuth.h"
#include "tress/adaptive/mixture.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float largest_blur = 0.25f * pi_f;
constexpr float least_energy = 1e-20f;  // of a lobe, luminance: below, it is 0
constexpr auto residual = static_cast<std::size_t>(Lobe::residual);

struct FiberConstants {
  LobeWidths widths;
  CircularFiber circle;
  LobeColors gain;
};

FiberConstants constants_of(const FiberParameters& parameters) {
  FiberConstants fiber{LobeWidths(parameters), {}, parameters.gain};
  const std::array<float, 3> sigmas = azimuthal_sigmas(parameters);
  const float reflected = std::sqrt(EnergyConservingLobe::variance_of(longitudinal_lambda(parameters, 0, 0)));
  fiber.circle.eta = parameters.eta;
  fiber.circle.sigma = Float4{std::min(reflected, largest_blur), sigmas[0], sigmas[1], sigmas[2]};
  fiber.circle.sigma_a = parameters.sigma_a * circle_radius(parameters.eccentricity);
  return fiber;
}

/// What depends on the known direction only.
struct DeonConstants {
  std::array<EnergyConservingLobe, detected_orders> longitudinal;
  std::array<glm::vec3, detected_orders> channel_weights;  ///< shares of the channels in the luminance of E_p
};

class Deon2011 final : public FiberModel {
 public:
  explicit Deon2011(int points) : quadrature_(points) {}

  std::string name() const override { return "deon2011"; }

  FiberId make_fiber(const FiberParameters& parameters) override {
    const auto [id, is_new] = ids_.find_or_add(parameters);
    if (is_new) fibers_.push_back(constants_of(parameters));
    return id;
  }

  std::size_t bytes() const override {
    return fibers_.capacity() * (sizeof(FiberConstants) + sizeof(FiberParameters)) +
           quadrature_.groups.capacity() * sizeof(OffsetQuadrature::Group);
  }

  FiberEvent make_event(FiberId id, const FiberDirection& wr, float xi1, float xi2, float /*h*/) const override {
    const FiberConstants& fiber = fibers_[id];
    FiberEvent event;
    event.fiber = id;
    event.wr = clamped(wr);
    event.xi1 = xi1;
    event.xi2 = xi2;
    const LobeWidths::At widths = fiber.widths.at(event.wr.theta);
    const auto lobe = [&](int p) {
      const int lane = LobeWidths::lane_of(p);
      return EnergyConservingLobe(event.wr.theta, widths.tilt[lane],
                                  EnergyConservingLobe::variance_of(widths.lambda[lane]));
    };
    auto* constants = new (place_of<DeonConstants>(event)) DeonConstants{{lobe(0), lobe(1), lobe(2), lobe(3)}, {}};
    const auto energies = circle_energies(quadrature_, fiber.circle, event.wr.theta);
    float sum = 0;
    for (std::size_t p = 0; p < energies.size(); ++p) {
      const glm::vec3 energy = energies[p] * fiber.gain[p], terms = luminance_terms(energy);
      const float total = terms.r + terms.g + terms.b;
      if (!(total > least_energy)) continue;
      event.energy[p] = energy;
      sum += event.selection[p] = total;
      if (p < detected_orders) constants->channel_weights[p] = terms / total;
    }
    if (!(sum > 0)) {
      event.selection[0] = sum = 1;
      constants->channel_weights[0] = glm::vec3(0, 1, 0);
    }
    for (float& probability : event.selection) probability /= sum;
    return event;
  }

  FiberSample sample_event(const FiberEvent& event, const std::array<float, 4>& u) const override {
    const DeonConstants& constants = constants_in<DeonConstants>(event);
    FiberSample sample;
    std::size_t lobe = 0;
    float below = 0;
    for (std::size_t p = 0; p < lobe_count; ++p) {
      if (!(event.selection[p] > 0)) continue;
      lobe = p;
      if (u[0] < below + event.selection[p]) break;
      below += event.selection[p];
    }
    sample.lobe = static_cast<Lobe>(lobe);
    sample.wi.theta = constants.longitudinal[width_of(lobe)].sample(u[1], u[3]);
    const AzimuthalTrace& trace = trace_at(event, sample.wi.theta);
    if (lobe == residual) {
      sample.wi.phi = adaptive::wrap_angle(pi_f * (2 * u[2] - 1));
    } else {
      const float azimuth =
          trace.sample(static_cast<int>(lobe), constants.channel_weights[lobe], u[2], standard_normal(u));
      sample.wi.phi = adaptive::wrap_angle(event.wr.phi + azimuth);
    }
    sample.value = value_at(event, constants, trace, sample.wi);
    return sample;
  }

  FiberValue evaluate_event(const FiberEvent& event, const FiberDirection& wi) const override {
    const FiberDirection at = clamped(wi);
    return value_at(event, constants_in<DeonConstants>(event), trace_at(event, at.theta), at);
  }

 private:
  /// The residual has the widths of TRRT.
  static std::size_t width_of(std::size_t lobe) { return std::min(lobe, std::size_t{detected_orders} - 1); }

  /// Independent of each number of u: a stream keyed by all of their bits.
  static float standard_normal(const std::array<float, 4>& u) {
    const auto bits = [&](std::size_t k) { return std::uint64_t{std::bit_cast<std::uint32_t>(u[k])}; };
    RandomStream random(bits(0) << 32 | bits(1), bits(2) << 32 | bits(3));
    const float radius = std::sqrt(-2 * std::log1p(-random.next()));  // Box and Muller
    return radius * std::cos(2 * pi_f * random.next());
  }

  /// This thread's trace, until its next one.
  const AzimuthalTrace& trace_at(const FiberEvent& event, float theta_i) const {
    thread_local AzimuthalTrace trace;
    trace.trace(quadrature_, fibers_[event.fiber].circle, 0.5f * (event.wr.theta - theta_i));
    return trace;
  }

  static FiberValue value_at(const FiberEvent& event, const DeonConstants& constants, const AzimuthalTrace& trace,
                             const FiberDirection& wi) {
    FiberValue value;
    const float phi = adaptive::wrap_angle(wi.phi - event.wr.phi);
    float m = 0;
    for (std::size_t p = 0; p < detected_orders; ++p) {
      if (!(event.selection[p] > 0)) continue;
      const glm::vec3 shape = trace.shape(static_cast<int>(p), phi);
      m = constants.longitudinal[p].density(wi.theta);
      value.s[p] = event.energy[p] * shape * m;
      value.pdf += event.selection[p] * glm::dot(constants.channel_weights[p], shape) * m;
    }
    if (event.selection[residual] > 0) {
      constexpr std::size_t trrt = detected_orders - 1;  // its M is the residual's, and the last one above
      if (!(event.selection[trrt] > 0)) m = constants.longitudinal[trrt].density(wi.theta);
      value.s[residual] = event.energy[residual] * (m * inverse_two_pi_f);
      value.pdf += event.selection[residual] * m * inverse_two_pi_f;
    }
    value.pdf = std::max(value.pdf, smallest_pdf);
    return value;
  }

  OffsetQuadrature quadrature_;
  FiberIds ids_;
  std::vector<FiberConstants> fibers_;
};

}  // namespace

std::unique_ptr<FiberModel> make_deon2011(const ModelSettings& settings) {
  return std::make_unique<Deon2011>(settings.quadrature_points > 0 ? settings.quadrature_points
                                                                   : deon2011_default_points);
}

}  // namespace tress::inline v0_2::fiber
