#include "tress/adaptive/service.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <span>
#include <string>
#include <vector>

#include "python/arrays.h"
#include "python/bindings.h"
#include "python/names.h"
#include "python/raised.h"
#include "python/targets.h"
#include "tress/adaptive/to_string.h"

namespace py = pybind11;

namespace tress::python {
namespace {

using adaptive::RowView;
using adaptive::SliceId;

/// The service behind a lock: many threads at a time may query it, and only one may do anything else, as its header
/// demands.
class Learner {
 public:
  Learner(const py::object& target, std::uint32_t parts, const adaptive::Options& options)
      : calls_(target),
        densities_(calls_, py::str(target.attr("name"))),
        samples_(calls_, py::str(target.attr("name")), std::max(1u, parts)),
        learns_samples_(parts > 0) {
    adaptive::Options told = options;
    told.log = [this](const std::string& sentence) { log_.push_back(sentence); };
    service_ = learns_samples_ ? std::make_unique<adaptive::Service>(told, samples_)
                               : std::make_unique<adaptive::Service>(told, densities_);
  }

  SliceId add_slice(std::uint32_t lobe, const std::vector<float>& parameters, const std::vector<float>& axis_a,
                    const std::vector<float>& axis_b, float blur_rad) {
    adaptive::SliceDescription slice;
    const std::size_t most = learns_samples_ ? slice.key.parameters.size() : adaptive::SliceKey::density_parameters;
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
    slice.kind = learns_samples_ ? adaptive::SliceKind::samples : adaptive::SliceKind::density;
    SliceId id = 0;
    alone([&] { id = checked(service_->add_slice(slice)); });
    return id;
  }

  /// For each element: looks up the row, draws from its proposal, and passes it the value. Returns x, the value there,
  /// and the density of the draw.
  py::tuple draw(SliceId slice, const py::array& a, const py::array& b, const py::array& u) {
    const auto in_a = view<std::uint32_t>(a, 0, "a"), in_b = view<std::uint32_t>(b, 0, "b");
    const auto in_u = view<float>(u, 0, "u");
    check_nodes(slice, adaptive::SliceKind::density, in_a, in_b);
    std::vector<float> x(in_u.size()), value(in_u.size()), q(in_u.size());
    ask(in_u.size(), [&](std::size_t i) {
      const RowView row = service_->look_up(slice, in_a[i], in_b[i]);
      const bool converged = row.state == adaptive::RowState::converged;
      const float share =
          converged ? service_->options().uniform_share_converged : service_->options().uniform_share_open;
      x[i] = row.sample(in_u[i], share);
      q[i] = row.proposal_density(x[i], share);
      value[i] = value_of(row, x[i]);
      if (!converged) service_->score(row, x[i], value[i], q[i]);
    });
    return py::make_tuple(array_of<float>(std::move(x)), array_of<float>(std::move(value)),
                          array_of<float>(std::move(q)));
  }

  /// The same at azimuths of the caller, from which open rows learn.
  py::array_t<float> evaluate(SliceId slice, const py::array& a, const py::array& b, const py::array& x) {
    const auto in_a = view<std::uint32_t>(a, 0, "a"), in_b = view<std::uint32_t>(b, 0, "b");
    const auto in_x = view<float>(x, 0, "x");
    check_nodes(slice, adaptive::SliceKind::density, in_a, in_b);
    std::vector<float> value(in_x.size());
    ask(in_x.size(), [&](std::size_t i) {
      const RowView row = service_->look_up(slice, in_a[i], in_b[i]);
      value[i] = value_of(row, in_x[i]);
      if (row.state != adaptive::RowState::converged) service_->observe(row, in_x[i], value[i]);
    });
    return array_of<float>(std::move(value));
  }

  /// Queries rows of samples and returns which have converged, as 0 or 1.
  py::array_t<std::uint8_t> look_up(SliceId slice, const py::array& a, const py::array& b) {
    const auto in_a = view<std::uint32_t>(a, 0, "a"), in_b = view<std::uint32_t>(b, 0, "b");
    check_nodes(slice, adaptive::SliceKind::samples, in_a, in_b);
    std::vector<std::uint8_t> converged(in_a.size());
    ask(in_a.size(), [&](std::size_t i) {
      converged[i] = service_->look_up(slice, in_a[i], in_b[i]).state == adaptive::RowState::converged;
    });
    return array_of<std::uint8_t>(std::move(converged));
  }

  /// Queries rows of samples and draws from those that answer. Returns azimuth, height, part, and the mass of the row,
  /// which is the weight of the draw; the mass is 0 if no row answers.
  py::tuple sample(SliceId slice, const py::array& a, const py::array& b, const py::array& u_part,
                   const py::array& u_azimuth, const py::array& u_height) {
    const auto in_a = view<std::uint32_t>(a, 0, "a"), in_b = view<std::uint32_t>(b, 0, "b");
    const auto of_part = view<float>(u_part, 0, "u"), of_azimuth = view<float>(u_azimuth, 0, "u"),
               of_height = view<float>(u_height, 0, "u");
    check_nodes(slice, adaptive::SliceKind::samples, in_a, in_b);
    std::vector<float> azimuth(in_a.size()), height(in_a.size()), mass(in_a.size());
    std::vector<std::uint32_t> parts(in_a.size());
    ask(in_a.size(), [&](std::size_t i) {
      const RowView row = service_->look_up(slice, in_a[i], in_b[i]);
      if (row.ribbons == nullptr) return;
      for (const float one : row.ribbons->masses()) mass[i] += one;
      float below = of_part[i] * mass[i];
      std::uint32_t part = 0;
      while (part + 1 < row.ribbons->parts() && below >= row.ribbons->mass(part)) below -= row.ribbons->mass(part++);
      const adaptive::Ribbon::Place place = row.ribbons->ribbon(part).sample(of_azimuth[i], of_height[i]);
      azimuth[i] = place.azimuth;
      height[i] = place.height;
      parts[i] = part;
    });
    return py::make_tuple(array_of<float>(std::move(azimuth)), array_of<float>(std::move(height)),
                          array_of<std::uint32_t>(std::move(parts)), array_of<float>(std::move(mass)));
  }

  /// Reports to rows how much of the picture's light a query of each stood for; the queries are not counted again.
  void credit(SliceId slice, const py::array& a, const py::array& b, const py::array& light) {
    const auto in_a = view<std::uint32_t>(a, 0, "a"), in_b = view<std::uint32_t>(b, 0, "b");
    const auto in_light = view<float>(light, 0, "light");
    check_nodes(slice, std::nullopt, in_a, in_b);
    ask(in_a.size(), [&](std::size_t i) { service_->credit(service_->peek(slice, in_a[i], in_b[i]), in_light[i]); });
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
    alone([&] { report = service_->publish(paths); });
    return report;
  }

  /// One row as plain values, without counting a query.
  py::dict row(SliceId slice, std::uint32_t a, std::uint32_t b) {
    check_node(slice, a, b);
    py::dict told;
    alone([&] {},
          [&] {
            const RowView view = service_->peek(slice, a, b);
            told["state"] = adaptive::state_name(view.state);
            told["objective"] = view.objective;
            if (view.fit != nullptr) tell_mixture(*view.fit, told);
            if (view.ribbons != nullptr)
              told["masses"] = std::vector<float>(view.ribbons->masses().begin(), view.ribbons->masses().end());
          });
    return told;
  }

  /// For converged rows of samples: the density of `part` over (azimuth, height), with its mass.
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
        throw Raised({"", "row", "a converged row of samples that has the part", adaptive::state_name(row.state)});
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
    py::dict told;
    told["rows"] = update.contents.rows();
    told["converged_rows"] = update.contents.converged_rows;
    told["bytes"] = update.contents.bytes;
    told["hash"] = update.contents.hash;
    return told;
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
  static float value_of(const RowView& row, float x) {
    return row.state == adaptive::RowState::converged || row.nodes == nullptr ? row.density(x) : row.nodes->density(x);
  }

  static void check_axis(const char* name, const std::vector<float>& axis) {
    bool rises = !axis.empty() && axis.size() <= 65536;
    for (std::size_t i = 0; i < axis.size(); ++i)
      rises = rises && std::isfinite(axis[i]) && (i == 0 || axis[i] > axis[i - 1]);
    if (!rises)
      throw Raised({"", name, "1 to 65536 finite numbers, each above the one before", fmt::format("{}", axis.size())});
  }

  void check_node(SliceId slice, std::uint32_t a, std::uint32_t b) const {
    if (slice >= service_->slice_count())
      throw Raised({"", "slice", fmt::format("one of {}", service_->slice_count()), fmt::format("{}", slice)});
    const adaptive::SliceDescription& told = service_->slice(slice);
    if (a >= told.axis_a.size() || b >= told.axis_b.size())
      throw Raised({"", "node", fmt::format("a below {} and b below {}", told.axis_a.size(), told.axis_b.size()),
                    fmt::format("({}, {})", a, b)});
  }

  /// kind: the kind that the slice must have; unset: any.
  void check_nodes(SliceId slice, std::optional<adaptive::SliceKind> kind, std::span<const std::uint32_t> a,
                   std::span<const std::uint32_t> b) const {
    if (Calls::is_inside()) return;  // ask() reports this error
    const py::gil_scoped_release released;
    const std::shared_lock lock(mutex_);
    check_node(slice, 0, 0);
    if (kind && service_->slice(slice).kind != *kind) {
      const bool samples = *kind == adaptive::SliceKind::samples;
      throw Raised({"", "slice", samples ? "one of samples" : "one of densities",
                    samples ? "one of densities: draw() and evaluate() ask it" : "one of samples: sample() asks it"});
    }
    for (std::size_t i = 0; i < a.size(); ++i) check_node(slice, a[i], b[i]);
  }

  static void tell_mixture(const adaptive::Mixture& fit, py::dict& told) {
    py::list parts;
    for (const adaptive::Component& part : fit.parts()) {
      py::dict one;
      one["mu"] = part.shape.mu;
      one["s_left"] = part.shape.s_left;
      one["s_right"] = part.shape.s_right;
      one["weight"] = part.weight;
      one["attribute_mean"] = part.attribute_mean;
      parts.append(one);
    }
    told["components"] = parts;
    told["uniform_weight"] = fit.uniform_weight;
    told["energy"] = fit.energy();
  }

  /// Runs a call that may happen during a pass, on all cores; publish() and the like wait until it is done.
  template <class Call>
  void ask(std::size_t n, const Call& call) {
    constexpr std::size_t grain = 256;
    guarded([&](const std::atomic<bool>& stop) {
      const std::shared_lock lock(mutex_);
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), [&](const tbb::blocked_range<std::size_t>& some) {
        for (std::size_t i = some.begin(); i < some.end() && !stop; ++i) call(i);
      });
    });
  }

  /// Runs a call between passes; `told` runs with the GIL, before another call may change the table.
  template <class Call>
  void alone(const Call& call) {
    guarded([&](const std::atomic<bool>&) {
      const std::unique_lock lock(mutex_);
      call();
    });
  }
  template <class Call, class Told>
  void alone(const Call&, const Told& told) {
    guarded([](const std::atomic<bool>&) {});
    const std::unique_lock lock = [&] {
      const py::gil_scoped_release released;
      return std::unique_lock(mutex_);
    }();
    told();
  }

  void guarded(const std::function<void(const std::atomic<bool>&)>& work) {
    if (Calls::is_inside())
      throw Raised({"", "service", "calls from outside of its target", "one from trace() or draw()"});
    if (calls_.failed())
      throw Raised({"", "service", "a target that has answered always", "one that raised, or was interrupted"});
    Worker worker;
    worker.run([&] {
      calls_.set_stop(&worker.stop());
      work(worker.stop());
      calls_.set_stop(nullptr);
    });
    if (const std::exception_ptr raised = calls_.take_failure()) std::rethrow_exception(raised);
  }

  Calls calls_;
  PythonTarget densities_;
  PythonSamples samples_;
  bool learns_samples_;
  std::vector<std::string> log_;
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
      .def_property_readonly(
          "parameters",
          [](const adaptive::SliceDescription& self) {
            return py::tuple(py::cast(std::vector<float>(self.key.parameters.begin(), self.key.parameters.end())));
          })
      .def_readonly("axis_a", &adaptive::SliceDescription::axis_a)
      .def_readonly("axis_b", &adaptive::SliceDescription::axis_b)
      .def_readonly("blur_rad", &adaptive::SliceDescription::blur_rad);
  using Report = adaptive::PassReport;
  py::class_<Report>(module, "PassReport", "What one publish() did.")
      .def_readonly("queries", &Report::queries)
      .def_readonly("converged_queries", &Report::converged_queries)
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
      .def(py::init([](const py::object& target, std::uint32_t parts, const py::dict& options) {
             if (parts > adaptive::SampledTarget::most_parts)
               throw Raised({"", "parts", fmt::format("at most {}", adaptive::SampledTarget::most_parts),
                             fmt::format("{}", parts)});
             return std::make_unique<Learner>(target, parts, options_of(options));
           }),
           py::arg("target"), py::arg("parts"), py::arg("options"))
      .def("add_slice", &Learner::add_slice, py::arg("lobe"), py::arg("parameters"), py::arg("axis_a"),
           py::arg("axis_b"), py::arg("blur_rad"))
      .def("draw", &Learner::draw, py::arg("slice"), py::arg("a"), py::arg("b"), py::arg("u"))
      .def("evaluate", &Learner::evaluate, py::arg("slice"), py::arg("a"), py::arg("b"), py::arg("x"))
      .def("look_up", &Learner::look_up, py::arg("slice"), py::arg("a"), py::arg("b"))
      .def("sample", &Learner::sample, py::arg("slice"), py::arg("a"), py::arg("b"), py::arg("u_part"),
           py::arg("u_azimuth"), py::arg("u_height"))
      .def("credit", &Learner::credit, py::arg("slice"), py::arg("a"), py::arg("b"), py::arg("light"))
      .def("state", &Learner::state)
      .def("restore", &Learner::restore, py::arg("state"))
      .def("publish", &Learner::publish, py::arg("paths"))
      .def("row", &Learner::row, py::arg("slice"), py::arg("a"), py::arg("b"))
      .def("density", &Learner::density, py::arg("slice"), py::arg("a"), py::arg("b"), py::arg("part"), py::arg("x"),
           py::arg("t"))
      .def("save", &Learner::save, py::arg("file"))
      .def("load", &Learner::load, py::arg("file"))
      .def_property_readonly("hash", &Learner::hash)
      .def_property_readonly("log", &Learner::log);
}

}  // namespace tress::python
