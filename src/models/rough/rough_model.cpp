// The assembled BCSDF of the rough fiber at an event whose row has converged:
//   S_c = sum_p E_p,c f_p,c(x, t) / cos theta_i,   Q = luminance(S) / luminance(E),   both densities in dtheta_i
//   dphi_i,
// f_p,c of mass 1: what the row's ribbon of part p is to channel c. In lanes, compiled for several instruction sets.
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

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "models/rough/rough_model.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tress::fiber {
namespace HWY_NAMESPACE {

/// What the model keeps with an event.
struct RoughConstants {
  EventRow row;
  std::array<Float4, RoughRow::parts> proposal;  ///< shares of the parts and channels in the luminance of all lobes
  RoughNode node;
  float specular_height;
  bool is_black;
  TracedEvent traced;  ///< where the row has not converged
};

class RoughModel final : public EventRowModel {
 public:
  RoughModel(Estimator estimator, adaptive::Service* service)
      : EventRowModel(estimator == Estimator::exact ? nullptr : service), fibers_(service_) {
    assert(estimator != Estimator::corrected && (estimator == Estimator::exact || service != nullptr));
  }

  std::string name() const override { return "rough"; }
  FiberId add_fiber(const FiberParameters& parameters) override { return fibers_.add(parameters); }
  std::size_t bytes() const override { return fibers_.bytes(); }
  bool evaluates() const override { return service_ != nullptr; }
  bool evaluates(const FiberEvent& event) const override { return constants_in<EventRow>(event).has_converged; }

  bool estimates(const FiberEvent& event) const override {
    return service_ != nullptr && !constants_in<EventRow>(event).has_converged;
  }

  FiberValue evaluate(const FiberEvent& event, const FiberDirection& wi) const override {
    const auto& constants = constants_in<RoughConstants>(event);
    FiberValue value;
    if (!constants.row.has_converged) return service_ != nullptr ? estimated(event, constants, clamped(wi)) : value;
    value_at(event, constants, answer_of(constants.row), clamped(wi), value);
    return value;
  }

 private:
  FiberEvent start(FiberId id, const FiberDirection& wr, float xi1, float xi2, float h,
                   RowOfEvent& row) const override {
    const FiberRecord& fiber = fibers_.record(id);
    FiberEvent event;
    event.fiber = id;
    event.wr = clamped(wr);
    event.xi1 = xi1;
    event.xi2 = xi2;
    event.energy = fiber.energies->at(event.wr.phi, event.wr.theta).colored;

    auto* constants = new (place_of<RoughConstants>(event)) RoughConstants;
    const RoughRows& rows = fibers_.rows(id);
    bool has_converged = false;
    if (rows.formed != nullptr) {
      constants->node = rows.grid->choose(event.wr, xi1, xi2);
      const std::uint32_t node = constants->node.a * rows.formed->width() + constants->node.b;
      const EventRow& asked = row.ask(*rows.formed, node);
      has_converged = asked.has_converged;
      if (has_converged) scale_energies(event, answer_of(asked), rows.keeps_sum);
    }
    const LobeShares shares = select_lobes(event);
    if (!has_converged) {
      const float offset = service_ != nullptr ? TracedFibers::any_offset(event) : h;
      constants->traced = fibers_.traced().begin(event, fiber.parameters, offset);
      return event;
    }
    constants->specular_height = specular_height(event.wr.theta);
    constants->is_black = shares.is_black;
    const glm::vec3 share = luminance_terms(glm::vec3(shares.inverse_luminance));
    const Float4 terms{share.r, share.g, share.b, 0};
    constants->proposal = {terms * load_energy(event, Lobe::r), terms * load_energy(event, Lobe::tt),
                           terms * (load_energy(event, Lobe::trt) + load_energy(event, Lobe::glint)),
                           terms * (load_energy(event, Lobe::trrt) + load_energy(event, Lobe::residual))};
    return event;
  }

  /// The energies of the table by what the row knows of its parts. keeps_sum: all lobes together have the row's factor
  /// of the whole, whatever moves between the node and wr: clear hair keeps all light.
  static void scale_energies(FiberEvent& event, const RoughRow& row, bool keeps_sum) {
    std::array<Float4, lobe_count> energy;
    Float4 before = splat(0), after = splat(0);
    for (std::size_t lobe = 0; lobe < lobe_count; ++lobe) {
      const glm::vec3& known = event.energy[lobe];
      const Float4 of_table{known.x, known.y, known.z, 0};
      energy[lobe] = of_table * row.energy[part_of(lobe)];
      before += of_table;
      after += energy[lobe];
    }
    const Float4 scale = keeps_sum ? before * row.whole_energy / (after + 1e-30f) : splat(1);
    for (std::size_t lobe = 0; lobe < lobe_count; ++lobe) {
      const Float4 scaled = energy[lobe] * scale;
      event.energy[lobe] = {scaled[0], scaled[1], scaled[2]};
    }
  }

  FiberSample draw(const FiberEvent& event, const std::array<float, 4>& u) const override {
    const auto& constants = constants_in<RoughConstants>(event);
    if (!constants.row.has_converged) {
      FiberSample sample =
          fibers_.traced().sample(event.fiber, constants.traced, fibers_.record(event.fiber).parameters, u);
      if (constants.row.formed != nullptr) {
        sample.value.queries = sample.value.exact_queries = 1;
        sample.value.objective = 1;
      }
      if (service_ != nullptr) {
        sample.value.pdf = open_pdf(sample.wi);
        for (glm::vec3& s : sample.value.s) s *= sample.value.pdf;
      }
      return sample;
    }
    return draw_from(event, constants, answer_of(constants.row), u);
  }

  /// Of a row that has converged.
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

  /// Of an open event: a value of a few paths, whose tails are long, and what balances it against sampled lights, which
  /// may be any function. In units of a sphere's density: straight brown hair in a studio, all of it open, 16 samples,
  /// has a noise of 1.22 at 1.5, 1.23 at 3, 1.30 at 6, and 3.0 without light samples; in a sunlit city 0.87, 0.83,
  /// 0.82.
  static constexpr float open_balance = 4;
  FiberValue estimated(const FiberEvent& event, const RoughConstants& constants, const FiberDirection& wi) const {
    FiberValue value = fibers_.traced().estimate(event, constants.traced, fibers_.record(event.fiber).parameters, wi);
    value.pdf = open_pdf(wi);
    value.queries = value.exact_queries = 1;
    value.objective = 1;
    return value;
  }
  static float open_pdf(const FiberDirection& wi) {
    return open_balance * std::max(std::cos(wi.theta), 1e-4f) / (4 * pi);
  }

  static constexpr float pi = std::numbers::pi_v<float>;
  static std::size_t part_of(std::size_t lobe) {
    constexpr std::array<std::uint8_t, lobe_count> parts{0, 1, 2, 3, 3, 2};
    return parts[lobe];
  }

  /// One function, not inlined: sample() and evaluate() agree to the bit. S and Q at wi, theta in [-pi/2, pi/2], phi in
  /// [-pi, pi).
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
    const float pdf = sum4((proposal[0] * f[0] + proposal[1] * f[1]) + (proposal[2] * f[2] + proposal[3] * f[3]));
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
};

std::unique_ptr<FiberModel> MakeRough(Estimator estimator, adaptive::Service* service) {
  return std::make_unique<RoughModel>(estimator, service);
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::fiber
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::fiber {

HWY_EXPORT(MakeRough);

std::unique_ptr<FiberModel> make_rough_model(Estimator estimator, adaptive::Service* service) {
  return HWY_DYNAMIC_DISPATCH(MakeRough)(estimator, service);
}

}  // namespace tress::fiber
#endif
