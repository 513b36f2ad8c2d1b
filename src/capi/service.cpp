// The service of tress.h on tress::adaptive.
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "capi/session.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/query.h"
#include "tress/adaptive/telemetry.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/rough_model.h"

struct tress_rays {
  std::vector<tress::adaptive::TracedRay>& out;
};
struct tress_exits {
  std::vector<tress::adaptive::SampledExit>& out;
};

namespace tress::capi {

thread_local const Session* Session::inside = nullptr;

namespace {

using adaptive::RowView;
using adaptive::SliceDescription;
using adaptive::SliceKind;

constexpr std::uint32_t most_threads = 4096;
constexpr std::size_t most_nodes_of_axis = 65536;

/// No more than oneTBB has: it prints a warning where an arena asks for more.
int threads_of(const tress_options& settings) {
  const std::size_t most = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return settings.threads == 0 ? tbb::task_arena::automatic
                               : static_cast<int>(std::min<std::size_t>(settings.threads, most));
}

adaptive::Options options_of(const tress_options& settings) {
  adaptive::Options options;
  options.epsilon = settings.epsilon;
  options.sampled_epsilon = settings.sampled_epsilon;
  options.picture_error = settings.picture_error;
  options.memory_bytes = settings.memory_bytes;
  options.heard_share = settings.heard_share;
  options.seed = settings.seed;
  options.learns_to_epsilon = settings.learns_to_epsilon != 0;
  options.check_passes = settings.check_passes != 0;
  if (settings.on_log != nullptr) {
    options.log = [call = settings.on_log, user = settings.user](const std::string& sentence) {
      call(user, sentence.c_str());
    };
  }
  if (settings.on_progress != nullptr) {
    options.progress = [call = settings.on_progress, user = settings.user](double done) {
      return call(user, done) != 0;
    };
  }
  if (settings.on_memory != nullptr) {
    options.memory_monitor = [call = settings.on_memory, user = settings.user](std::int64_t bytes, bool post) {
      return call(user, bytes, post ? 1 : 0) != 0;
    };
  }
  if (settings.parallel_for != nullptr) {
    using Task = const std::function<void(std::size_t)>;
    options.parallel_for = [call = settings.parallel_for, user = settings.user](std::size_t count, Task& task) {
      call(
          user, count, [](void* data, std::size_t i) { (*static_cast<Task*>(data))(i); },
          const_cast<void*>(static_cast<const void*>(&task)));
    };
  }
  return options;
}

Outcome unusable(const tress_options& settings) {
  if (settings.threads > most_threads)
    return invalid("tress_options::threads", "a number from 0 to " + std::to_string(most_threads),
                   std::to_string(settings.threads));
  adaptive::Options options = options_of(settings);
  const std::vector<Error> unusable = adaptive::make_usable(options);
  if (unusable.empty()) return {};
  const auto& [file, option, expected, found] = unusable.front();
  return invalid(("tress_options::" + option).c_str(), expected, found);
}

tress_place place_of(const SliceDescription& slice, float a, float b) {
  tress_place place{};
  place.lobe = slice.key.lobe;
  std::ranges::copy(slice.key.parameters, place.parameters);
  place.a = a;
  place.b = b;
  place.blur = slice.blur_rad;
  return place;
}

/// The target of a host by its callbacks, of either kind or both. Calls of the session from inside them are refused.
class HostTarget final : public adaptive::Target, public adaptive::SampledTarget {
 public:
  HostTarget(const tress_target& target, const Session& session)
      : target_(target), name_(target.name), session_(session) {}
  std::string model_name() const override { return name_; }
  std::uint32_t parts(const SliceDescription&) const override { return target_.parts; }
  void trace(const SliceDescription& slice, float a, float b, std::vector<adaptive::TracedRay>& out) const override {
    const tress_place place = place_of(slice, a, b);
    tress_rays rays{out};
    ask([&] { return target_.trace(target_.user, &place, &rays); });
  }
  void draw(const SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
            std::uint32_t count, std::vector<adaptive::SampledExit>& out) const override {
    const tress_place place = place_of(slice, a, b);
    tress_exits exits{out};
    ask([&] { return target_.draw(target_.user, &place, stream, first, count, &exits); });
  }

 private:
  /// Makes a call of the host, which returns 0 if it failed.
  template <class Call>
  void ask(Call&& call) const {
    struct Inside {
      explicit Inside(const Session* session) : before(std::exchange(Session::inside, session)) {}
      ~Inside() { Session::inside = before; }
      const Session* before;
    } const inside(&session_);
    if (call() == 0) throw std::runtime_error("a callback that failed");
  }

  tress_target target_;
  std::string name_;
  const Session& session_;
};

/// Creates a handle. fill: gives the session its targets.
template <class Fill>
tress_result create(const tress_options* given, tress_service** service, Fill&& fill) noexcept {
  tress_options settings;
  tress_options_init(&settings);
  if (given != nullptr) settings = *given;
  const ErrorListener listener{settings.user, settings.on_error};
  return guarded(&listener, [&]() -> Outcome {
    if (service == nullptr) return null("service");
    *service = nullptr;
    if (Outcome early = unusable(settings)) return early;
    auto session = std::make_shared<Session>(settings);
    if (Outcome early = fill(*session)) return early;
    adaptive::Options options = options_of(settings);
    if (options.progress) {
      options.progress = [goes_on = std::move(options.progress), &ended = session->progress_ended](double done) {
        if (goes_on(done)) return true;
        ended = true;
        return false;
      };
    }
    const adaptive::Target* densities = session->densities.get();
    const adaptive::SampledTarget* samples = session->samples.get();
    session->service = densities == nullptr ? std::make_unique<adaptive::Service>(options, *samples)
                       : samples == nullptr ? std::make_unique<adaptive::Service>(options, *densities)
                                            : std::make_unique<adaptive::Service>(options, *densities, *samples);
    *service = new tress_service{std::move(session)};
    return {};
  });
}

Outcome ended_by_progress(const char* name) {
  return Refusal{TRESS_CANCELLED, {"", name, "the whole of the work", "on_progress that ended it"}};
}

/// Runs a call of the host between passes.
template <class Call>
tress_result alone(tress_service* service, const char* name, Call&& call) noexcept {
  if (service == nullptr) return guarded(nullptr, [] { return null("service"); });
  return guarded(&service->session->listener,
                 [&] { return service->session->alone(name, [&] { return call(*service->session); }); });
}

/// Runs a call of a reader.
template <class Call>
tress_result read(const tress_service* service, const char* name, Call&& call) noexcept {
  if (service == nullptr) return guarded(nullptr, [] { return null("service"); });
  return guarded(&service->session->listener, [&]() -> Outcome {
    if (Outcome early = service->session->refuses_readers(name)) return early;
    return call(*service->session->service);
  });
}

Outcome wrong_node(const SliceDescription& slice, const tress_node& node) {
  if (node.a < slice.axis_a.size() && node.b < slice.axis_b.size()) [[likely]]
    return {};
  return invalid(
      "node", "one of the slice's " + std::to_string(slice.axis_a.size()) + " x " + std::to_string(slice.axis_b.size()),
      "a " + std::to_string(node.a) + ", b " + std::to_string(node.b) + " of slice " + std::to_string(node.slice));
}

/// Runs a call of a reader at a node.
template <class Call>
tress_result at_node(const tress_service* service, const char* name, const tress_node& node, Call&& call) noexcept {
  return read(service, name, [&](const adaptive::Service& of) -> Outcome {
    const SliceDescription& slice = of.slice(node.slice);
    if (Outcome early = wrong_node(slice, node)) return early;
    return call(of, slice);
  });
}

Outcome wrong_place(float first, float second, const char* name) {
  if (std::isfinite(first) && std::isfinite(second)) return {};
  return invalid(name, "finite numbers", "others");
}

/// Runs a call of a reader at a place of a slice.
template <class Call>
tress_result at_place(const tress_service* service, const char* name, std::uint32_t slice, float a, float b,
                      Call&& call) noexcept {
  return read(service, name, [&](const adaptive::Service& of) -> Outcome {
    if (of.slice(slice).node_count() == 0) return invalid("slice", "one that was added", std::to_string(slice));
    if (Outcome early = wrong_place(a, b, "a, b")) return early;
    return call(of);
  });
}

tress_value value_of(const adaptive::NodeValue& from) {
  tress_value value{};
  value.azimuth = from.azimuth;
  value.height = from.height;
  value.density = from.density;
  std::ranges::copy(from.parts, value.parts);
  value.pdf = from.pdf;
  value.state = static_cast<std::uint32_t>(from.state);
  value.answered = from.answered ? 1 : 0;
  return value;
}

adaptive::Node node_of(const tress_node& node) { return {node.slice, node.a, node.b}; }

std::vector<std::uint32_t> every(std::uint32_t step, std::size_t count) {
  std::vector<std::uint32_t> chosen;
  for (std::size_t i = 0; i + 1 < count; i += step) chosen.push_back(static_cast<std::uint32_t>(i));
  chosen.push_back(static_cast<std::uint32_t>(count - 1));
  return chosen;
}

Outcome set_coarse(const tress_slice& slice, SliceDescription& description) {
  std::uint32_t before = 0;
  for (const std::uint32_t step : slice.coarse_steps) {
    if (step == 0) break;
    if (step < 2 || (before != 0 && (before % step != 0 || before == step)))
      return invalid("tress_slice::coarse_steps", "steps above 1, each a multiple of the next", std::to_string(step));
    description.coarse.push_back({every(step, slice.count_a), every(step, slice.count_b)});
    before = step;
  }
  return {};
}

tress_report report_of(const adaptive::PassReport& pass) {
  tress_report report{};
  report.queries = pass.queries;
  report.converged_queries = pass.converged_queries;
  report.answered_queries = pass.answered_queries;
  report.rows_open = pass.rows_open;
  report.rows_converged = pass.rows_converged;
  report.rows_refused = pass.rows_refused;
  report.bytes = pass.bytes;
  report.at_ceiling = pass.at_ceiling || pass.forms_made_anew > 0 ? 1 : 0;
  report.objective_p90 = pass.objective_p90;
  report.bias_bound = pass.bias_bound;
  report.learning_cpu_seconds = pass.learning_cpu_seconds;
  return report;
}

}  // namespace

Session::Session(const tress_options& settings)
    : listener{settings.user, settings.on_error}, arena(threads_of(settings)) {}

Outcome Session::being_changed(const char* name) {
  return Refusal{TRESS_INVALID_CALL, {"", name, "no other call", "one that changes the service"}};
}

Outcome Session::refused(const char* name) const {
  if (inside != this) return {};
  return Refusal{TRESS_INVALID_CALL, {"", name, "a call from outside of the target", "one from its callback"}};
}

}  // namespace tress::capi

using namespace tress;
using namespace tress::capi;

extern "C" {

void tress_add_rays(tress_rays* list, const tress_ray* rays, size_t count) noexcept {
  if (list == nullptr || rays == nullptr) return;
  guarded(nullptr, [&]() -> Outcome {
    for (size_t i = 0; i < count; ++i) list->out.push_back({rays[i].azimuth, rays[i].weight, rays[i].attribute});
    return {};
  });
}

void tress_add_exits(tress_exits* list, const tress_exit* exits, size_t count) noexcept {
  if (list == nullptr || exits == nullptr) return;
  guarded(nullptr, [&]() -> Outcome {
    for (size_t i = 0; i < count; ++i) {
      const tress_exit& one = exits[i];
      list->out.push_back({one.azimuth, one.height, one.part, one.weight, one.attribute});
    }
    return {};
  });
}

void tress_options_init(tress_options* options) noexcept {
  if (options == nullptr) return;
  const adaptive::Options defaults;
  *options = {};
  options->epsilon = defaults.epsilon;
  options->sampled_epsilon = defaults.sampled_epsilon;
  options->picture_error = defaults.picture_error;
  options->memory_bytes = defaults.memory_bytes;
  options->heard_share = defaults.heard_share;
  options->seed = defaults.seed;
}

tress_result tress_service_create(const tress_target* target, const tress_options* options,
                                  tress_service** service) noexcept {
  return create(options, service, [&](Session& session) -> Outcome {
    if (target == nullptr) return null("target");
    if (target->name == nullptr) return null("tress_target::name");
    if (!adaptive::is_model_name(target->name))
      return invalid("tress_target::name", "1 to 256 printable ASCII characters", target->name);
    if (target->trace == nullptr && target->draw == nullptr)
      return invalid("tress_target", "trace, draw or both", "neither");
    if (target->draw != nullptr && (target->parts == 0 || target->parts > adaptive::SampledTarget::most_parts))
      return invalid("tress_target::parts", "1 to 4", std::to_string(target->parts));
    const auto host = std::make_shared<const HostTarget>(*target, session);
    if (target->trace != nullptr) session.densities = host;
    if (target->draw != nullptr) session.samples = host;
    return {};
  });
}

tress_result tress_service_create_for_fibers(const tress_options* options, tress_service** service) noexcept {
  return create(options, service, [](Session& session) -> Outcome {
    session.densities = fiber::make_elliptical_target();
    session.samples = fiber::make_rough_target();
    session.is_for_fibers = true;
    return {};
  });
}

void tress_service_release(tress_service* service) noexcept { delete service; }

void tress_slice_init(tress_slice* slice) noexcept {
  if (slice == nullptr) return;
  *slice = {};
  slice->blur = SliceDescription{}.blur_rad;
}

tress_result tress_service_add_slice(tress_service* service, const tress_slice* slice, uint32_t* id) noexcept {
  if (id != nullptr) *id = 0;
  return alone(service, "tress_service_add_slice", [&](Session& session) -> Outcome {
    if (slice == nullptr || id == nullptr) return null(slice == nullptr ? "slice" : "id");
    if (session.is_for_fibers)  // whose targets take the parameters that tress_fibers_add() has checked
      return invalid("service", "one of tress_service_create()", "one for fibers");
    if (slice->kind != TRESS_DENSITIES && slice->kind != TRESS_SAMPLES)
      return invalid("tress_slice::kind", "TRESS_DENSITIES or TRESS_SAMPLES", std::to_string(slice->kind));
    if (slice->axis_a == nullptr || slice->axis_b == nullptr) return null("tress_slice::axis_a, axis_b");
    for (const size_t count : {slice->count_a, slice->count_b}) {
      if (count == 0 || count > most_nodes_of_axis)
        return invalid("tress_slice::count_a, count_b", "1 to 65536 nodes of an axis", std::to_string(count));
    }
    if (std::uint64_t{slice->count_a} * slice->count_b > RowView::no_row)
      return invalid("tress_slice::count_a, count_b", "less than 2^32 nodes", "more");
    SliceDescription description;
    description.kind = slice->kind == TRESS_SAMPLES ? SliceKind::samples : SliceKind::density;
    description.key.lobe = slice->lobe;
    std::ranges::copy(slice->parameters, description.key.parameters.begin());
    description.axis_a.assign(slice->axis_a, slice->axis_a + slice->count_a);
    description.axis_b.assign(slice->axis_b, slice->axis_b + slice->count_b);
    description.blur_rad = slice->blur;
    if (Outcome early = set_coarse(*slice, description)) return early;
    const Result<adaptive::SliceId> added = session.service->add_slice(description);
    if (!added) return Refusal{TRESS_INVALID_ARGUMENT, added.error()};
    *id = *added;
    return {};
  });
}

tress_result tress_service_load(tress_service* service, const char* path) noexcept {
  return alone(service, "tress_service_load", [&](Session& session) -> Outcome {
    if (path == nullptr) return null("path");
    if (session.is_asked)
      return Refusal{TRESS_INVALID_CALL, {path, "", "a cache that is loaded before the first query", "a later one"}};
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) return Refusal{TRESS_FILE_MISSING, {path, "", "a file", "none"}};
    const auto file = adaptive::CacheFile::open(path, session.service->model_name());
    if (!file) return Refusal{TRESS_FILE_INVALID, file.error()};
    if (const auto error = session.service->load(**file)) return Refusal{TRESS_FILE_INVALID, *error};
    return {};
  });
}

tress_result tress_service_save(tress_service* service, const char* path) noexcept {
  return alone(service, "tress_service_save", [&](Session& session) -> Outcome {
    if (path == nullptr) return null("path");
    const auto saved = adaptive::merge_into_cache(path, *session.service->rows());
    if (!saved) return Refusal{TRESS_FILE_INVALID, saved.error()};
    if (saved->refusal) return Refusal{TRESS_FILE_INVALID, *saved->refusal};
    return {};
  });
}

tress_result tress_service_prepare(tress_service* service) noexcept {
  return alone(service, "tress_service_prepare", [](Session& session) -> Outcome {
    session.progress_ended = false;
    session.service->prepare();
    if (session.progress_ended) return ended_by_progress("tress_service_prepare");
    return {};
  });
}

tress_result tress_service_set_learning(tress_service* service, int on) noexcept {
  return alone(service, "tress_service_set_learning", [&](Session& session) -> Outcome {
    session.service->set_learning(on != 0);
    return {};
  });
}

tress_result tress_service_sample_n(const tress_service* service, const tress_node* nodes, const float* u, size_t count,
                                    tress_value* values) noexcept {
  clear(values, count);
  return read(service, "tress_service_sample", [&](const adaptive::Service& of) -> Outcome {
    if (nodes == nullptr) return null("nodes");
    if (u == nullptr || values == nullptr) return null(u == nullptr ? "u" : "value");
    return each(count, [&](size_t i) -> Outcome {
      if (Outcome early = wrong_node(of.slice(nodes[i].slice), nodes[i])) return early;
      values[i] = value_of(adaptive::sample(of, node_of(nodes[i]), {u[3 * i], u[3 * i + 1], u[3 * i + 2]}));
      return {};
    });
  });
}

tress_result tress_service_sample(const tress_service* service, tress_node node, const float u[3],
                                  tress_value* value) noexcept {
  return tress_service_sample_n(service, &node, u, 1, value);
}

tress_result tress_service_evaluate_n(const tress_service* service, const tress_node* nodes, const float* azimuths,
                                      const float* heights, size_t count, tress_value* values) noexcept {
  clear(values, count);
  return read(service, "tress_service_evaluate", [&](const adaptive::Service& of) -> Outcome {
    if (nodes == nullptr) return null("nodes");
    if (azimuths == nullptr || values == nullptr) return null(values == nullptr ? "value" : "azimuths");
    return each(count, [&](size_t i) -> Outcome {
      const float height = heights != nullptr ? heights[i] : 0;
      if (Outcome early = wrong_node(of.slice(nodes[i].slice), nodes[i])) return early;
      if (Outcome early = wrong_place(azimuths[i], height, "azimuth, height")) return early;
      values[i] = value_of(adaptive::evaluate(of, node_of(nodes[i]), azimuths[i], height));
      return {};
    });
  });
}

tress_result tress_service_evaluate(const tress_service* service, tress_node node, float azimuth, float height,
                                    tress_value* value) noexcept {
  return tress_service_evaluate_n(service, &node, &azimuth, &height, 1, value);
}

tress_result tress_service_pdf(const tress_service* service, tress_node node, float azimuth, float height,
                               float* pdf) noexcept {
  clear(pdf, 1);
  return at_node(service, "tress_service_pdf", node,
                 [&](const adaptive::Service& of, const SliceDescription&) -> Outcome {
                   if (pdf == nullptr) return null("pdf");
                   if (Outcome early = wrong_place(azimuth, height, "azimuth, height")) return early;
                   *pdf = adaptive::pdf(of, node_of(node), azimuth, height);
                   return {};
                 });
}

tress_result tress_service_choose(const tress_service* service, uint32_t slice, float a, float b, const float xi[2],
                                  tress_node* node) noexcept {
  clear(node, 1);
  return at_place(service, "tress_service_choose", slice, a, b, [&](const adaptive::Service& of) -> Outcome {
    if (xi == nullptr || node == nullptr) return null(xi == nullptr ? "xi" : "node");
    const adaptive::Node chosen = adaptive::choose(of, slice, a, b, xi[0], xi[1]);
    *node = {chosen.slice, chosen.a, chosen.b};
    return {};
  });
}

tress_result tress_service_mean(const tress_service* service, uint32_t slice, float a, float b, float azimuth,
                                float height, tress_value* value) noexcept {
  clear(value, 1);
  return at_place(service, "tress_service_mean", slice, a, b, [&](const adaptive::Service& of) -> Outcome {
    if (value == nullptr) return null("value");
    if (Outcome early = wrong_place(azimuth, height, "azimuth, height")) return early;
    *value = value_of(adaptive::mean(of, slice, a, b, azimuth, height));
    return {};
  });
}

tress_result tress_service_sample_mean(const tress_service* service, uint32_t slice, float a, float b, const float u[5],
                                       tress_value* value) noexcept {
  clear(value, 1);
  return at_place(service, "tress_service_sample_mean", slice, a, b, [&](const adaptive::Service& of) -> Outcome {
    if (u == nullptr || value == nullptr) return null(u == nullptr ? "u" : "value");
    *value = value_of(adaptive::sample_mean(of, slice, a, b, {u[0], u[1], u[2], u[3], u[4]}));
    return {};
  });
}

tress_result tress_service_credit(const tress_service* service, tress_node node, float light,
                                  uint32_t events) noexcept {
  return at_node(service, "tress_service_credit", node,
                 [&](const adaptive::Service& of, const SliceDescription&) -> Outcome {
                   if (!(light >= 0 && std::isfinite(light)))
                     return invalid("light", "a finite number >= 0", std::to_string(light));
                   of.credit(of.peek(node.slice, node.a, node.b), light, events);
                   return {};
                 });
}

tress_result tress_service_hear(const tress_service* service, tress_node node, const tress_exit* exit) noexcept {
  return at_node(service, "tress_service_hear", node,
                 [&](const adaptive::Service& of, const SliceDescription& slice) -> Outcome {
                   if (exit == nullptr) return null("exit");
                   if (slice.kind != SliceKind::samples) return invalid("node", "one of samples", "one of densities");
                   const std::uint32_t parts = service->session->samples->parts(slice);
                   if (exit->part >= parts)
                     return invalid("exit", "a part below " + std::to_string(parts), std::to_string(exit->part));
                   const bool is_finite = std::isfinite(exit->azimuth) && std::isfinite(exit->height) &&
                                          std::isfinite(exit->weight) && std::isfinite(exit->attribute);
                   if (!is_finite || exit->weight < 0 || exit->attribute < 0)
                     return invalid("exit", "finite numbers, a weight and an attribute >= 0", "others");
                   of.hear(of.peek(node.slice, node.a, node.b),
                           {exit->azimuth, exit->height, exit->part, exit->weight, exit->attribute});
                   return {};
                 });
}

tress_result tress_service_publish(tress_service* service, uint64_t paths, tress_report* report) noexcept {
  if (report != nullptr) *report = {};
  return alone(service, "tress_service_publish", [&](Session& session) -> Outcome {
    const adaptive::PassReport pass = session.service->publish(paths);
    if (report != nullptr) *report = report_of(pass);
    session.telemetry = adaptive::to_json(pass);
    if (pass.misuse) return Refusal{TRESS_MISUSE, *pass.misuse};
    if (pass.cancelled) return ended_by_progress("tress_service_publish");
    return {};
  });
}

int tress_service_publish_pays(const tress_service* service) noexcept {
  int pays = 0;
  read(service, "tress_service_publish_pays", [&](const adaptive::Service& of) -> Outcome {
    pays = of.publish_pays() ? 1 : 0;
    return {};
  });
  return pays;
}

const char* tress_service_telemetry(const tress_service* service) noexcept {
  return service == nullptr ? "" : service->session->telemetry.c_str();
}
}
