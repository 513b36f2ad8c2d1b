#include "tress/adaptive/service.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "python/arrays.h"
#include "python/bindings.h"
#include "python/names.h"
#include "python/raised.h"
#include "python/targets.h"
#include "tress/adaptive/query.h"
#include "tress/adaptive/to_string.h"

namespace py = pybind11;

namespace tress::python {
namespace {

using adaptive::NodeValue;
using adaptive::RowView;
using adaptive::SliceId;
using py::literals::operator""_a;

/// The service behind a lock: many threads at a time may query it, and only one may do anything else, as its header
/// demands.
class Learner {
 public:
  Learner(const py::object& target, bool traces, std::uint32_t parts, const adaptive::Options& options,
          py::object progress)
      : calls_(target),
        densities_(calls_, py::str(target.attr("name"))),
        samples_(calls_, py::str(target.attr("name")), std::max(1u, parts)),
        progress_(std::move(progress)) {
    adaptive::Options given = options;
    given.log = [this](const std::string& sentence) { log_.push_back(sentence); };
    if (!progress_.is_none()) given.progress = [this](double done) { return goes_on(done); };
    service_ = traces && parts > 0 ? std::make_unique<adaptive::Service>(given, densities_, samples_)
               : traces            ? std::make_unique<adaptive::Service>(given, densities_)
                                   : std::make_unique<adaptive::Service>(given, samples_);
    service_->set_row_listener([this](const adaptive::RowReport& row) { changed_.push_back(row); });
  }

  SliceId add_slice(std::uint32_t lobe, const std::vector<float>& parameters, const std::vector<float>& axis_a,
                    const std::vector<float>& axis_b, float blur_rad, bool samples,
                    const std::vector<std::pair<std::vector<std::uint32_t>, std::vector<std::uint32_t>>>& coarse,
                    std::optional<SliceId> coarse_rows_of, std::uint32_t max_components) {
    adaptive::SliceDescription slice;
    const std::size_t most = samples ? slice.key.parameters.size() : adaptive::SliceKey::density_parameters;
    if (parameters.size() > most)
      throw Raised({"", "parameters", fmt::format("at most {}", most), fmt::format("{}", parameters.size())});
    check_axis("axis_a", axis_a);
    check_axis("axis_b", axis_b);
    if (!(blur_rad > 0 && blur_rad < 10))
      throw Raised({"", "blur_rad", "a number > 0 and < 10", fmt::format("{}", blur_rad)});
    slice.key.lobe = lobe;
    std::ranges::copy(parameters, slice.key.parameters.begin());
    for (const float x : parameters)
      if (!std::isfinite(x)) throw Raised({"", "parameters", "finite numbers", fmt::format("{}", x)});
    slice.axis_a = axis_a;
    slice.axis_b = axis_b;
    slice.blur_rad = blur_rad;
    slice.kind = samples ? adaptive::SliceKind::samples : adaptive::SliceKind::density;
    slice.max_components = max_components;
    for (const auto& [nodes_a, nodes_b] : coarse) slice.coarse.push_back({nodes_a, nodes_b});
    if (!samples && (!coarse.empty() || coarse_rows_of))
      throw Raised({"", "coarse", "none for a slice of densities", "coarser rows"});
    check_coarse(slice);
    SliceId id = 0;
    alone([&] {
      if (coarse_rows_of) {
        check_slice(*coarse_rows_of);
        slice.coarse_rows_of = service_->slice(*coarse_rows_of).key;
      }
      id = checked(service_->add_slice(slice));
    });
    return id;
  }

  /// For each element: a function of query.h by name, as the columns of columns_of(). A row of numbers: for "draw" and
  /// "draw_mean" its uniforms, for "answer" and "mean" azimuth and height.
  py::tuple query(SliceId slice, const std::string& name, const py::array& a, const py::array& b,
                  const py::array& numbers) {
    const bool draws = name.starts_with("draw"), is_mean = name.ends_with("mean");
    const std::size_t columns = !draws ? 2 : is_mean ? 5 : 3;
    const Given in = given(slice, a, b, numbers, columns, !is_mean);
    std::vector<NodeValue> values(in.a.size());
    ask(in.a.size(), [&](std::size_t i) {
      const float* x = &in.numbers[columns * i];
      values[i] = !is_mean ? (draws ? adaptive::sample(*service_, in.node(slice, i), {x[0], x[1], x[2]})
                                    : adaptive::evaluate(*service_, in.node(slice, i), x[0], x[1]))
                  : draws  ? adaptive::sample_mean(*service_, slice, in.a[i], in.b[i], {x[0], x[1], x[2], x[3], x[4]})
                           : adaptive::mean(*service_, slice, in.a[i], in.b[i], x[0], x[1]);
    });
    return columns_of(values);
  }

  /// For each element: the node that adaptive::choose() gives for a row of xi.
  py::array_t<std::uint32_t> choose(SliceId slice, const py::array& a, const py::array& b, const py::array& xi) {
    const Given in = given(slice, a, b, xi, 2, false);
    std::vector<std::array<std::uint32_t, 2>> nodes(in.a.size());
    ask(nodes.size(), [&](std::size_t i) {
      const auto at = adaptive::choose(*service_, slice, in.a[i], in.b[i], in.numbers[2 * i], in.numbers[2 * i + 1]);
      nodes[i] = {at.a, at.b};
    });
    return array_of<std::uint32_t>(std::move(nodes), 2);
  }

  /// For each element, without a query: "observe" passes x, g and q (0: x is no draw of the row's proposal), "hear" an
  /// exit in the order of SampledExit, "credit" light and events.
  void pass_to(SliceId slice, const std::string& name, const py::array& a, const py::array& b,
               const py::array& numbers) {
    const bool observes = name == "observe", hears = name == "hear";
    const std::size_t columns = observes ? 3 : hears ? 5 : 2;
    const Given in = given(slice, a, b, numbers, columns, true);
    if (observes) check_kind(slice, adaptive::SliceKind::density);
    if (hears) check_kind(slice, adaptive::SliceKind::samples);
    ask(in.a.size(), [&](std::size_t i) {
      const float* x = &in.numbers[columns * i];
      const adaptive::Node node = in.node(slice, i);
      const RowView row = service_->peek(node.slice, node.a, node.b);
      const auto number = [](float of) { return of >= 0 && of < 0x1p32f ? static_cast<std::uint32_t>(of) : 0; };
      if (hears) return service_->hear(row, {x[0], x[1], number(x[2]), x[3], x[4]});
      if (!observes) return service_->credit(row, x[0], number(x[1]));
      x[2] > 0 ? service_->score(row, x[0], x[1], x[2]) : service_->observe(row, x[0], x[1]);
    });
  }

  void prepare() {
    alone([&] { service_->prepare(); });
  }
  void set_learning(bool on) {
    alone([&] { service_->set_learning(on); });
  }
  bool publish_pays(double share) {
    bool pays = false;
    guarded([&](Worker&) {
      const std::shared_lock lock(mutex_);
      pays = service_->publish_pays(share);
    });
    return pays;
  }

  py::bytes state() {
    std::string bytes;
    alone([&] { bytes = checked(service_->state()); });
    return py::bytes(bytes);
  }

  void restore(const std::string& state) {
    alone([&] { check(service_->restore(state)); });
  }

  adaptive::PassReport publish(std::uint64_t paths) {
    adaptive::PassReport report;
    alone([&] {
      changed_.clear();
      report = service_->publish(paths);
    });
    return report;
  }
  py::list changed() {
    std::vector<adaptive::RowReport> rows;
    alone([&] { rows = changed_; });
    py::list list;
    for (const adaptive::RowReport& row : rows)
      list.append(py::dict("lobe"_a = row.slice.lobe, "parameters"_a = row.slice.parameters, "node"_a = row.node,
                           "state"_a = adaptive::state_name(row.state), "objective"_a = row.objective,
                           "count"_a = row.count, "failed_tests"_a = row.failed_tests, "light"_a = row.light));
    return list;
  }

  py::dict heard_test() {
    adaptive::HeardTest test;
    alone([&] { test = service_->test_by_heard(); });
    return py::dict("paths"_a = test.paths, "chi2"_a = test.chi2, "deviation"_a = test.deviation,
                    "common_chi2"_a = test.common_chi2, "common_deviation"_a = test.common_deviation);
  }

  std::vector<std::string> refusals() {
    std::vector<std::string> texts;
    alone([&] {
      for (const Error& error : service_->refusals()) texts.push_back(error.message());
    });
    return texts;
  }

  /// All nodes of a slice in the order a * axis_b.size() + b: state, objective, energy, light, queries, paths.
  py::array_t<double> rows(SliceId slice) {
    check_slice(slice);
    std::vector<std::array<double, 6>> rows;
    alone([&] {
      const auto width = static_cast<std::uint32_t>(service_->slice(slice).axis_b.size());
      for (std::uint32_t node = 0; node < service_->slice(slice).node_count(); ++node) {
        const std::uint32_t a = node / width, b = node % width;
        const RowView row = service_->peek(slice, a, b);
        const float energy = row.ribbons != nullptr ? row.ribbons->total_mass() : row.fit ? row.fit->energy() : 0;
        rows.push_back({static_cast<double>(row.state), row.objective, energy, service_->light(slice, a, b),
                        static_cast<double>(service_->queries(slice, a, b)), static_cast<double>(row.paths)});
      }
    });
    return array_of<double>(std::move(rows), 6);
  }

  /// One row as plain values, without counting a query.
  py::dict row(SliceId slice, std::uint32_t a, std::uint32_t b) {
    check_node(slice, a, b);
    py::dict result;
    alone([&] {},
          [&] {
            const RowView view = service_->peek(slice, a, b);
            result["state"] = adaptive::state_name(view.state);
            result["objective"] = view.objective;
            if (view.fit != nullptr) add_mixture(*view.fit, result);
            if (view.ribbons != nullptr)
              result["masses"] = std::vector<float>(view.ribbons->masses().begin(), view.ribbons->masses().end());
          });
    return result;
  }

  /// For rows of samples that answer: the density of `part` over (azimuth, height), with its mass.
  py::array_t<float> density(SliceId slice, std::uint32_t a, std::uint32_t b, std::uint32_t part, const py::array& x,
                             const py::array& t) {
    check_node(slice, a, b);
    const auto in_x = view<float>(x, 0, "x"), in_t = view<float>(t, 0, "t");
    if (in_x.size() != in_t.size())
      throw Raised({"", "t", fmt::format("{} heights", in_x.size()), fmt::format("{}", in_t.size())});
    std::vector<float> value(in_x.size());
    alone([&] {
      const RowView row = service_->peek(slice, a, b);
      if (row.ribbons == nullptr || part >= row.ribbons->parts())
        throw Raised({"", "row", "a row of samples that answers and has the part", adaptive::state_name(row.state)},
                     Raised::Kind::index);
      const adaptive::Ribbon ribbon = row.ribbons->ribbon(part);
      for (std::size_t i = 0; i < value.size(); ++i)
        value[i] = row.ribbons->mass(part) * ribbon.density(in_x[i], in_t[i]);
    });
    return array_of<float>(std::move(value));
  }

  py::dict save(const std::filesystem::path& file) {
    adaptive::CacheUpdate update;
    alone([&] { update = checked(adaptive::merge_into_cache(file, *service_->rows())); });
    if (update.refusal) throw Raised(*update.refusal);
    py::dict result;
    result["rows"] = update.contents.rows();
    result["converged_rows"] = update.contents.converged_rows;
    result["bytes"] = update.contents.bytes;
    result["hash"] = update.contents.hash;
    return result;
  }

  void load(const std::filesystem::path& file) {
    alone([&] {
      const auto cache = checked(adaptive::CacheFile::open(file, densities_.model_name()));
      check(service_->load(*cache));
    });
  }

  std::string hash() {
    std::string text;
    alone([&] { text = adaptive::cache_hash(*service_->rows()); });
    return text;
  }

  const std::vector<std::string>& log() const { return log_; }

 private:
  /// Azimuth, density, pdf, height, the four parts, state as a number, and whether a row or target answered.
  static py::tuple columns_of(const std::vector<NodeValue>& values) {
    const std::size_t n = values.size();
    std::vector<float> x(n), value(n), q(n), height(n);
    std::vector<std::array<float, 4>> parts(n);
    std::vector<std::uint8_t> state(n), answered(n);
    for (std::size_t i = 0; i < n; ++i) {
      x[i] = values[i].azimuth;
      value[i] = values[i].density;
      q[i] = values[i].pdf;
      height[i] = values[i].height;
      parts[i] = values[i].parts;
      state[i] = static_cast<std::uint8_t>(values[i].state);
      answered[i] = values[i].answered ? 1 : 0;
    }
    return py::make_tuple(array_of<float>(std::move(x)), array_of<float>(std::move(value)),
                          array_of<float>(std::move(q)), array_of<float>(std::move(height)),
                          array_of<float>(std::move(parts), 4), array_of<std::uint8_t>(std::move(state)),
                          array_of<std::uint8_t>(std::move(answered)));
  }

  static std::span<const float> finite(const py::array& array, std::size_t columns, const char* place) {
    const auto numbers = view<float>(array, columns, place);
    for (const float x : numbers)
      if (!std::isfinite(x)) throw Raised({"", place, "finite numbers", fmt::format("{}", x)});
    return numbers;
  }

  /// The columns of a call: places or nodes (a, b), and rows of numbers.
  struct Given {
    std::span<const float> a, b, numbers;
    adaptive::Node node(SliceId slice, std::size_t i) const {
      return {slice, static_cast<std::uint32_t>(a[i]), static_cast<std::uint32_t>(b[i])};
    }
  };
  Given given(SliceId slice, const py::array& a, const py::array& b, const py::array& numbers, std::size_t columns,
              bool at_nodes) const {
    const Given in{finite(a, 0, "a"), finite(b, 0, "b"), finite(numbers, columns, "numbers")};
    check_slice(slice);
    for (std::size_t i = 0; at_nodes && i < in.a.size(); ++i) check_node(slice, in.a[i], in.b[i]);
    return in;
  }

  /// Called inside publish() and prepare(): asks the caller's function on the thread that called.
  bool goes_on(double done) {
    return worker_->ask([&] {
      const Calls::Inside inside;
      return !progress_(done).is(py::bool_(false));
    });
  }

  /// Coarse grids: ascending indices into the axes, with both ends.
  static void check_coarse(const adaptive::SliceDescription& slice) {
    const auto is_grid = [](const std::vector<std::uint32_t>& nodes, std::size_t count) {
      return !nodes.empty() && nodes.front() == 0 && nodes.back() + 1 == count && std::ranges::is_sorted(nodes) &&
             std::ranges::adjacent_find(nodes) == nodes.end();
    };
    for (const adaptive::CoarseAxes& axes : slice.coarse)
      if (!is_grid(axes.a, slice.axis_a.size()) || !is_grid(axes.b, slice.axis_b.size()))
        throw Raised({"", "coarse", "ascending indices from the first node of either axis to its last", "others"});
  }

  static void check_axis(const char* name, const std::vector<float>& axis) {
    bool rises = !axis.empty() && axis.size() <= 65536;
    for (std::size_t i = 0; i < axis.size(); ++i)
      rises = rises && std::isfinite(axis[i]) && (i == 0 || axis[i] > axis[i - 1]);
    if (!rises)
      throw Raised({"", name, "1 to 65536 finite numbers, each above the one before", fmt::format("{}", axis.size())});
  }

  void check_slice(SliceId slice) const {
    if (slice >= service_->slice_count())
      throw Raised({"", "slice", fmt::format("one of {}", service_->slice_count()), fmt::format("{}", slice)},
                   Raised::Kind::index);
  }

  /// a, b: indices as numbers.
  void check_node(SliceId slice, double a, double b) const {
    check_slice(slice);
    const adaptive::SliceDescription& of = service_->slice(slice);
    const auto is_index = [](double x, std::size_t end) {
      return x >= 0 && x < static_cast<double>(end) && x == std::floor(x);
    };
    if (!is_index(a, of.axis_a.size()) || !is_index(b, of.axis_b.size()))
      throw Raised({"", "node", fmt::format("a below {} and b below {}", of.axis_a.size(), of.axis_b.size()),
                    fmt::format("({}, {})", a, b)},
                   Raised::Kind::index);
  }

  void check_kind(SliceId slice, adaptive::SliceKind kind) const {
    constexpr std::array names{"one of densities", "one of samples"};
    const auto expected = static_cast<std::size_t>(kind);
    if (service_->slice(slice).kind != kind) throw Raised({"", "slice", names[expected], names[1 - expected]});
  }

  static void add_mixture(const adaptive::Mixture& fit, py::dict& result) {
    py::list parts;
    for (const adaptive::Component& part : fit.parts()) {
      py::dict one;
      one["mu"] = part.shape.mu;
      one["s_left"] = part.shape.s_left;
      one["s_right"] = part.shape.s_right;
      one["weight"] = part.weight;
      one["attribute_mean"] = part.attribute_mean;
      one["attribute_variance"] = part.attribute_variance;
      parts.append(one);
    }
    result["components"] = parts;
    result["uniform_weight"] = fit.uniform_weight;
    result["energy"] = fit.energy();
  }

  /// Runs a call that may happen during a pass, on all cores; publish() and the like wait until it is done.
  template <class Call>
  void ask(std::size_t n, const Call& call) {
    constexpr std::size_t grain = 256;
    guarded([&](Worker& worker) {
      const std::atomic<bool>& stop = worker.stop();
      const std::shared_lock lock(mutex_);
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), [&](const tbb::blocked_range<std::size_t>& some) {
        for (std::size_t i = some.begin(); i < some.end() && !stop; ++i) call(i);
      });
    });
  }

  /// Runs a call between passes; `after` runs with the GIL, before another call may change the table.
  template <class Call>
  void alone(const Call& call) {
    guarded([&](Worker& worker) {
      const std::unique_lock lock(mutex_);
      worker_ = &worker;
      call();
    });
  }
  template <class Call, class After>
  void alone(const Call&, const After& after) {
    guarded([](Worker&) {});
    const std::unique_lock lock = [&] {
      const py::gil_scoped_release released;
      return std::unique_lock(mutex_);
    }();
    after();
  }

  void guarded(const std::function<void(Worker&)>& work) {
    if (Calls::is_inside())
      throw Raised({"", "service", "calls from outside of its target", "one from trace(), draw() or progress"},
                   Raised::Kind::call);
    if (calls_.failed())
      throw Raised({"", "service", "a target that has answered always", "one that raised, or was interrupted"},
                   Raised::Kind::call);
    Worker worker;
    worker.run([&] {
      calls_.set_stop(&worker.stop());
      work(worker);
      calls_.set_stop(nullptr);
    });
    if (const std::exception_ptr raised = calls_.take_failure()) std::rethrow_exception(raised);
  }

  Calls calls_;
  PythonTarget densities_;
  PythonSamples samples_;
  py::object progress_;       ///< called with the share of a publish() that is done, or None
  Worker* worker_ = nullptr;  ///< of the call that holds mutex_ alone
  std::vector<std::string> log_;
  std::vector<adaptive::RowReport> changed_;  ///< rows that the last publish() changed
  mutable std::shared_mutex mutex_;
  std::unique_ptr<adaptive::Service> service_;
};

adaptive::Options options_of(const py::dict& given) {
  adaptive::Options options;
  const auto read = [&](const char* key, auto& to) {
    if (given.contains(key)) to = py::cast<std::remove_reference_t<decltype(to)>>(given[key]);
  };
  read("epsilon", options.epsilon);
  in_range("epsilon", options.epsilon, "--epsilon");
  if (given.contains("epsilon")) options.hold_all_to(options.epsilon);
  read("queries_before_creation", options.queries_before_creation);
  read("sampled_epsilon", options.sampled_epsilon);
  in_range("sampled_epsilon", options.sampled_epsilon, "--epsilon");
  read("learns_to_epsilon", options.learns_to_epsilon);
  read("picture_error", options.picture_error);
  if (options.picture_error != 0) in_range("picture_error", options.picture_error, "--picture-error");
  read("heard_share", options.heard_share);
  if (!(options.heard_share >= 0 && options.heard_share <= 1))
    throw Raised({"", "heard_share", "0..1", fmt::format("{}", options.heard_share)});
  read("own_paths", options.own_paths);
  read("tests_before_refusal", options.tests_before_refusal);
  read("check_passes", options.check_passes);
  read("seed", options.seed);
  read("max_components", options.max_components);
  in_range("max_components", options.max_components, "--components");
  if (given.contains("memory_mb"))
    options.memory_bytes =
        static_cast<std::size_t>(in_range("memory_mb", py::cast<std::uint64_t>(given["memory_mb"]), "--table-memory"))
        << 20;
  if (given.contains("learner")) options.learner = learner_named(py::str(given["learner"]));
  return options;
}

void bind_reports(py::module_& module) {
  py::class_<adaptive::SliceDescription>(module, "Slice", "What a target is asked about: a grid of nodes.")
      .def_property_readonly("lobe", [](const adaptive::SliceDescription& self) { return self.key.lobe; })
      .def_property_readonly("parameters",
                             [](const adaptive::SliceDescription& self) {
                               const auto all = self.key.used_parameters(adaptive::SliceKey::usual_parameters);
                               return py::tuple(py::cast(std::vector<float>(all.begin(), all.end())));
                             })
      .def_readonly("axis_a", &adaptive::SliceDescription::axis_a)
      .def_readonly("axis_b", &adaptive::SliceDescription::axis_b)
      .def_readonly("blur_rad", &adaptive::SliceDescription::blur_rad);
  using Report = adaptive::PassReport;
  py::class_<Report>(module, "PassReport", "What one publish() did.")
      .def_readonly("queries", &Report::queries)
      .def_readonly("converged_queries", &Report::converged_queries)
      .def_readonly("answered_queries", &Report::answered_queries)
      .def_readonly("g_evaluations", &Report::g_evaluations)
      .def_readonly("traces", &Report::traces)
      .def_readonly("creations", &Report::creations)
      .def_readonly("newly_converged", &Report::newly_converged)
      .def_readonly("rows_open", &Report::rows_open)
      .def_readonly("rows_converged", &Report::rows_converged)
      .def_readonly("rows_refused", &Report::rows_refused)
      .def_readonly("bytes", &Report::bytes)
      .def_readonly("at_ceiling", &Report::at_ceiling)
      .def_readonly("objective_p50", &Report::objective_p50)
      .def_readonly("objective_max", &Report::objective_max)
      .def_readonly("bias_bound", &Report::bias_bound)
      .def_readonly("learning_cpu_seconds", &Report::learning_cpu_seconds)
      .def_readonly("cancelled", &Report::cancelled)
      .def_property_readonly("json", [](const Report& self) { return adaptive::to_json(self); })
      .def_property_readonly("misuse",
                             [](const Report& self) {
                               return self.misuse ? py::object(py::str(self.misuse->message()))
                                                  : py::object(py::none());
                             })
      .def("__repr__", [](const Report& self) { return adaptive::to_string(self); });
}

}  // namespace

void bind_service(py::module_& module) {
  bind_reports(module);
  py::class_<Learner>(module, "Service")
      .def(py::init([](const py::object& target, bool traces, std::uint32_t parts, const py::dict& options,
                       const py::object& progress) {
             if (parts > adaptive::SampledTarget::most_parts)
               throw Raised({"", "parts", fmt::format("at most {}", adaptive::SampledTarget::most_parts),
                             fmt::format("{}", parts)});
             return std::make_unique<Learner>(target, traces, parts, options_of(options), progress);
           }),
           py::arg("target"), py::arg("traces"), py::arg("parts"), py::arg("options"), py::arg("progress"))
      .def("add_slice", &Learner::add_slice, py::arg("lobe"), py::arg("parameters"), py::arg("axis_a"),
           py::arg("axis_b"), py::arg("blur_rad"), py::arg("samples"), py::arg("coarse"), py::arg("coarse_rows_of"),
           py::arg("max_components"))
      .def("query", &Learner::query, py::arg("slice"), py::arg("name"), py::arg("a"), py::arg("b"), py::arg("numbers"))
      .def("pass_to", &Learner::pass_to, py::arg("slice"), py::arg("name"), py::arg("a"), py::arg("b"),
           py::arg("numbers"))
      .def("choose", &Learner::choose, py::arg("slice"), py::arg("a"), py::arg("b"), py::arg("xi"))
      .def("prepare", &Learner::prepare)
      .def("set_learning", &Learner::set_learning, py::arg("on"))
      .def("publish", &Learner::publish, py::arg("paths"))
      .def("publish_pays", &Learner::publish_pays, py::arg("share"))
      .def("row", &Learner::row, py::arg("slice"), py::arg("a"), py::arg("b"))
      .def("rows", &Learner::rows, py::arg("slice"))
      .def("density", &Learner::density, py::arg("slice"), py::arg("a"), py::arg("b"), py::arg("part"), py::arg("x"),
           py::arg("t"))
      .def("state", &Learner::state)
      .def("restore", &Learner::restore, py::arg("state"))
      .def("save", &Learner::save, py::arg("file"))
      .def("load", &Learner::load, py::arg("file"))
      .def_property_readonly("changed", &Learner::changed)
      .def_property_readonly("heard_test", &Learner::heard_test)
      .def_property_readonly("refusals", &Learner::refusals)
      .def_property_readonly("hash", &Learner::hash)
      .def_property_readonly("log", &Learner::log);
}

}  // namespace tress::python
