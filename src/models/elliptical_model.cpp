// The assembled BCSDF of the elliptical fiber (ESTIMATOR.md, E5):
//   S = sum_p E_p M_p N^_p,   Q = sum_p P_p M_p q_p,   both densities in dtheta_i dphi_i.
#include "tress/fiber/elliptical_model.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>
#include <type_traits>
#include <vector>

#include "fiber/longitudinal.h"
#include "fiber/reflection.h"
#include "models/fiber_record.h"
#include "models/row_reader.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/random.h"

namespace tress::fiber {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr float inverse_two_pi = 0.5f * std::numbers::inv_pi_v<float>;
constexpr float smallest_pdf = 1e-30f;  // where every lobe has underflowed; S is 0 there
constexpr int nothing_drawn = -1;
constexpr auto residual = static_cast<std::size_t>(Lobe::residual);

/// Probability that `corrected` traces a direction: 2^-4, decided by the leading bits of a hash.
constexpr int correction_bits = 4;
constexpr float correction_factor = 1 << correction_bits;

std::uint64_t hash_of(float a, float b, std::uint64_t before) {
  return mix_bits(before + ((std::uint64_t{std::bit_cast<std::uint32_t>(a)} << 32) | std::bit_cast<std::uint32_t>(b)));
}

/// What depends on the known direction only: computed once per event, used by every direction of it.
struct EventConstants {
  ReflectionLobe reflection;
  std::array<LongitudinalLobe, 3> longitudinal;  ///< TT, TRT, TRRT; the residual shares TRRT's
  FoldedAzimuth fold;
  std::uint64_t hash;  ///< of xi and the known direction
};
static_assert(sizeof(EventConstants) <= sizeof(FiberEvent::model_constants));
static_assert(std::is_trivially_copyable_v<EventConstants>);

void keep(const EventConstants& constants, FiberEvent& event) {
  std::memcpy(event.model_constants.data(), &constants, sizeof constants);
}

EventConstants constants_of(const FiberEvent& event) {
  std::array<std::byte, sizeof(EventConstants)> bytes;
  std::memcpy(bytes.data(), event.model_constants.data(), sizeof bytes);
  return std::bit_cast<EventConstants>(bytes);
}

class EllipticalModel final : public FiberModel {
 public:
  EllipticalModel(Estimator estimator, adaptive::Service* service) : estimator_(estimator), service_(service) {
    assert(estimator == Estimator::exact || service != nullptr);
  }

  std::string name() const override { return "elliptical"; }

  FiberId add_fiber(const FiberParameters& parameters) override {
    for (std::size_t i = 0; i < fibers_.size(); ++i) {
      if (fibers_[i].parameters == parameters) return static_cast<FiberId>(i);
    }
    fibers_.emplace_back(parameters, energies_.find(energy_key(parameters)), rows());
    return static_cast<FiberId>(fibers_.size() - 1);
  }

  void rows_changed() override {
    for (FiberRecord& fiber : fibers_) {
      for (LobePage& lobe : fiber.pages) lobe.take_over(*service_, service_->last_changes(), fiber.parameters.sigma_a);
    }
  }

  FiberEvent begin(FiberId id, const FiberDirection& wr, float xi1, float xi2) const override {
    const FiberRecord& fiber = fibers_[id];
    FiberEvent event;
    event.fiber = id;
    event.wr = clamped(wr);
    event.xi1 = xi1;
    event.xi2 = xi2;
    event.energy = fiber.energies.at(event.wr.phi, event.wr.theta).colored;
    float sum = 0;
    for (std::size_t p = 0; p < lobe_count; ++p) sum += event.selection[p] = luminance(event.energy[p]);
    if (!(sum > 0)) {
      event.selection = {};
      event.selection[0] = sum = 1;
    }
    for (float& probability : event.selection) probability /= sum;
    keep({make_reflection(fiber, event),
          {make_longitudinal(fiber, event, 1), make_longitudinal(fiber, event, 2), make_longitudinal(fiber, event, 3)},
          fold_azimuth(event.wr.phi),
          hash_of(event.wr.theta, event.wr.phi, hash_of(xi1, xi2, 0))},
         event);
    return event;
  }

  FiberSample sample(const FiberEvent& event, const std::array<float, 4>& u) const override {
    const FiberRecord& fiber = fibers_[event.fiber];
    const EventConstants constants = constants_of(event);
    FiberSample sample;
    int p = 0;
    float below = 0, chosen = 0;
    for (int lobe = 0; lobe < lobe_count; ++lobe) {
      const float probability = event.selection[static_cast<std::size_t>(lobe)];
      if (!(probability > 0)) continue;
      p = lobe;
      chosen = probability;
      if (u[0] < below + probability) break;
      below += probability;
    }
    sample.lobe = static_cast<Lobe>(p);
    const float spare = std::clamp((u[0] - below) / chosen, 0.0f, 0.99999994f);
    RowQuery row;
    if (p == 0) {
      const ReflectionLobe& reflection = constants.reflection;
      sample.wi.phi = reflection.sample_azimuth(u[2]);
      sample.wi.theta = reflection.longitudinal(sample.wi.phi).sample(u[1]);
    } else {
      sample.wi.theta = constants.longitudinal[static_cast<std::size_t>(std::min(p, 3) - 1)].sample(u[1]);
      float x = pi * (2 * u[2] - 1);
      if (p <= 3) {
        const RowReader reader(fiber, rows(), event, constants.fold.phi, p);
        const float theta_d = difference_angle(event.wr, sample.wi);
        row = reader.find(theta_d);
        x = reader.sample(row, theta_d, spare, u[2], u[3]);
      }
      sample.wi.phi = constants.fold.absolute(x, event.wr.phi);
    }
    sample.value = value_at(event, constants, sample.wi, p, row);
    return sample;
  }

  FiberValue evaluate(const FiberEvent& event, const FiberDirection& wi) const override {
    return value_at(event, constants_of(event), clamped(wi), nothing_drawn, {});
  }

 private:
  adaptive::Service* rows() const { return estimator_ == Estimator::exact ? nullptr : service_; }

  /// Whether `corrected` traces this direction, for all lobes, and where its rays are placed, in [0, 1): pure functions
  /// of the event and the direction, so that sample() and evaluate() agree. Any bit of xi or of a direction changes the
  /// whole hash.
  std::optional<float> correction(const EventConstants& constants, const FiberDirection& wi) const {
    if (estimator_ != Estimator::corrected) return {};
    const std::uint64_t hash = hash_of(wi.theta, wi.phi, constants.hash);
    if (hash >> (64 - correction_bits) != 0) return {};
    return static_cast<float>(hash & 0xffffff) * 0x1p-24f;
  }

  static FiberDirection clamped(const FiberDirection& w) {
    return {std::clamp(w.theta, -half_pi, half_pi), adaptive::wrap_angle(w.phi)};
  }

  static float difference_angle(const FiberDirection& wr, const FiberDirection& wi) {
    return 0.5f * std::fabs(wr.theta - wi.theta);
  }

  static ReflectionLobe make_reflection(const FiberRecord& fiber, const FiberEvent& event) {
    const FiberParameters& parameters = fiber.parameters;
    return {parameters.eta,
            parameters.eccentricity,
            event.wr.theta,
            event.wr.phi,
            event.energy[0].r,
            lobe_tilt(parameters, 0),
            longitudinal_lambda(parameters, 0, event.wr.theta)};
  }

  static LongitudinalLobe make_longitudinal(const FiberRecord& fiber, const FiberEvent& event, int p) {
    const float tilt = lobe_tilt(fiber.parameters, p) + roughness_shift(fiber.parameters, p, event.wr.theta);
    return {event.wr.theta, tilt, longitudinal_lambda(fiber.parameters, p, event.wr.theta)};
  }

  /// S and Q at wi. drawn: the lobe that drew wi, whose row (if it has one) was then looked up as `known`.
  FiberValue value_at(const FiberEvent& event, const EventConstants& constants, const FiberDirection& wi, int drawn,
                      const RowQuery& known) const {
    const FiberRecord& fiber = fibers_[event.fiber];
    FiberValue value;
    if (event.selection[0] > 0) {
      const ReflectionLobe& reflection = constants.reflection;
      const float m = reflection.longitudinal(wi.phi).density(wi.theta);
      value.s[0] = glm::vec3(reflection.energy_density(wi.phi) * m);
      value.pdf += event.selection[0] * reflection.azimuth_pdf(wi.phi) * m;
    }
    const float x = constants.fold.relative(wi.phi, event.wr.phi);
    const float theta_d = difference_angle(event.wr, wi);
    float m = 0;  // the residual shares TRRT's longitudinal lobe
    bool trrt_known = false;
    const std::optional<float> correct = correction(constants, wi);
    for (int p = 1; p < lobe_count; ++p) {
      const auto lobe = static_cast<std::size_t>(p);
      if (!(event.selection[lobe] > 0)) continue;
      if (lobe != residual || !trrt_known) {
        m = constants.longitudinal[static_cast<std::size_t>(std::min(p, 3) - 1)].density(wi.theta);
      }
      trrt_known = p == 3;
      RowValue azimuthal{glm::vec3(inverse_two_pi), inverse_two_pi};
      if (p <= 3) {
        const RowReader reader(fiber, rows(), event, constants.fold.phi, p);
        bool exact = false;
        const RowQuery row = p == drawn ? known : reader.find(theta_d);
        azimuthal = reader.evaluate(row, theta_d, x, p == drawn, &exact);
        if (correct) {
          azimuthal.shape += correction_factor * reader.residual(azimuthal.shape, theta_d, x, *correct);
          exact = true;
        }
        value.queries += row.uniform ? 0 : 1;
        value.exact_queries += exact && !row.uniform ? 1 : 0;
        if (rows() != nullptr && !row.uniform) value.objective += row.view.objective;
      }
      value.s[lobe] = event.energy[lobe] * azimuthal.shape * m;
      value.pdf += event.selection[lobe] * azimuthal.proposal * m;
    }
    value.pdf = std::max(value.pdf, smallest_pdf);
    return value;
  }

  Estimator estimator_;
  adaptive::Service* service_;
  SharedEnergies energies_;
  std::vector<FiberRecord> fibers_;
};

}  // namespace

const char* estimator_name(Estimator estimator) {
  switch (estimator) {
    case Estimator::fitted:
      return "fitted";
    case Estimator::exact:
      return "exact";
    case Estimator::corrected:
      break;
  }
  return "corrected";
}

std::unique_ptr<FiberModel> make_elliptical_model(Estimator estimator, adaptive::Service* service) {
  return std::make_unique<EllipticalModel>(estimator, service);
}

}  // namespace tress::fiber
