// The assembled BCSDF of the rough fiber for an event whose row has converged:
//  S_c = sum_p E_p,c f_p,c(x, t) / cos theta_i,   Q = luminance(S) / luminance(E),
// both densities in dtheta_i dphi_i. f_p,c has mass 1: it is the row's ribbon of part p in channel c. It is computed in
// lanes and compiled for several instruction sets.
#include "tress/fiber/rough_model.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <numbers>
#include <span>

#include "base/color.h"
#include "base/float4.h"
#include "base/instruction_sets.h"
#include "fiber/energy_table.h"
#include "fiber/event_constants.h"
#include "fiber/row_axes.h"
#include "fiber/row_model.h"
#include "models/lobes/lobe_choice.h"
#include "models/rough/rough_fibers.h"
#include "models/rough/rough_lanes.h"
#include "models/rough/rough_row.h"
#include "models/rough/uncolored_row.h"
#include "tress/base/random.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "models/rough/rough_model.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::fiber {
namespace HWY_NAMESPACE {

/// What an event whose row has converged draws its direction from: the row, a path from anywhere that it passes to the
/// service, or a path from where the ray met the fiber.
enum class Draws : std::uint8_t { from_row, heard_path, near_path };

/// The data that the model keeps with an event.
struct RoughConstants {
  EventRow row;
  std::array<Float4, RoughRow::parts> proposal;  ///< shares of the parts and channels in the luminance of all lobes
  RoughNode node;
  float specular_height;
  bool is_black;
  Offset offset;        ///< where traced paths enter
  Draws draws;          ///< what a row that has converged leaves to a path
  float least_density;  ///< added to Q of the row, 1/sr
  TracedEvent traced;   ///< set if the row has not converged, or if the event draws a path
};

class RoughModel final : public EventRowModel {
 public:
  RoughModel(Estimator estimator, adaptive::Service* service)
      : EventRowModel(estimator == Estimator::exact ? nullptr : service),
        fibers_(service_),
        heard_share_(service_ != nullptr ? service_->options().heard_share : 0) {
    assert(estimator != Estimator::corrected && (estimator == Estimator::exact || service != nullptr));
  }

  std::string name() const override { return "rough"; }
  FiberId make_fiber(const FiberParameters& parameters) override { return fibers_.add(parameters); }
  std::size_t bytes() const override { return fibers_.bytes(); }
  bool evaluates() const override { return service_ != nullptr; }
  bool evaluates(const FiberEvent& event) const override { return constants_in<EventRow>(event).has_converged; }

  bool estimates() const override { return true; }
  bool estimates(const FiberEvent& event) const override { return !constants_in<EventRow>(event).has_converged; }
  float balance(FiberId id) const override { return fibers_.balance(id); }

  bool has_spectra() const override { return true; }
  float pdf_of_event(const FiberEvent& event, const FiberDirection& wi) const override {
    const auto& constants = constants_in<RoughConstants>(event);
    FiberValue value;
    if (constants.row.has_converged) {
      value_at(event, constants, answer_of(constants.row), clamped(wi), value);
    } else {
      set_estimate(event, constants, clamped(wi), value);
    }
    return value.pdf;
  }
  void add_spectrum(const FiberEvent& event, const FiberDirection& direction, std::span<const float> sigma_a,
                    std::span<float> s) const override {
    const auto& constants = constants_in<RoughConstants>(event);
    const FiberParameters& fiber = fibers_.record(event.fiber).parameters;
    const FiberDirection wi = clamped(direction);
    if (!constants.row.has_converged) {
      fibers_.traced().add_estimate(event, constants.traced, fiber, wi, constants.offset, sigma_a, s);
      return;
    }
    const adaptive::FormedRows& rows = *fibers_.rows(event.fiber).uncolored;
    const std::uint32_t node = constants.row.node;
    adaptive::RowAnswer answer;
    adaptive::FormedLookup found;
    {
      adaptive::AnswerReader reader(service_);
      answer = reader.read(rows.run(node / rows.width()), node % rows.width());
    }
    if (!answer) {
      found = service_->fetch(rows, node);
      answer = found.answer;
    }
    if (!answer) return;
    const AxialPlace axial(wi.theta);
    const float turn = wrap_once(wi.phi - event.wr.phi);
    std::array<float, RoughRow::parts> weights{}, energies{};
    for (std::size_t lobe = 0; lobe < lobe_count; ++lobe) {
      const float gain = luminance(fiber.gain[lobe]), energy = luminance(event.energy[lobe]) / std::max(gain, 1e-30f);
      energies[part_of(lobe)] += energy;
      weights[part_of(lobe)] += energy * gain;
    }
    for (std::size_t p = 0; p < weights.size(); ++p) {
      const float gain = luminance(fiber.gain[p]);
      weights[p] = (energies[p] > 0 ? weights[p] / energies[p] : gain) / axial.cosine;
    }
    add_spectrum_at(*static_cast<const UncoloredRow*>(answer.block()), constants.node.azimuth_sign * turn,
                    constants.node.height_sign * (axial.height - constants.specular_height), weights, sigma_a, s);
  }
  void recolor_path(const FiberEvent& event, const FiberSample& drawn, std::span<const float> sigma_a,
                    std::span<float> s) const override {
    TracedFibers::recolor(drawn, fibers_.record(event.fiber).parameters, sigma_a, s);
  }

  FiberValue evaluate_event(const FiberEvent& event, const FiberDirection& wi) const override {
    const auto& constants = constants_in<RoughConstants>(event);
    if (!constants.row.has_converged) return estimated(event, constants, clamped(wi));
    FiberValue value;
    value_at(event, constants, answer_of(constants.row), clamped(wi), value);
    return value;
  }

 private:
  NodeSteps steps_between_nodes(FiberId id, const FiberDirection& wr, const FiberDirection& /*wi*/) const override {
    const RoughRows& rows = fibers_.rows(id);
    if (rows.formed == nullptr) return {};
    const RoughGrid::Steps steps = rows.grid->steps(clamped(wr));
    return {{steps.xi1}, steps.xi2};
  }

  FiberEvent start(FiberId id, const FiberDirection& wr, float xi1, float xi2, float h, Traced traced,
                   RowOfEvent* row) const override {
    const FiberRecord& fiber = fibers_.record(id);
    FiberEvent event;
    event.fiber = id;
    event.wr = clamped(wr);
    event.xi1 = xi1;
    event.xi2 = xi2;
    event.energy = fiber.energies->at(event.wr.phi, event.wr.theta).colored;

    auto* constants = new (place_of<RoughConstants>(event)) RoughConstants;
    const RoughRows& rows = fibers_.rows(id);
    const RoughRow* answer = nullptr;  // of a row that has converged
    constants->offset = traced == Traced::nothing ? fibers_.offset() : Offset::known;
    if (row != nullptr && rows.formed != nullptr) {
      constants->node = rows.grid->choose(event.wr, xi1, xi2);
      const std::uint32_t node = constants->node.a * rows.formed->width() + constants->node.b;
      const EventRow& asked = row->ask(*rows.formed, node);
      if (asked.has_converged) answer = &answer_of(asked);
      if (answer != nullptr) scale_energies(event, *answer, rows.inverse_gain);
    }
    const LobeShares shares = select_lobes(event);
    if (answer == nullptr) {
      const float offset = constants->offset == Offset::any ? TracedFibers::any_offset(event) : h;
      constants->traced = fibers_.traced().begin(event, fiber.parameters, offset);
      if (constants->offset == Offset::known) constants->traced.kept_inside = TracedFibers::kept_inside(event);
      return event;
    }
    constants->specular_height = specular_height(event.wr.theta);
    constants->is_black = shares.is_black;
    constants->draws = Draws::from_row;
    constants->least_density = 0;
    if (traced == Traced::drawn && !shares.is_black) {
      constants->draws = Draws::near_path;
      constants->least_density = drawn_near_density;
      constants->traced = fibers_.traced().begin(event, fiber.parameters, h);
      constants->traced.kept_inside = TracedFibers::kept_inside(event);
    } else if (listens(event, shares, *answer)) [[unlikely]] {
      constants->draws = Draws::heard_path;
      constants->traced = fibers_.traced().begin(event, fiber.parameters, TracedFibers::any_offset(event));
    }
    const glm::vec3 share = luminance_terms(glm::vec3(shares.inverse_luminance));
    const Float4 terms{share.r, share.g, share.b, 0};
    constants->proposal = {terms * load_energy(event, Lobe::r), terms * load_energy(event, Lobe::tt),
                           terms * (load_energy(event, Lobe::trt) + load_energy(event, Lobe::glint)),
                           terms * (load_energy(event, Lobe::trrt) + load_energy(event, Lobe::residual))};
    return event;
  }

  /// Whether this event, by its own numbers alone, draws a path of the fiber and not from its row: by default one in
  /// 64, or one in 16 for rows of at most 512 paths. A path weighs up to 1 where a sample of the row weighs m, the
  /// albedo. The variance of samples then grows by at most share (1/m - 1), which is kept below 0.03.
  bool listens(const FiberEvent& event, const LobeShares& shares, const RoughRow& row) const {
    constexpr std::uint32_t few_paths = 512;
    constexpr float more_of_few = 4, most_variance = 0.03f;
    if (!(heard_share_ > 0) || shares.is_black) return false;
    const float albedo = std::min(1 / shares.inverse_luminance, 1.0f);
    const float share = std::min(row.paths <= few_paths ? more_of_few * heard_share_ : heard_share_,
                                 most_variance * albedo / (1.0001f - albedo));
    constexpr std::uint64_t purpose = 0x6865617264ull;
    const std::uint64_t hash =
        mix_bits(mix_bits(bits_of(event.xi1, event.xi2) + purpose) + bits_of(event.wr.theta, event.wr.phi));
    return static_cast<float>(hash >> 40) * 0x1p-24f < share;
  }

  /// Scales the table's energies by the row's factors for its parts, then all lobes together, so that their sum without
  /// gains changes by the row's factor for the whole. So clear hair keeps all light, although wr is not at the node.
  static void scale_energies(FiberEvent& event, const RoughRow& row,
                             const std::array<Float4, lobe_count>& inverse_gain) {
    std::array<Float4, lobe_count> energy;
    Float4 before = splat(0), after = splat(0);
    for (std::size_t lobe = 0; lobe < lobe_count; ++lobe) {
      const glm::vec3& known = event.energy[lobe];
      const Float4 of_table{known.x, known.y, known.z, 0};
      energy[lobe] = of_table * row.energy[part_of(lobe)];
      before += of_table * inverse_gain[lobe];
      after += energy[lobe] * inverse_gain[lobe];
    }
    const Float4 scale = before * row.whole_energy / (after + 1e-30f);
    for (std::size_t lobe = 0; lobe < lobe_count; ++lobe) {
      const Float4 scaled = energy[lobe] * scale;
      event.energy[lobe] = {scaled[0], scaled[1], scaled[2]};
    }
  }

  FiberSample draw(const FiberEvent& event, const std::array<float, 4>& u) const override {
    const auto& constants = constants_in<RoughConstants>(event);
    if (!constants.row.has_converged) {
      const FiberParameters& fiber = fibers_.record(event.fiber).parameters;
      FiberSample sample = constants.row.formed != nullptr && !service_->options().own_paths
                               ? heard(event, constants, u, 0).sample
                               : fibers_.traced().sample(event.fiber, constants.traced, fiber, u);
      // Its light leaves as sampled light and that of rows do, which do not know where it enters.
      if (constants.offset == Offset::any) sample.value.exit = {};
      set_estimate(event, constants, sample.wi, sample.value);
      for (glm::vec3& s : sample.value.s) s *= sample.value.pdf;
      return sample;
    }
    const RoughRow& row = answer_of(constants.row);
    if (constants.draws == Draws::from_row || event.is_of_mean) return draw_from(event, constants, row, u);
    return constants.draws == Draws::heard_path
               ? over_row(event, constants, row, heard(event, constants, u, row.paths).sample)
               : over_row(
                     event, constants, row,
                     fibers_.traced().sample(event.fiber, constants.traced, fibers_.record(event.fiber).parameters, u));
  }

  /// The path of a sample with its weight, over the density of the row.
  FiberSample over_row(const FiberEvent& event, const RoughConstants& constants, const RoughRow& row,
                       FiberSample sample) const {
    const FiberValue traced = sample.value;
    value_at(event, constants, row, sample.wi, sample.value);
    for (std::size_t lobe = 0; lobe < lobe_count; ++lobe) sample.value.s[lobe] = traced.s[lobe] * sample.value.pdf;
    return sample;
  }

  /// Draws one path of the fiber and passes it to the service.
  HeardSample heard(const FiberEvent& event, const RoughConstants& constants, const std::array<float, 4>& u,
                    std::uint64_t key) const {
    const HeardSample heard =
        fibers_.traced().listen(event.fiber, constants.traced, fibers_.record(event.fiber).parameters, u, key);
    const FiberDirection& wi = heard.sample.wi;
    const RoughNode& node = constants.node;
    adaptive::RowView view;
    view.slice = constants.row.formed->slice();
    view.node = constants.row.node;
    view.pass = constants.row.pass;
    service_->hear(view, {node.azimuth(wi.phi, event.wr.phi), node.height(wi.theta, event.wr.theta),
                          rough_part(heard.order), heard.clear_weight, heard.way});
    return heard;
  }

  /// The answer of a row that has converged.
  const RoughRow& answer_of(const EventRow& row) const {
    return *static_cast<const RoughRow*>(row.block != nullptr ? row.block : made_anew(row));
  }

  FiberSample draw_from(const FiberEvent& event, const RoughConstants& constants, const RoughRow& row,
                        const std::array<float, 4>& u) const {
    FiberSample sample;
    if (constants.is_black) [[unlikely]] {
      sample.wi.theta = std::asin(std::clamp(2 * u[1] - 1, -1.0f, 1.0f));
      sample.wi.phi = adaptive::wrap_angle(pi * (2 * u[2] - 1));
    } else {
      const std::size_t lobe = choose_lobe(event, u[0]), p = part_of(lobe);
      sample.lobe = static_cast<Lobe>(lobe);
      const glm::vec3 weights = channel_weights(event, lobe);
      const RowPlace place = draw_place(row.part[p], row.is_normal[static_cast<int>(p)] != 0, weights, u[2], u[1]);
      sample.wi.theta = inclination_of_height(constants.specular_height + constants.node.height_sign * place.height);
      sample.wi.phi = wrap_once(event.wr.phi + constants.node.azimuth_sign * place.azimuth);
    }
    value_at(event, constants, row, sample.wi, sample.value);
    return sample;
  }

  /// Estimates an event that no row answers from a few paths; the values have long tails.
  FiberValue estimated(const FiberEvent& event, const RoughConstants& constants, const FiberDirection& wi) const {
    FiberValue value = fibers_.traced().estimate(event, constants.traced, fibers_.record(event.fiber).parameters, wi,
                                                 constants.offset);
    set_estimate(event, constants, wi, value);
    return value;
  }
  /// Sets everything but S. The pdf is the density that balances the event against sampled lights; any positive
  /// function would be valid.
  void set_estimate(const FiberEvent& event, const RoughConstants& constants, const FiberDirection& wi,
                    FiberValue& value) const {
    float balance = fibers_.balance(event.fiber, constants.offset);
    if (constants.offset == Offset::known) balance += fibers_.traced().reflection(event.fiber, constants.traced, wi);
    value.pdf = balance * std::max(std::cos(wi.theta), 1e-4f);
    if (constants.row.formed == nullptr) return;
    value.queries = value.exact_queries = 1;
    value.objective = 1;
  }

  static constexpr float pi = std::numbers::pi_v<float>;
  static std::size_t part_of(std::size_t lobe) {
    constexpr std::array<std::uint8_t, lobe_count> parts{0, 1, 2, 3, 3, 2};
    return parts[lobe];
  }

  /// Computes S and Q at wi, theta in [-pi/2, pi/2], phi in [-pi, pi). It is one function, not inlined, so that
  /// sample() and evaluate() agree to the bit.
  [[gnu::noinline]] void value_at(const FiberEvent& event, const RoughConstants& constants, const RoughRow& row,
                                  const FiberDirection& wi, FiberValue& value) const {
    const AxialPlace axial(wi.theta);
    if (constants.is_black) [[unlikely]] {
      value.pdf = axial.cosine / (4 * pi);
      value.queries = 1;
      value.objective = row.objective;
      return;
    }
    const float turn = wrap_once(wi.phi - event.wr.phi);
    const float height = constants.node.height_sign * (axial.height - constants.specular_height);
    std::array<Float4, 4> f = part_densities(row, constants.node.azimuth_sign * turn, height);
    const float inverse_cosine = 1 / axial.cosine;
    for (Float4& density : f) density *= inverse_cosine;
    const auto& proposal = constants.proposal;
    const float pdf = sum4((proposal[0] * f[0] + proposal[1] * f[1]) + (proposal[2] * f[2] + proposal[3] * f[3])) +
                      constants.least_density * axial.cosine;
    put_value(value,
              {load_energy(event, Lobe::r) * f[0], load_energy(event, Lobe::tt) * f[1],
               load_energy(event, Lobe::trt) * f[2], load_energy(event, Lobe::trrt) * f[3],
               load_energy(event, Lobe::residual) * f[3], load_energy(event, Lobe::glint) * f[2]},
              std::max(pdf, smallest_pdf));
    value.queries = 1;
    value.exact_queries = 0;
    value.objective = row.objective;
  }

  RoughFibers fibers_;
  float heard_share_;  ///< adaptive::Options::heard_share; 0 without a service
};

std::unique_ptr<FiberModel> MakeRough(Estimator estimator, adaptive::Service* service) {
  return std::make_unique<RoughModel>(estimator, service);
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::fiber
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::fiber {

HWY_EXPORT(MakeRough);

Result<std::unique_ptr<FiberModel>> make_rough_model(Estimator estimator, adaptive::Service* service) {
  if (estimator == Estimator::corrected) return Error{"", "estimator", "fitted or exact", estimator_name(estimator)};
  if (estimator != Estimator::exact) {
    if (std::optional<Error> wrong =
            wrong_service(service, make_rough_target()->model_name(), adaptive::SliceKind::samples))
      return std::move(*wrong);
  }
  return HWY_DYNAMIC_DISPATCH(MakeRough)(estimator, service);
}

}  // namespace tress::inline v0_2::fiber
#endif
