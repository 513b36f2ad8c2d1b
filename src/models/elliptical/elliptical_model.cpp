// The assembled BCSDF of the elliptical fiber (ESTIMATOR.md, E5), for directions whose rows have all converged:
//  S = sum_p E_p M_p N^_p,   Q = sum_p P_p M_p q_p,   both densities in dtheta_i dphi_i.
// It is computed in lanes and compiled for several instruction sets.
#include "tress/fiber/elliptical_model.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <numbers>

#include "base/color.h"
#include "base/float4.h"
#include "base/instruction_sets.h"
#include "fiber/energy_table.h"
#include "fiber/event_constants.h"
#include "models/elliptical/absorbed_lanes.h"
#include "models/elliptical/any_rows_model.h"
#include "models/lobes/lobe_choice.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "models/elliptical/elliptical_model.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::fiber {
namespace HWY_NAMESPACE {

class EllipticalModel final : public AnyRowsModel {
 public:
  using AnyRowsModel::AnyRowsModel;

  FiberEvent make_event(FiberId id, const FiberDirection& wr, float xi1, float xi2, float /*h*/) const override {
    const EllipticalFiber& fiber = fibers_[id];
    FiberEvent event;
    event.fiber = id;
    event.wr = clamped(wr);
    event.xi1 = xi1;
    event.xi2 = xi2;
    const LobeEnergies energies = fiber.energies->at(event.wr.phi, event.wr.theta);
    event.energy = energies.colored;
    const LobeShares shares = select_lobes(event);

    const FoldedAzimuth fold = fold_azimuth(event.wr.phi);
    const FiberParameters& parameters = fiber.parameters;
    const LobeWidths::At widths = fiber.widths.at(event.wr.theta);
    VertexConstants* constants = new (place_of<VertexConstants>(event)) VertexConstants{
        {parameters.eta, parameters.eccentricity, event.wr.theta, event.wr.phi, energies.smooth_reflection,
         widths.tilt[LobeWidths::lane_of(0)], widths.lambda[LobeWidths::lane_of(0)], parameters.reflection_fresnel,
         parameters.longitudinal_shape},
        {event.wr.theta, widths.tilt + widths.shift, widths.lambda, parameters.longitudinal_shape},
        splat(0),
        {},
        fold,
        shares.inverse_luminance,
        shares.is_black ? glm::vec3(0.0f) : parameters.gain[0] * (energies.clear[0] / energies.smooth_reflection),
        hash_of_event(event.wr, xi1, xi2)};
    for (std::size_t i = 0; i < row_lobes.size(); ++i) {
      const float selection = event.selection[static_cast<std::size_t>(row_lobes[i])];
      const ColoredRows* rows = fiber.rows[i].get();
      constants->uniform_pdf[static_cast<int>(i)] = selection * uniform_share_ * inverse_two_pi;
      if (rows == nullptr || (fiber.answers_by_rows && !(selection > 0))) {
        constants->runs[i] = fiber.answers_by_rows ? zero_density_rows() : unanswered_rows();
        continue;
      }
      constants->runs[i] = rows->formed().run(rows->slice().grid.choose_azimuth(fold.phi, xi1));
      if (!fiber.answers_by_rows) constants->runs[i].entries = unanswered_rows().entries;
    }
    return event;
  }

 private:
  NodeSteps steps_between_nodes(FiberId id, const FiberDirection& wr, const FiberDirection& wi) const override {
    NodeSteps steps;
    if (service_ == nullptr) return steps;  // traced at the vertex, which no xi chooses
    const float folded = fold_azimuth(clamped(wr).phi).phi;
    for (std::size_t i = 0; i < row_lobes.size(); ++i) {
      if (const ColoredRows* rows = fibers_[id].rows[i].get())
        steps.xi1[i] = 1 - rows->slice().grid.between_azimuths(folded).share;
    }
    steps.xi2 = step_of_inclination(clamped(wr), clamped(wi));
    return steps;
  }

  FiberSample draw(const FiberEvent& event, const std::array<float, 4>& u, DirectionRows& rows) const override {
    const VertexConstants& constants = constants_in<VertexConstants>(event);
    FiberSample sample;
    const std::size_t p = choose_lobe(event, u[0]);
    sample.lobe = static_cast<Lobe>(p);
    Inclination at;
    Answers answers;
    int drawn = nothing_drawn;
    if (p == 0) {
      const ReflectionLobe& reflection = constants.reflection;
      sample.wi.phi = reflection.sample_azimuth(u[2]);
      sample.wi.theta = reflection.longitudinal(sample.wi.phi).sample(u[1]);
      at = inclination_of(event, sample.wi.theta);
      read(event, constants, at, rows, answers);
    } else {
      const bool has_rows = p != residual;
      const std::size_t i = has_rows ? row_lobe_of(static_cast<int>(p)) : 2;
      sample.wi.theta = constants.longitudinal.sample(row_orders[i] - 1, u[1]);
      at = inclination_of(event, sample.wi.theta);
      read(event, constants, at, rows, answers);
      float x = pi * (2 * u[2] - 1);
      if (has_rows) {
        const AbsorbedRow* row = answers.row[i];
        if (row == nullptr) [[unlikely]] {
          drawn = static_cast<int>(p);
          const std::array<float, 3> any{spare_of_choice(event, p, u[0]), u[2], u[3]};
          sample.wi.phi = sample_any(event, constants, drawn, at, any, rows, answers);
        } else {
          const glm::vec3 weights = channel_weights(event, p);
          x = sample_mixture(*row, u[2], (1 - uniform_share_) * weights);
        }
      }
      if (drawn == nothing_drawn) sample.wi.phi = wrap_once(event.wr.phi + constants.fold.sign * x);
    }
    value_at(event, constants, sample.wi, at, drawn, rows, answers, sample.value);
    return sample;
  }

  FiberValue value(const FiberEvent& event, const FiberDirection& wi, DirectionRows& rows) const override {
    const VertexConstants& constants = constants_in<VertexConstants>(event);
    const FiberDirection at = clamped(wi);
    const Inclination inclination = inclination_of(event, at.theta);
    Answers answers;
    read(event, constants, inclination, rows, answers);
    FiberValue value;
    value_at(event, constants, at, inclination, nothing_drawn, rows, answers, value);
    return value;
  }

  void read(const FiberEvent& event, const VertexConstants& constants, const Inclination& at, DirectionRows& rows,
            Answers& answers) const {
    answers.all = rows.read(constants.runs, row_lobes, at.node, answers.row);
    if (!answers.all) [[unlikely]]
      complete(event, constants, at, rows, answers);
  }

  static constexpr float pi = std::numbers::pi_v<float>;
  static constexpr float inverse_two_pi = 0.5f * std::numbers::inv_pi_v<float>;

  static constexpr auto residual = static_cast<std::size_t>(Lobe::residual);
  /// Computes S and Q at wi, theta in [-pi/2, pi/2], phi in [-pi, pi). It is one function, not inlined, so that
  /// sample() and evaluate() agree to the bit.
  [[gnu::noinline]] void value_at(const FiberEvent& event, const VertexConstants& constants, const FiberDirection& wi,
                                  const Inclination& at, int drawn, DirectionRows& rows, Answers& answers,
                                  FiberValue& value) const {
    if (!answers.all || (estimator_ == Estimator::corrected && correction(event, constants, wi))) [[unlikely]] {
      value = value_of_any(event, constants, wi, at, drawn, rows, answers);
      return;
    }
    const std::array<const AbsorbedRow*, 4>& row = answers.row;

    const float turn = wrap_once(wi.phi - event.wr.phi);
    const ReflectionLobe::At r = constants.reflection.at_difference(turn);
    const float m_r = constants.reflection.longitudinal_density(r, wi.theta);
    const Float4 m = constants.longitudinal.density(wi.theta);
    const float x = constants.fold.sign * turn;

    std::array<Float4, 4> shape;
    shapes_of_mixtures(row, x, shape);

    const std::array<Float4, 4> s{
        load_energy(event, Lobe::tt) * (m[0] * shape[0]), load_energy(event, Lobe::trt) * (m[1] * shape[1]),
        load_energy(event, Lobe::trrt) * (m[2] * shape[2]), load_energy(event, Lobe::glint) * (m[1] * shape[3])};
    const Float4 s_residual = load_energy(event, Lobe::residual) * (inverse_two_pi * m[2]);
    // Lobes are selected, and channels mixed, by luminance, so the proposals of converged rows are shares of the
    // luminance of S.
    const Float4 proposed = (1 - uniform_share_) * ((s[0] + s[1]) + (s[2] + s[3])) + s_residual;
    const Float4 uniform = constants.uniform_pdf * Float4{m[0], m[1], m[2], m[1]};
    const float pdf = constants.inverse_luminance * luminance(glm::vec3(proposed[0], proposed[1], proposed[2])) +
                      event.selection[0] * r.azimuth_pdf * m_r + sum4(uniform);
    const glm::vec3& gain = constants.reflection_gain;
    const float s_r = r.energy_density * m_r;
    const std::array<Float4, lobe_count> by_lobe{
        Float4{gain.x, gain.y, gain.z, 0} * s_r, s[0], s[1], s[2], s_residual, s[3]};
    std::uint32_t asked = 0;
    float objective = 0;
    for (const AbsorbedRow* one : row) {
      asked += one->has_row() ? 1 : 0;
      objective += one->objective();
    }
    put_value(value, by_lobe, std::max(pdf, smallest_pdf));
    value.queries = static_cast<std::uint16_t>(asked);
    value.exact_queries = 0;
    value.objective = objective;
  }

  /// TT usually has three or four components, TRT and TRRT one or two, GLINT three if it exists.
  static void shapes_of_mixtures(const std::array<const AbsorbedRow*, 4>& row, float x, std::array<Float4, 4>& shape) {
    const std::uint32_t behind[4] = {row[0]->lines_behind(), row[1]->lines_behind(), row[2]->lines_behind(),
                                     row[3]->lines_behind()};
    const AbsorbedRow& tt_behind = behind[0] > 0 ? *(row[0] + 1) : zero_density_row;
    const Float4 tt = logistic_kernels(x, *row[0], tt_behind), others = logistic_kernels(x, *row[1], *row[2]);
    shape[0] = uniform_of(*row[0]) + (components_of(*row[0], tt[0], tt[1]) + components_of(tt_behind, tt[2], tt[3]));
    shape[1] = uniform_of(*row[1]) + components_of(*row[1], others[0], others[1]);
    shape[2] = uniform_of(*row[2]) + components_of(*row[2], others[2], others[3]);
    shape[3] = splat(0);
    if (row[3] != &zero_density_row) shape[3] = uniform_of(*row[3]) + components_behind(*row[3], 0, x);
    if (behind[0] > 1) shape[0] += components_behind(*row[0], 2, x);
    if (behind[1] > 0) shape[1] += components_behind(*row[1], 1, x);
    if (behind[2] > 0) shape[2] += components_behind(*row[2], 1, x);
  }
};

std::unique_ptr<FiberModel> Make(Estimator estimator, adaptive::Service* service) {
  return std::make_unique<EllipticalModel>(estimator, service);
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::fiber
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::fiber {

HWY_EXPORT(Make);

Result<std::unique_ptr<FiberModel>> make_elliptical_model(Estimator estimator, adaptive::Service* service) {
  if (estimator != Estimator::exact) {
    if (std::optional<Error> wrong =
            wrong_service(service, make_elliptical_target()->model_name(), adaptive::SliceKind::density))
      return std::move(*wrong);
  }
  return HWY_DYNAMIC_DISPATCH(Make)(estimator, service);
}

}  // namespace tress::inline v0_2::fiber
#endif
