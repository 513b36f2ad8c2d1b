#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "models/catalog.h"
#include "python/arrays_in.h"
#include "python/bindings.h"
#include "python/names.h"
#include "python/picture.h"
#include "python/raised.h"
#include "python/scene_render.h"
#include "scene/model/parameters.h"
#include "scene/read/load_scene.h"
#include "tress/version.h"

namespace py = pybind11;

namespace tress::python {
namespace {

/// The argument of a callback: a pass, and, while the callback runs, the picture so far.
struct Progress {
  integrate::PassProgress pass;
};

/// The keyword arguments of render(); numbers are checked by the command-line option of the same meaning.
class Arguments {
 public:
  explicit Arguments(const py::dict& given) : given_(given) {}

  template <class T>
  std::optional<T> number(const char* name, const char* option) const {
    if (!has(name)) return std::nullopt;
    return in_range(name, py::cast<T>(given_[name]), option);
  }
  template <class T>
  std::optional<T> value(const char* name) const {
    if (!has(name)) return std::nullopt;
    return py::cast<T>(given_[name]);
  }

  bool is_text(const char* name) const { return has(name) && py::isinstance<py::str>(given_[name]); }
  bool has(const char* name) const { return given_.contains(name) && !given_[name].is_none(); }

 private:
  const py::dict& given_;
};

RenderRequest request_of(const Arguments& given, std::optional<int> frame) {
  RenderRequest request;
  integrate::RenderOptions& render = request.render;
  if (const auto name = given.value<std::string>("estimator")) request.estimator = estimator_named(*name);
  if (const auto name = given.value<std::string>("learner")) request.table.learner = learner_named(*name);
  if (const auto x = given.number<double>("epsilon", "--epsilon")) request.table.hold_all_to(*x);
  if (const auto x = given.number<double>("picture_error", "--picture-error")) request.table.picture_error = *x;
  if (const auto mb = given.number<std::uint64_t>("table_memory", "--table-memory"))
    request.table.memory_bytes = static_cast<std::size_t>(*mb) << 20;
  render.seed = given.number<std::uint64_t>("seed", "--seed").value_or(static_cast<std::uint64_t>(frame.value_or(0)));
  request.noise = given.number<double>("noise", "--noise");
  request.seconds = given.number<double>("seconds", "--time");
  render.mattes = given.value<bool>("mattes").value_or(true);
  for (const std::string& name : given.value<std::vector<std::string>>("layers").value_or(std::vector<std::string>())) {
    if (!render.data.ask(name))
      throw Raised(
          {"", "layers", fmt::format("some of {}", fmt::join(integrate::data_layer_names, ", ")), "\"" + name + "\""});
  }
  if (const auto edges = given.value<std::array<int, 4>>("crop")) {
    const auto [x0, y0, x1, y1] = *edges;
    render.crop = image::Window{x0, y0, x1 - x0, y1 - y0};
  }
  request.denoise = given.value<bool>("denoise").value_or(false);
  request.threads = given.number<int>("threads", "--threads");
  request.warm_cache = given.value<std::filesystem::path>("warm_cache").value_or(std::filesystem::path());
  request.cache_mode = given.value<std::string>("cache_mode").value_or(request.cache_mode);
  if (const auto mb = given.number<double>("cache_limit", "--cache-limit"))
    request.cache_limit = static_cast<std::uint64_t>(*mb * double(1 << 20));
  if (given.has("learner")) request.asked.push_back({"learner", fiber::Asks::mixtures});
  if (given.has("near")) request.asked.push_back({"near", fiber::Asks::samples});
  for (const char* name : {"epsilon", "picture_error", "table_memory"})
    if (given.has(name)) request.asked.push_back({name, fiber::Asks::rows});
  if (request.estimator == fiber::Estimator::corrected)
    request.asked.push_back({"estimator corrected", fiber::Asks::corrected});
  request.model = given.value<std::string>("model");
  return request;
}

/// The keywords that are keys of the scene, as texts for scene::set_keys().
std::vector<std::string> settings_of(const Arguments& given) {
  std::vector<std::string> settings;
  for (const scene::Parameter& parameter : scene::parameters()) {
    const bool is_keyword = parameter.key.starts_with("/integrator/") || parameter.key == "/image/least_width" ||
                            parameter.key == "/image/curve_error";
    const std::string name(parameter.key.substr(parameter.key.rfind('/') + 1)), option(parameter.option);
    if (!is_keyword || !given.has(name.c_str())) continue;
    std::string value;
    if (parameter.kind == scene::ValueKind::choice || given.is_text(name.c_str())) {
      value = *given.value<std::string>(name.c_str());
      const std::vector<std::string> choices = scene::choices_of(parameter);
      if (std::ranges::find(choices, value) == choices.end())
        throw Raised({"", name, fmt::format("one of {}", fmt::join(choices, ", ")), "\"" + value + "\""});
    } else if (parameter.kind == scene::ValueKind::flag) {
      value = *given.value<bool>(name.c_str()) ? "true" : "false";
    } else if (parameter.kind == scene::ValueKind::whole) {
      value = std::to_string(*given.number<int>(name.c_str(), option.c_str()));
    } else {
      value = fmt::format("{}", *given.number<double>(name.c_str(), option.c_str()));
    }
    settings.push_back(fmt::format("{}={}", parameter.key, value));
  }
  return settings;
}

scene::Overrides overrides_of(const Arguments& given) {
  scene::Overrides overrides;
  overrides.samples = given.number<int>("samples", "--spp");
  overrides.width = given.number<int>("width", "--resolution");
  overrides.height = given.number<int>("height", "--resolution");
  overrides.settings = settings_of(given);
  overrides.frame = given.number<int>("frame", "--frame");
  return overrides;
}

void describe(const scene::Scene& scene, const RenderRequest& request, const RenderOutcome& outcome,
              image::Picture* picture) {
  auto& entries = picture->metadata;
  entries["scene"] = scene.source;
  entries["version"] = version();
  entries["noise"] = fmt::format("{:.4g}", outcome.noise);
  entries["seed"] = std::to_string(request.render.seed);
  entries["samples"] = fmt::format("{}", outcome.result.samples_per_pixel);
  entries["dropped_samples"] = std::to_string(outcome.result.dropped_samples);
  entries["stopped_by"] = outcome.stopped_by;
  entries["time"] = fmt::format("{:.3f} s", outcome.seconds);
  entries["model"] = outcome.model;
  entries["estimator"] = outcome.estimator;
  entries["epsilon"] = fmt::format("{}", outcome.epsilon);
  entries["cache_hash"] = outcome.cache_hash;
  entries["alpha"] = scene.environment_visible && !scene.image.transparent
                         ? "opaque: R, G, B have the background, A is 1"
                         : "premultiplied: R, G, B have no background, A is the coverage";
}

py::dict stats_of(const scene::Scene& scene, const RenderOutcome& outcome) {
  const integrate::RenderResult& result = outcome.result;
  py::dict stats;
  stats["stopped_by"] = outcome.stopped_by;
  stats["seconds"] = outcome.seconds;
  stats["passes"] = result.passes;
  stats["samples_per_pixel"] = result.samples_per_pixel;
  stats["dropped_samples"] = result.dropped_samples;
  stats["noise"] = outcome.noise;
  stats["bias_bound"] = outcome.bias_bound;
  stats["queries"] = result.queries;
  stats["exact_queries"] = result.exact_queries;
  stats["cache_hash"] = outcome.cache_hash;
  stats["cache"] = outcome.cache;
  if (outcome.denoised_noise) stats["denoised_noise"] = *outcome.denoised_noise;
  if (result.excess) stats["bias_estimate"] = py::make_tuple(result.excess->value, result.excess->error);
  if (result.deep_light) stats["deep_light_bias"] = py::make_tuple(result.deep_light->value, result.deep_light->error);
  stats["notes"] = py::cast(scene.notes);
  std::vector<std::string> warnings = scene.warnings;
  warnings.insert(warnings.end(), outcome.warnings.begin(), outcome.warnings.end());
  stats["warnings"] = py::cast(warnings);
  return stats;
}

/// scene: the path of a file, or the text of one with the folder that its file names are relative to.
std::shared_ptr<SharedPicture> render(const std::optional<std::filesystem::path>& file, const std::string& text,
                                      const std::filesystem::path& folder, const py::dict& arrays,
                                      const py::dict& keywords, const py::object& on_pass) {
  const Arguments given(keywords);
  const scene::Overrides overrides = overrides_of(given);
  const RenderRequest request = request_of(given, overrides.frame);
  scene::FilesInMemory files = files_of(arrays);
  std::optional<scene::Scene> scene;
  std::optional<RenderOutcome> outcome;
  Worker worker;
  const auto report_pass = [&](const integrate::PassProgress& pass) {
    if (on_pass.is_none()) return !worker.stop();
    return worker.ask([&] {
      const py::object answer = on_pass(std::make_shared<Progress>(Progress{pass}));
      return !(PyBool_Check(answer.ptr()) && answer.ptr() == Py_False);
    });
  };
  worker.run([&] {
    scene = checked(file ? scene::load_scene(*file, overrides)
                         : scene::load_scene({reinterpret_cast<const unsigned char*>(text.data()), text.size()},
                                             "scene", folder, std::move(files), overrides));
    outcome = checked(render_scene(*scene, request, worker.stop(), report_pass));
  });
  describe(*scene, request, *outcome, &outcome->result.picture);
  const image::Preview preview{scene->image.transparent, scene->image.exposure_stops, scene->image.view};
  return std::make_shared<SharedPicture>(
      SharedPicture{std::move(outcome->result.picture), preview, stats_of(*scene, *outcome)});
}

py::list models() {
  py::list names;
  for (const fiber::ModelInfo& info : fiber::models()) names.append(info.name);
  return names;
}

}  // namespace

void bind_render(py::module_& module) {
  py::class_<Progress, std::shared_ptr<Progress>>(module, "Progress", "What a pass of a render has done.")
      .def_property_readonly(
          "number", [](const Progress& self) { return self.pass.pass; }, "Number of the pass, from 0.")
      .def_property_readonly(
          "count", [](const Progress& self) { return self.pass.pass_count; }, "Number of passes, at most.")
      .def_property_readonly(
          "share",
          [](const Progress& self) {
            return static_cast<double>(self.pass.paths_so_far) /
                   static_cast<double>(std::max<std::uint64_t>(1, self.pass.paths_total));
          },
          "Share of the samples that are done, [0, 1].")
      .def_property_readonly("noise", [](const Progress& self) { return self.pass.noise; })
      .def_property_readonly(
          "seconds", [](const Progress& self) { return self.pass.seconds; }, "Wall time of this pass, s.")
      .def_property_readonly("cpu_seconds", [](const Progress& self) { return self.pass.cpu_seconds; })
      .def_property_readonly("queries", [](const Progress& self) { return self.pass.table.queries; })
      .def_property_readonly("converged_queries",
                             [](const Progress& self) { return self.pass.table.converged_queries; })
      .def_property_readonly("rows_open", [](const Progress& self) { return self.pass.table.rows_open; })
      .def_property_readonly("rows_converged", [](const Progress& self) { return self.pass.table.rows_converged; })
      .def_property_readonly("table_bytes", [](const Progress& self) { return self.pass.table.bytes; });
  module.def("render", &render, py::arg("file"), py::arg("text"), py::arg("folder"), py::arg("arrays"),
             py::arg("keywords"), py::arg("on_pass"));
  module.def("models", &models, "The names that render(model=...) takes.");
}

}  // namespace tress::python
