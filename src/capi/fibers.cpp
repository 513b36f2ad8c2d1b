// The fibers of tress.h on tress::fiber.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "capi/session.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/fiber_model.h"
#include "tress/fiber/lock_color.h"
#include "tress/fiber/principled_hair.h"
#include "tress/fiber/rough_model.h"
#include "tress/fiber/rounded_shape.h"

struct tress_fibers {
  std::shared_ptr<tress::capi::Session> session;  ///< null for models that do not learn
  std::unique_ptr<tress::fiber::FiberModel> model;
  std::uint64_t key;  ///< another for each object, so that no event is taken for that of other fibers
};

namespace tress::capi {
namespace {

using fiber::FiberParameters;

/// An event, and the stamp by which it is known. An event of another pass or model would lead to rows that are gone.
struct StampedEvent {
  fiber::FiberEvent event;
  std::uint64_t stamp;
};
static_assert(sizeof(StampedEvent) <= sizeof(tress_event) && alignof(StampedEvent) <= alignof(tress_event));
static_assert(std::is_trivially_copyable_v<StampedEvent> && std::is_trivially_destructible_v<StampedEvent>);

/// Never 0, which is the stamp of an event that was not made.
std::uint64_t stamp_of(const tress_fibers& fibers) {
  const std::uint64_t epoch = fibers.session ? fibers.session->epoch.load(std::memory_order_relaxed) : 0;
  return mix_bits(fibers.key + epoch) | 1;
}

const ErrorListener* listener_of(const tress_fibers& fibers) {
  return fibers.session ? &fibers.session->listener : nullptr;
}

/// Runs a call of a reader.
template <class Call>
tress_result read(const tress_fibers* fibers, const char* name, Call&& call) noexcept {
  if (fibers == nullptr) return guarded(nullptr, [] { return null("fibers"); });
  return guarded(listener_of(*fibers), [&]() -> Outcome {
    if (fibers->session) {
      if (Outcome early = fibers->session->refuses_readers(name)) [[unlikely]]
        return early;
    }
    return call(*fibers->model);
  });
}

/// The event behind the pointer; null if it is not one of this pass and of these fibers.
const fiber::FiberEvent* event_of(const tress_fibers& fibers, const tress_event* event) {
  const auto* stamped = std::launder(reinterpret_cast<const StampedEvent*>(event->bytes));
  return stamped->stamp == stamp_of(fibers) ? &stamped->event : nullptr;
}

/// Runs a call of a reader for each of a batch of events.
template <class Call>
tress_result at_events(const tress_fibers* fibers, const tress_event* events, std::size_t count, const char* name,
                       Call&& call) noexcept {
  return read(fibers, name, [&](const fiber::FiberModel& model) -> Outcome {
    if (events == nullptr) return null("event");
    return each(count, [&](std::size_t i) -> Outcome {
      const fiber::FiberEvent* known = event_of(*fibers, events + i);
      if (known == nullptr) [[unlikely]]
        return Refusal{TRESS_INVALID_CALL, {"", name, "an event of these fibers and of this pass", "another"}};
      return call(model, *known, i);
    });
  });
}

void set(float (&to)[3], const glm::vec3& color) {
  to[0] = color.x;
  to[1] = color.y;
  to[2] = color.z;
}

glm::vec3 color_of(const float (&from)[3]) { return {from[0], from[1], from[2]}; }

tress_fiber_value value_of(const fiber::FiberValue& from) {
  tress_fiber_value value;
  set(value.value, from.total());
  value.pdf = from.pdf;
  return value;
}

tress_fiber_sample sample_of(const fiber::FiberSample& from) {
  tress_fiber_sample sample{};
  sample.direction = {from.wi.theta, from.wi.phi};
  sample.at = value_of(from.value);
  sample.lobe = static_cast<uint32_t>(from.lobe);
  if (from.value.pdf > 0) set(sample.weight, from.value.total() / from.value.pdf);
  return sample;
}

fiber::FiberDirection direction_of(const tress_direction& from) { return {from.theta, from.phi}; }

Outcome unknown(std::uint32_t id) { return invalid("fiber", "an id of tress_fibers_add()", std::to_string(id)); }

FiberParameters parameters_of(const tress_fiber& from) {
  FiberParameters to;
  to.eta = from.eta;
  to.eccentricity = from.eccentricity;
  to.roughness = from.roughness;
  to.tilt = from.tilt;
  to.sigma_a = color_of(from.sigma_a);
  to.medulla_radius = from.medulla_radius;
  to.medulla_scattering = from.medulla_scattering;
  to.medulla_asymmetry = from.medulla_asymmetry;
  to.medulla_absorption = from.medulla_absorption;
  to.cortex_scattering = from.cortex_scattering;
  to.cortex_asymmetry = from.cortex_asymmetry;
  to.wetness = from.wetness;
  for (std::size_t i = 0; i < to.azimuthal_sigma.size(); ++i)
    if (from.azimuthal_sigma[i] != 0) to.azimuthal_sigma[i] = from.azimuthal_sigma[i];
  for (std::size_t i = 0; i < to.longitudinal_lambda.size(); ++i)
    if (from.longitudinal_lambda[i] != 0) to.longitudinal_lambda[i] = from.longitudinal_lambda[i];
  for (std::size_t i = 0; i < to.gain.size(); ++i) to.gain[i] = color_of(from.gain[i]);
  to.split_glint = from.split_glint != 0;
  to.longitudinal_shape = static_cast<fiber::LongitudinalShape>(from.longitudinal_shape);
  return to;
}

Outcome wrong_range(const FiberParameters& parameters) {
  if (const auto shape = static_cast<std::uint32_t>(parameters.longitudinal_shape); shape > TRESS_CAUCHY)
    return invalid("tress_fiber::longitudinal_shape", "TRESS_LOGISTIC, TRESS_GAUSSIAN or TRESS_CAUCHY",
                   std::to_string(shape));
  std::optional<Error> error = fiber::range_error(parameters);
  if (!error) return {};
  error->place = "tress_fiber::" + error->place;
  return Refusal{TRESS_INVALID_ARGUMENT, std::move(*error)};
}

Outcome wrong_spectrum(const fiber::FiberModel& model, const float* sigma_a, const float* out, std::size_t channels) {
  if (sigma_a == nullptr || out == nullptr) return null(sigma_a == nullptr ? "sigma_a" : "s");
  if (!model.has_spectra()) return invalid("fibers", "those of TRESS_ROUGH", "another model");
  for (std::size_t i = 0; i < channels; ++i) {
    if (!(sigma_a[i] >= 0 && std::isfinite(sigma_a[i])))
      return invalid("sigma_a", "finite numbers >= 0", std::to_string(sigma_a[i]));
  }
  return {};
}

std::uint64_t next_key() {
  static std::atomic<std::uint64_t> keys{0};
  return mix_bits(keys.fetch_add(1) + 1);
}

}  // namespace
}  // namespace tress::capi

using namespace tress;
using namespace tress::capi;

extern "C" {

tress_result tress_fibers_create(tress_service* service, uint32_t model, uint32_t estimator,
                                 tress_fibers** fibers) noexcept {
  if (fibers != nullptr) *fibers = nullptr;
  const auto make = [&](Session* session) -> Outcome {
    if (fibers == nullptr) return null("fibers");
    constexpr fiber::Estimator estimators[] = {fiber::Estimator::fitted, fiber::Estimator::exact,
                                               fiber::Estimator::corrected};
    if (model > TRESS_ELLIPTICAL) return invalid("model", "TRESS_ROUGH or TRESS_ELLIPTICAL", std::to_string(model));
    if (estimator > TRESS_CORRECTED)
      return invalid("estimator", "TRESS_FITTED, TRESS_EXACT or TRESS_CORRECTED", std::to_string(estimator));
    adaptive::Service* learner = session != nullptr ? session->service.get() : nullptr;
    if (session != nullptr && !session->is_for_fibers)
      return invalid("service", "one of tress_service_create_for_fibers()", "one of another target");
    auto made = model == TRESS_ROUGH ? fiber::make_rough_model(estimators[estimator], learner)
                                     : fiber::make_elliptical_model(estimators[estimator], learner);
    if (!made) return Refusal{TRESS_INVALID_ARGUMENT, made.error()};
    *fibers = new tress_fibers{service != nullptr ? service->session : nullptr, *std::move(made), next_key()};
    return {};
  };
  if (service == nullptr) return guarded(nullptr, [&] { return make(nullptr); });
  return guarded(&service->session->listener, [&] {
    return service->session->alone("tress_fibers_create", [&] { return make(service->session.get()); });
  });
}

void tress_fibers_release(tress_fibers* fibers) noexcept { delete fibers; }

void tress_fiber_init(tress_fiber* fiber) noexcept {
  if (fiber == nullptr) return;
  const FiberParameters defaults;
  *fiber = {};
  fiber->eta = defaults.eta;
  fiber->eccentricity = defaults.eccentricity;
  fiber->roughness = defaults.roughness;
  fiber->tilt = defaults.tilt;
  set(fiber->sigma_a, defaults.sigma_a);
  for (std::size_t i = 0; i < defaults.gain.size(); ++i) set(fiber->gain[i], defaults.gain[i]);
}

tress_result tress_fiber_set_color(tress_fiber* fiber, const float color[3]) noexcept {
  return guarded(nullptr, [&]() -> Outcome {
    if (fiber == nullptr || color == nullptr) return null(fiber == nullptr ? "fiber" : "color");
    FiberParameters parameters = parameters_of(*fiber);
    parameters.sigma_a = glm::vec3(0.0f);
    if (Outcome early = wrong_range(parameters)) return early;
    if (!std::isfinite(color[0]) || !std::isfinite(color[1]) || !std::isfinite(color[2]))
      return invalid("color", "finite numbers", "others");
    set(fiber->sigma_a, fiber::sigma_a_of_lock({color[0], color[1], color[2]}, parameters));
    return {};
  });
}

tress_result tress_fiber_set_principled(tress_fiber* fiber, float roughness, float radial_roughness,
                                        float coat) noexcept {
  return guarded(nullptr, [&]() -> Outcome {
    if (fiber == nullptr) return null("fiber");
    for (const float share : {roughness, radial_roughness, coat})
      if (!(share >= 0 && share <= 1))
        return invalid("roughness, radial_roughness, coat", "numbers in [0, 1]", "others");
    const FiberParameters round = fiber::fiber_of(fiber::PrincipledHair{.roughness = roughness,
                                                                        .radial_roughness = radial_roughness,
                                                                        .coat = coat,
                                                                        .widths = fiber::PrincipledWidths::equal});
    fiber->eccentricity = round.eccentricity;
    fiber->roughness = round.roughness;
    for (std::size_t p = 0; p < round.azimuthal_sigma.size(); ++p)
      fiber->azimuthal_sigma[p] = *round.azimuthal_sigma[p];
    for (std::size_t p = 0; p < round.longitudinal_lambda.size(); ++p)
      fiber->longitudinal_lambda[p] = *round.longitudinal_lambda[p];
    fiber->longitudinal_shape = static_cast<std::uint32_t>(round.longitudinal_shape);
    return {};
  });
}

tress_result tress_fiber_round(tress_fiber* fiber, const float u[3]) noexcept {
  return guarded(nullptr, [&]() -> Outcome {
    if (fiber == nullptr || u == nullptr) return null(fiber == nullptr ? "fiber" : "u");
    const FiberParameters parameters = parameters_of(*fiber);
    if (Outcome early = wrong_range(parameters)) return early;
    if (!std::all_of(u, u + 3, [](float x) { return x >= 0 && x < 1; }))
      return invalid("u", "numbers in [0, 1)", "others");
    const FiberParameters rounded = fiber::rounded_shape(parameters, {u[0], u[1], u[2]});
    fiber->eccentricity = rounded.eccentricity;
    fiber->roughness = rounded.roughness;
    fiber->tilt = rounded.tilt;
    fiber->medulla_radius = rounded.medulla_radius;
    fiber->medulla_asymmetry = rounded.medulla_asymmetry;
    fiber->cortex_asymmetry = rounded.cortex_asymmetry;
    fiber->wetness = rounded.wetness;
    return {};
  });
}

tress_result tress_fibers_add(tress_fibers* fibers, const tress_fiber* fiber, uint32_t* id) noexcept {
  if (id != nullptr) *id = fiber::no_fiber;
  if (fibers == nullptr) return guarded(nullptr, [] { return null("fibers"); });
  const auto add = [&]() -> Outcome {
    if (fiber == nullptr || id == nullptr) return null(fiber == nullptr ? "fiber" : "id");
    const FiberParameters parameters = parameters_of(*fiber);
    if (Outcome early = wrong_range(parameters)) return early;
    *id = fibers->model->add_fiber(parameters);
    if (*id != fiber::no_fiber) return {};
    return Refusal{TRESS_INVALID_CALL,
                   {"", "tress_fibers_add", "a call between two passes", "one that the service refused"}};
  };
  return guarded(listener_of(*fibers),
                 [&] { return fibers->session ? fibers->session->alone("tress_fibers_add", add) : add(); });
}

tress_result tress_fibers_begin_n(const tress_fibers* fibers, const tress_vertex* vertices, size_t count,
                                  tress_event* events) noexcept {
  clear(events, count);
  return read(fibers, "tress_fibers_begin", [&](const fiber::FiberModel& model) -> Outcome {
    if (events == nullptr || vertices == nullptr) return null(events == nullptr ? "event" : "vertices");
    return each(count, [&](size_t i) -> Outcome {
      const tress_vertex& at = vertices[i];
      const fiber::FiberEvent event = model.begin(at.fiber, direction_of(at.wr), at.xi1, at.xi2, at.h, at.importance);
      if (event.fiber == fiber::no_fiber) [[unlikely]]
        return unknown(at.fiber);
      new (events[i].bytes) StampedEvent{event, stamp_of(*fibers)};
      return {};
    });
  });
}

tress_result tress_fibers_begin(const tress_fibers* fibers, uint32_t fiber, tress_direction wr, float xi1, float xi2,
                                float h, float importance, tress_event* event) noexcept {
  const tress_vertex vertex{fiber, wr, xi1, xi2, h, importance};
  return tress_fibers_begin_n(fibers, &vertex, 1, event);
}

tress_result tress_fibers_sample_n(const tress_fibers* fibers, const tress_event* events, const float* u, size_t count,
                                   tress_fiber_sample* samples) noexcept {
  clear(samples, count);
  return at_events(fibers, events, count, "tress_fibers_sample",
                   [&](const fiber::FiberModel& model, const fiber::FiberEvent& known, size_t i) -> Outcome {
                     if (u == nullptr || samples == nullptr) return null(u == nullptr ? "u" : "sample");
                     const float* of = u + 4 * i;
                     samples[i] = sample_of(model.sample(known, {of[0], of[1], of[2], of[3]}));
                     return {};
                   });
}

tress_result tress_fibers_sample(const tress_fibers* fibers, const tress_event* event, const float u[4],
                                 tress_fiber_sample* sample) noexcept {
  return tress_fibers_sample_n(fibers, event, u, 1, sample);
}

tress_result tress_fibers_evaluate_n(const tress_fibers* fibers, const tress_event* events, const tress_direction* wi,
                                     size_t count, tress_fiber_value* values) noexcept {
  clear(values, count);
  return at_events(fibers, events, count, "tress_fibers_evaluate",
                   [&](const fiber::FiberModel& model, const fiber::FiberEvent& known, size_t i) -> Outcome {
                     if (wi == nullptr || values == nullptr) return null(wi == nullptr ? "wi" : "value");
                     values[i] = value_of(model.evaluate(known, direction_of(wi[i])));
                     return {};
                   });
}

tress_result tress_fibers_evaluate(const tress_fibers* fibers, const tress_event* event, tress_direction wi,
                                   tress_fiber_value* value) noexcept {
  return tress_fibers_evaluate_n(fibers, event, &wi, 1, value);
}

tress_result tress_fibers_pdf(const tress_fibers* fibers, const tress_event* event, tress_direction wi,
                              float* pdf) noexcept {
  clear(pdf, 1);
  return at_events(fibers, event, 1, "tress_fibers_pdf",
                   [&](const fiber::FiberModel& model, const fiber::FiberEvent& known, size_t) -> Outcome {
                     if (pdf == nullptr) return null("pdf");
                     *pdf = model.pdf(known, direction_of(wi));
                     return {};
                   });
}

tress_result tress_fibers_evaluate_spectrum(const tress_fibers* fibers, const tress_event* event, tress_direction wi,
                                            const float* sigma_a, size_t channels, float* s, float* pdf) noexcept {
  clear(s, channels);
  clear(pdf, 1);
  return at_events(fibers, event, 1, "tress_fibers_evaluate_spectrum",
                   [&](const fiber::FiberModel& model, const fiber::FiberEvent& known, size_t) -> Outcome {
                     if (Outcome early = wrong_spectrum(model, sigma_a, s, channels)) return early;
                     const float density =
                         model.evaluate_spectrum(known, direction_of(wi), {sigma_a, channels}, {s, channels});
                     if (pdf != nullptr) *pdf = density;
                     return {};
                   });
}

tress_result tress_fibers_sample_spectrum(const tress_fibers* fibers, const tress_event* event, const float u[4],
                                          const float* sigma_a, size_t channels, tress_fiber_sample* sample,
                                          float* weights) noexcept {
  clear(sample, 1);
  clear(weights, channels);
  return at_events(fibers, event, 1, "tress_fibers_sample_spectrum",
                   [&](const fiber::FiberModel& model, const fiber::FiberEvent& known, size_t) -> Outcome {
                     if (u == nullptr || sample == nullptr) return null(u == nullptr ? "u" : "sample");
                     if (Outcome early = wrong_spectrum(model, sigma_a, weights, channels)) return early;
                     const std::span<float> s(weights, channels);
                     *sample =
                         sample_of(model.sample_spectrum(known, {u[0], u[1], u[2], u[3]}, {sigma_a, channels}, s));
                     for (float& one : s) one = sample->at.pdf > 0 ? one / sample->at.pdf : 0;
                     return {};
                   });
}

tress_result tress_fibers_mean(const tress_fibers* fibers, uint32_t fiber, tress_direction wr, tress_direction wi,
                               tress_fiber_value* value) noexcept {
  clear(value, 1);
  return read(fibers, "tress_fibers_mean", [&](const fiber::FiberModel& model) -> Outcome {
    if (value == nullptr) return null("value");
    if (!model.has(fiber)) return unknown(fiber);
    *value = value_of(model.mean(fiber, direction_of(wr), direction_of(wi)));
    return {};
  });
}

tress_result tress_fibers_sample_mean(const tress_fibers* fibers, uint32_t fiber, tress_direction wr, const float u[6],
                                      float importance, tress_fiber_sample* sample) noexcept {
  clear(sample, 1);
  return read(fibers, "tress_fibers_sample_mean", [&](const fiber::FiberModel& model) -> Outcome {
    if (u == nullptr || sample == nullptr) return null(u == nullptr ? "u" : "sample");
    if (!model.has(fiber)) return unknown(fiber);
    *sample = sample_of(model.sample_mean(fiber, direction_of(wr), {u[0], u[1], u[2], u[3], u[4], u[5]}, importance));
    return {};
  });
}

int tress_fibers_takes_lights(const tress_fibers* fibers, const tress_event* event) noexcept {
  int takes = 0;
  at_events(fibers, event, 1, "tress_fibers_takes_lights",
            [&](const fiber::FiberModel& model, const fiber::FiberEvent& known, size_t) -> Outcome {
              takes = model.evaluates(known) || model.estimates(known) ? 1 : 0;
              return {};
            });
  return takes;
}

size_t tress_fibers_bytes(const tress_fibers* fibers) noexcept {
  return fibers == nullptr ? 0 : fibers->model->bytes();
}
}
