// The assembled BCSDF of the elliptical fiber (ESTIMATOR.md, E5):
//   S = sum_p E_p M_p N^_p,   Q = sum_p P_p M_p q_p,   both densities in dtheta_i dphi_i.
#include "tress/fiber/elliptical_model.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <new>
#include <numbers>
#include <optional>

#include "fiber/longitudinal.h"
#include "fiber/reflection.h"
#include "models/elliptical/fiber_store.h"
#include "models/elliptical/row_reader.h"
#include "models/elliptical/tinted_row.h"
#include "models/event_constants.h"
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
  LongitudinalLobes longitudinal;  ///< by order p - 1: TT, TRT (and GLINT), TRRT (and the residual); R's last, unused
  FoldedAzimuth fold;
  glm::vec3 reflection_gain;                  ///< of R, times what roughness leaves of its energy
  std::array<std::uint32_t, 4> first_node{};  ///< of the row of nodes that xi1 chose, by row lobe
  std::array<glm::vec3, 4> channel_weights;   ///< shares of the channels in the luminance of the lobe's energy
  std::uint64_t hash;                         ///< of xi and the known direction; for `corrected`
};

class EllipticalModel final : public FiberModel {
 public:
  EllipticalModel(Estimator estimator, adaptive::Service* service)
      : estimator_(estimator), service_(estimator == Estimator::exact ? nullptr : service), fibers_(service_) {
    assert(estimator == Estimator::exact || service != nullptr);
    if (service_ != nullptr) uniform_share_ = service_->options().uniform_share_converged;
  }

  std::string name() const override { return "elliptical"; }
  FiberId add_fiber(const FiberParameters& parameters) override { return fibers_.add(parameters); }
  void rows_changed() override { fibers_.rows_changed(); }
  std::size_t bytes() const override { return fibers_.bytes(); }

  FiberEvent begin(FiberId id, const FiberDirection& wr, float xi1, float xi2, float /*h*/) const override {
    const FiberRecord& fiber = fibers_[id];
    FiberEvent event;
    event.fiber = id;
    event.wr = clamped(wr);
    event.xi1 = xi1;
    event.xi2 = xi2;
    const LobeEnergies energies = fiber.energies->at(event.wr.phi, event.wr.theta);
    event.energy = energies.colored;
    std::array<glm::vec3, lobe_count> terms;
    float sum = 0;
    for (std::size_t p = 0; p < lobe_count; ++p) {
      terms[p] = luminance_terms(event.energy[p]);
      sum += event.selection[p] = terms[p].x + terms[p].y + terms[p].z;
    }
    const FoldedAzimuth fold = fold_azimuth(event.wr.phi);
    const FiberParameters& parameters = fiber.parameters;
    const LobeWidths::At widths = fiber.widths.at(event.wr.theta);
    EventConstants* constants = new (place_of<EventConstants>(event)) EventConstants{
        {parameters.eta, parameters.eccentricity, event.wr.theta, event.wr.phi, energies.smooth_reflection,
         widths.tilt[LobeWidths::lane_of(0)], widths.lambda[LobeWidths::lane_of(0)], parameters.reflection_fresnel,
         parameters.longitudinal_shape},
        {event.wr.theta, widths.tilt + widths.shift, widths.lambda, parameters.longitudinal_shape},
        fold,
        parameters.gain[0] * (energies.clear[0] / energies.smooth_reflection),
        {},
        {},
        estimator_ == Estimator::corrected ? hash_of(event.wr.theta, event.wr.phi, hash_of(xi1, xi2, 0)) : 0};
    for (std::size_t i = 0; i < row_lobes.size(); ++i) {
      const auto lobe = static_cast<std::size_t>(row_lobes[i]);
      constants->channel_weights[i] =
          terms[lobe] * (1 / event.selection[lobe]);  // read only where the lobe is selected
      if (!fiber.rows[i]) continue;
      const PageRows& page = fiber.rows[i]->page();
      constants->first_node[i] = page.grid.choose_azimuth(fold.phi, xi1) * page.width;
    }
    if (!(sum > 0)) {
      event.selection = {};
      event.selection[0] = sum = 1;
    }
    const float inverse_sum = 1 / sum;
    for (float& probability : event.selection) probability *= inverse_sum;
    return event;
  }

  FiberSample sample(const FiberEvent& event, const std::array<float, 4>& u) const override {
    const FiberRecord& fiber = fibers_[event.fiber];
    const EventConstants& constants = constants_in<EventConstants>(event);
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
    if (p == 0) {
      const ReflectionLobe& reflection = constants.reflection;
      sample.wi.phi = reflection.sample_azimuth(u[2]);
      sample.wi.theta = reflection.longitudinal(sample.wi.phi).sample(u[1]);
    } else {
      const bool has_rows = p != static_cast<int>(residual);
      const std::size_t i = has_rows ? row_lobe_of(p) : 0;
      const int width = (has_rows ? row_orders[i] : 3) - 1;
      sample.wi.theta = constants.longitudinal.lane(width).sample(u[1]);
      if (has_rows) {
        const float spare = std::clamp((u[0] - below) / chosen, 0.0f, 0.99999994f);
        const Inclination at = inclination_of(fiber, event, sample.wi);
        const RowReader reader = reader_of(fiber, constants, i);
        std::uint32_t node = 0;
        RowQuery query;
        if (service_ != nullptr) {
          node = constants.first_node[i] + at.node;
          query.row = fiber.rows[i]->find(node);
          if (query.row == nullptr) query = reader.ask(node);
        }
        sample.wi.phi =
            constants.fold.absolute(reader.sample(query, node, at.theta_d, spare, u[2], u[3]), event.wr.phi);
        sample.value = value_at(event, constants, sample.wi, at, p, &query);
        return sample;
      }
      sample.wi.phi = constants.fold.absolute(pi * (2 * u[2] - 1), event.wr.phi);
    }
    sample.value = value_at(event, constants, sample.wi, inclination_of(fiber, event, sample.wi), p, nullptr);
    return sample;
  }

  FiberValue evaluate(const FiberEvent& event, const FiberDirection& wi) const override {
    const FiberDirection at = clamped(wi);
    return value_at(event, constants_in<EventConstants>(event), at, inclination_of(fibers_[event.fiber], event, at),
                    nothing_drawn, nullptr);
  }

 private:
  /// Index into row_lobes of a lobe other than R and the residual.
  static std::size_t row_lobe_of(int lobe) {
    return lobe == static_cast<int>(Lobe::glint) ? 3 : static_cast<std::size_t>(lobe) - 1;
  }

  RowReader reader_of(const FiberRecord& fiber, const EventConstants& constants, std::size_t i) const {
    return {fiber, service_, fibers_.pool(), i, constants.fold.phi, constants.channel_weights[i]};
  }

  /// Whether `corrected` traces this direction, for all lobes, and where its rays are placed, in [0, 1): pure functions
  /// of the event and the direction, so that sample() and evaluate() agree. Any bit of xi or of a direction changes the
  /// whole hash.
  std::optional<float> correction(const EventConstants& constants, const FiberDirection& wi) const {
    if (estimator_ != Estimator::corrected) return {};
    const std::uint64_t hash = hash_of(wi.theta, wi.phi, constants.hash);
    if (hash >> (64 - correction_bits) != 0) return {};
    return static_cast<float>(hash & 0xffffff) * 0x1p-24f;
  }

  /// What all rows of one direction have in common.
  struct Inclination {
    float theta_d;           ///< |theta_d|
    std::uint32_t node = 0;  ///< that xi2 chose
  };
  Inclination inclination_of(const FiberRecord& fiber, const FiberEvent& event, const FiberDirection& wi) const {
    const float theta_d = 0.5f * std::fabs(event.wr.theta - wi.theta);
    if (service_ == nullptr) return {theta_d};
    return {theta_d, fiber.rows[0]->page().grid.choose_inclination(theta_d, event.xi2)};
  }

  /// S and Q at wi. drawn: the lobe that drew wi, whose query (if it makes any) is then `known`.
  FiberValue value_at(const FiberEvent& event, const EventConstants& constants, const FiberDirection& wi,
                      const Inclination& at, int drawn, const RowQuery* known) const {
    const FiberRecord& fiber = fibers_[event.fiber];
    FiberValue value;
    if (event.selection[0] > 0) {
      const ReflectionLobe::At r = constants.reflection.at(wi.phi);
      const float m = constants.reflection.longitudinal_density(r, wi.theta);
      value.s[0] = constants.reflection_gain * (r.energy_density * m);
      value.pdf += event.selection[0] * r.azimuth_pdf * m;
    }
    const float x = constants.fold.relative(wi.phi, event.wr.phi);
    const std::optional<float> correct = correction(constants, wi);
    const int counted = known != nullptr && known->counted ? drawn : nothing_drawn;
    std::uint32_t from_copies = 0;
    const Float4 widths = constants.longitudinal.density(wi.theta);
    for (std::size_t i = 0; i < row_lobes.size(); ++i) {
      const auto lobe = static_cast<std::size_t>(row_lobes[i]);
      if (!(event.selection[lobe] > 0)) continue;
      const float m = widths[row_orders[i] - 1];
      const TintedRow* row = service_ != nullptr && static_cast<int>(lobe) != counted
                                 ? fiber.rows[i]->find(constants.first_node[i] + at.node)
                                 : nullptr;
      RowValue azimuthal;
      bool asks = true, exact = false;
      if (row != nullptr) [[likely]] {
        azimuthal = row->evaluate(x, constants.channel_weights[i], uniform_share_);
        asks = row->has_row;
        from_copies += asks ? 1 : 0;
        value.objective += row->objective;
      } else {
        azimuthal = trace_or_ask(event, constants, i, at, x, static_cast<int>(lobe) == drawn ? known : nullptr, value,
                                 asks, exact);
      }
      value.queries += asks ? 1 : 0;
      if ((correct || fiber.proposes_only[i]) && service_ != nullptr) [[unlikely]] {
        const RowReader reader = reader_of(fiber, constants, i);
        if (fiber.proposes_only[i]) {
          azimuthal.shape = reader.evaluate_at_vertex(at.theta_d, x).shape;
        } else {
          azimuthal.shape += correction_factor * reader.correction(azimuthal.shape, at.theta_d, x, *correct);
        }
        exact = true;
      }
      value.exact_queries += asks && exact ? 1 : 0;
      value.s[lobe] = event.energy[lobe] * azimuthal.shape * m;
      value.pdf += event.selection[lobe] * azimuthal.proposal * m;
    }
    if (event.selection[residual] > 0) {
      const float m = widths[2];
      value.s[residual] = event.energy[residual] * (inverse_two_pi * m);
      value.pdf += event.selection[residual] * inverse_two_pi * m;
    }
    if (from_copies != 0) service_->count_converged(from_copies);
    value.pdf = std::max(value.pdf, smallest_pdf);
    return value;
  }

  /// A node that has no copy, or that sample() has just asked for: `known`; without a service, the trace at the vertex.
  [[gnu::noinline]] RowValue trace_or_ask(const FiberEvent& event, const EventConstants& constants, std::size_t i,
                                          const Inclination& at, float x, const RowQuery* known, FiberValue& value,
                                          bool& asks, bool& exact) const {
    const RowReader reader = reader_of(fibers_[event.fiber], constants, i);
    exact = true;
    if (service_ == nullptr) return reader.evaluate_at_vertex(at.theta_d, x);
    const std::uint32_t node = constants.first_node[i] + at.node;
    const RowQuery asked = known == nullptr ? reader.ask(node) : RowQuery{};
    const RowQuery& query = known == nullptr ? asked : *known;
    if (query.row != nullptr) {
      asks = query.row->has_row;
      exact = false;
      value.objective += query.row->objective;
      return query.row->evaluate(x, constants.channel_weights[i], uniform_share_);
    }
    value.objective += query.view.objective;
    return reader.evaluate_open(query, node, x, known != nullptr);
  }

  Estimator estimator_;
  adaptive::Service* service_;
  float uniform_share_ = 0;
  FiberStore fibers_;
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
