#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "models/catalog.h"
#include "models/model_options.h"
#include "models/registry.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/names.h"
#include "python/raised.h"
#include "scene/read/scene_file.h"
#include "tress/adaptive/cache.h"
#include "tress/base/random.h"
#include "tress/fiber/parameter_ranges.h"

namespace py = pybind11;

namespace tress::python {
namespace {

using fiber::lobe_count;

/// The fiber of a material of a scene file.
fiber::FiberParameters fiber_of(const std::string& material) {
  const std::string text = R"({"materials":[)" + material + R"(],"grooms":[{"generate":"single_fiber"}]})";
  const auto scene =
      checked(scene::parse_scene_file({reinterpret_cast<const unsigned char*>(text.data()), text.size()}, "material"));
  return scene.materials.front().fiber;
}

/// A model with one fiber. Calls run one at a time, each on all cores.
class Bcsdf {
 public:
  Bcsdf(const std::string& material, const std::string& model, const std::string& estimator,
        std::optional<double> epsilon, std::uint64_t seed)
      : info_(model_named(model)), seed_(seed) {
    const fiber::Estimator used = estimator_named(estimator);
    const fiber::FiberParameters parameters = fiber_of(material);
    if (used == fiber::Estimator::corrected) {
      const fiber::AskedOption asked{"estimator corrected", fiber::Asks::corrected};
      if (const auto refused = fiber::refused(std::span(&asked, 1), info_))
        throw Raised({"", refused->name, refused->expected, model});
    }
    adaptive::Options options;
    options.seed = seed;
    options.learns_to_epsilon = true;  // its rows get too few queries to learn by their events
    if (epsilon) options.hold_all_to(in_range("epsilon", *epsilon, "--epsilon"));
    if (info_.has_rows() && used != fiber::Estimator::exact) learned_ = fiber::make_service(info_, options);
    model_ = info_.make({used, learned_.service.get(), 0});
    const py::gil_scoped_release released;  // energies are traced here, which takes time
    fiber_ = model_->add_fiber(parameters);
    if (fiber_ == fiber::no_fiber) throw Raised(*fiber::range_error(parameters));
  }

  py::tuple evaluate(const py::array& theta_r, const py::array& phi_r, const py::array& theta_i, const py::array& phi_i,
                     std::uint64_t stream) {
    if (!model_->evaluates()) throw Raised({"", "model", "one that can be evaluated", "\"" + model_->name() + "\""});
    const Directions known = directions(theta_r, phi_r, "r"), other = directions(theta_i, phi_i, "i");
    const std::size_t n = known.theta.size();
    std::vector<fiber::LobeColors> s(n);
    std::vector<float> pdf(n);
    each(n, [&](std::size_t i) {
      RandomStream random(seed_, stream, i);
      const fiber::FiberEvent event = begin(known, i, random);
      const fiber::FiberValue value = model_->evaluate(event, {other.theta[i], other.phi[i]});
      s[i] = value.s;
      pdf[i] = value.pdf;
    });
    const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(n), lobe_count, 3};
    auto flat = array_of<float>(std::move(s), lobe_count * 3);
    return py::make_tuple(flat.reshape(shape), array_of<float>(std::move(pdf)));
  }

  py::tuple sample(const py::array& theta_r, const py::array& phi_r, std::uint64_t stream) {
    const Directions known = directions(theta_r, phi_r, "r");
    const std::size_t n = known.theta.size();
    std::vector<float> theta(n), phi(n), pdf(n);
    std::vector<glm::vec3> weight(n);
    std::vector<std::uint8_t> lobe(n);
    each(n, [&](std::size_t i) {
      RandomStream random(seed_, stream, i);
      const fiber::FiberEvent event = begin(known, i, random);
      const fiber::FiberSample drawn =
          model_->sample(event, {random.next(), random.next(), random.next(), random.next()});
      theta[i] = drawn.wi.theta;
      phi[i] = drawn.wi.phi;
      pdf[i] = model_->evaluates() ? drawn.value.pdf : 0.0f;
      weight[i] = drawn.value.pdf > 0 ? drawn.value.total() / drawn.value.pdf : glm::vec3(0.0f);
      lobe[i] = static_cast<std::uint8_t>(drawn.lobe);
    });
    return py::make_tuple(array_of<float>(std::move(theta)), array_of<float>(std::move(phi)),
                          array_of<float>(std::move(weight), 3), array_of<float>(std::move(pdf)),
                          array_of<std::uint8_t>(std::move(lobe)));
  }

  /// Merges what was learned with what the file has by now.
  void save(const std::filesystem::path& file) {
    adaptive::Service& service = rows();
    Worker worker;
    std::optional<Result<adaptive::CacheUpdate>> update;
    worker.run([&] { update = adaptive::merge_into_cache(file, *service.rows()); });
    if (const adaptive::CacheUpdate& done = checked(std::move(*update)); done.refusal) throw Raised(*done.refusal);
  }

  /// Must be called before the first sample().
  void load(const std::filesystem::path& file) {
    adaptive::Service& service = rows();
    const auto cache = checked(adaptive::CacheFile::open(file, service.model_name()));
    check(service.load(*cache));
  }

  /// Ends a pass: the events of sample() are learned. Null without rows.
  py::object publish() {
    if (!learned_.service) return py::none();
    adaptive::PassReport report;
    Worker worker;
    worker.run([&] { report = learned_.service->publish(); });
    return py::cast(report);
  }

 private:
  struct Directions {
    std::span<const float> theta, phi;
  };

  adaptive::Service& rows() const {
    if (!learned_.service) throw Raised({"", "estimator", "one that learns (fitted, corrected)", "exact"});
    return *learned_.service;
  }

  Directions directions(const py::array& theta, const py::array& phi, const char* which) const {
    const Directions both{view<float>(theta, 0, std::string("theta_") + which),
                          view<float>(phi, 0, std::string("phi_") + which)};
    if (both.theta.size() != both.phi.size())
      throw Raised({"", std::string("phi_") + which, fmt::format("{} angles", both.theta.size()),
                    fmt::format("{}", both.phi.size())});
    return both;
  }

  /// Draws the node of the table and the place on the fiber's width for an event.
  fiber::FiberEvent begin(const Directions& known, std::size_t i, RandomStream& random) const {
    const float xi1 = random.next(), xi2 = random.next(), h = 2 * random.next() - 1;
    return model_->begin(fiber_, {known.theta[i], known.phi[i]}, xi1, xi2, h);
  }

  template <class Call>
  void each(std::size_t n, const Call& call) const {
    constexpr std::size_t grain = 256;
    Worker worker;
    worker.run([&] {
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), [&](const tbb::blocked_range<std::size_t>& some) {
        for (std::size_t i = some.begin(); i < some.end() && !worker.stop(); ++i) call(i);
      });
    });
  }

  const fiber::ModelInfo& info_;
  std::uint64_t seed_;
  fiber::ModelService learned_;
  std::unique_ptr<fiber::FiberModel> model_;
  fiber::FiberId fiber_ = 0;
};

}  // namespace

void bind_bcsdf(py::module_& module) {
  py::list lobes;
  for (const char* name : fiber::lobe_names) lobes.append(name);
  module.attr("LOBES") = py::tuple(lobes);
  py::class_<Bcsdf>(module, "Bcsdf")
      .def(py::init<const std::string&, const std::string&, const std::string&, std::optional<double>, std::uint64_t>(),
           py::arg("material"), py::arg("model"), py::arg("estimator"), py::arg("epsilon"), py::arg("seed"))
      .def("evaluate", &Bcsdf::evaluate, py::arg("theta_r"), py::arg("phi_r"), py::arg("theta_i"), py::arg("phi_i"),
           py::arg("stream"))
      .def("sample", &Bcsdf::sample, py::arg("theta_r"), py::arg("phi_r"), py::arg("stream"))
      .def("save", &Bcsdf::save, py::arg("file"))
      .def("load", &Bcsdf::load, py::arg("file"))
      .def("publish", &Bcsdf::publish);
}

}  // namespace tress::python
