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
#include <string>
#include <type_traits>
#include <utility>

#include "capi/session.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/fiber_model.h"
#include "tress/fiber/lock_color.h"
#include "tress/fiber/rough_model.h"

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

/// The event behind the pointer; null if it is none of this pass and of these fibers.
const fiber::FiberEvent* event_of(const tress_fibers& fibers, const tress_event* event) {
  const auto* stamped = std::launder(reinterpret_cast<const StampedEvent*>(event->bytes));
  return stamped->stamp == stamp_of(fibers) ? &stamped->event : nullptr;
}

template <class Call>
tress_result at_event(const tress_fibers* fibers, const tress_event* event, const char* name, Call&& call) noexcept {
  return read(fibers, name, [&](const fiber::FiberModel& model) -> Outcome {
    if (event == nullptr) return null("event");
    const fiber::FiberEvent* known = event_of(*fibers, event);
    if (known == nullptr) [[unlikely]]
      return Refusal{TRESS_INVALID_CALL, {"", name, "an event of these fibers and of this pass", "another"}};
    return call(model, *known);
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
  for (std::size_t i = 0; i < to.azimuthal_sigma.size(); ++i)
    if (from.azimuthal_sigma[i] != 0) to.azimuthal_sigma[i] = from.azimuthal_sigma[i];
  for (std::size_t i = 0; i < to.longitudinal_lambda.size(); ++i)
    if (from.longitudinal_lambda[i] != 0) to.longitudinal_lambda[i] = from.longitudinal_lambda[i];
  for (std::size_t i = 0; i < to.gain.size(); ++i) to.gain[i] = color_of(from.gain[i]);
  to.split_glint = from.split_glint != 0;
  return to;
}

Outcome wrong_range(const FiberParameters& parameters) {
  const char* name = fiber::out_of_range(parameters);
  if (name == nullptr) return {};
  return invalid((std::string("tress_fiber::") + name).c_str(), "a number within its range", "another");
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

tress_result tress_fibers_begin(const tress_fibers* fibers, uint32_t fiber, tress_direction wr, float xi1, float xi2,
                                float h, float importance, tress_event* event) noexcept {
  const tress_result result = read(fibers, "tress_fibers_begin", [&](const fiber::FiberModel& model) -> Outcome {
    if (event == nullptr) return null("event");
    const auto* begun = new (event->bytes)
        StampedEvent{model.begin(fiber, {wr.theta, wr.phi}, xi1, xi2, h, importance), stamp_of(*fibers)};
    if (begun->event.fiber != fiber::no_fiber) [[likely]]
      return {};
    return invalid("fiber", "an id of tress_fibers_add()", std::to_string(fiber));
  });
  if (result != TRESS_OK && event != nullptr) std::memset(event, 0, sizeof *event);
  return result;
}

tress_result tress_fibers_sample(const tress_fibers* fibers, const tress_event* event, const float u[4],
                                 tress_fiber_sample* sample) noexcept {
  if (sample != nullptr) *sample = {};
  return at_event(fibers, event, "tress_fibers_sample",
                  [&](const fiber::FiberModel& model, const fiber::FiberEvent& known) -> Outcome {
                    if (u == nullptr || sample == nullptr) return null(u == nullptr ? "u" : "sample");
                    const fiber::FiberSample drawn = model.sample(known, {u[0], u[1], u[2], u[3]});
                    sample->direction = {drawn.wi.theta, drawn.wi.phi};
                    sample->at = value_of(drawn.value);
                    sample->lobe = static_cast<uint32_t>(drawn.lobe);
                    if (drawn.value.pdf > 0) set(sample->weight, drawn.value.total() / drawn.value.pdf);
                    return {};
                  });
}

tress_result tress_fibers_evaluate(const tress_fibers* fibers, const tress_event* event, tress_direction wi,
                                   tress_fiber_value* value) noexcept {
  if (value != nullptr) *value = {};
  return at_event(fibers, event, "tress_fibers_evaluate",
                  [&](const fiber::FiberModel& model, const fiber::FiberEvent& known) -> Outcome {
                    if (value == nullptr) return null("value");
                    *value = value_of(model.evaluate(known, {wi.theta, wi.phi}));
                    return {};
                  });
}

int tress_fibers_takes_lights(const tress_fibers* fibers, const tress_event* event) noexcept {
  int takes = 0;
  at_event(fibers, event, "tress_fibers_takes_lights",
           [&](const fiber::FiberModel& model, const fiber::FiberEvent& known) -> Outcome {
             takes = model.evaluates(known) || model.estimates(known) ? 1 : 0;
             return {};
           });
  return takes;
}

size_t tress_fibers_bytes(const tress_fibers* fibers) noexcept {
  return fibers == nullptr ? 0 : fibers->model->bytes();
}
}
