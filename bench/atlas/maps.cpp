// Study 2 of the atlas: what every model's density, energy, weights and error do over slices of the domain.
//
// A slice varies two parameters over the base: e 0.85, alpha 0.2, eta 1.55, tilt 3 degrees, clear, theta_r 40, phi_r 40
// degrees. Of each cell and rival:
//   mass      integral of the density of the sampler over all directions, at one (xi, h)
//   energy    integral of S likewise, luminance; of models that can only be sampled, the mean weight
//   weight    largest |S|/Q of the points of those integrals and of samples with (xi, h) at random
//   variance  of those samples' weights over their squared mean
//   p         chi-square of samples against the density at that (xi, h)
//   own       relative L2 of the azimuthal shapes of TT, TRT and TRRT on the specular cone, no tilt, each scaled to the
//             energy that the smooth ellipse has (the models' energies are those of rough fibers, or none), against
//             what the model itself stands for: the Fourier reference of the ellipse (elliptical; mean over 3 x 3 xi),
//             that of the circle (deon2011), the functions that its rows are fitted to (pekelis2015)
//   ellipse   the same of every model that is a sum of blurred lobes, against the Fourier reference of the cell's own
//   ellipse error     of an energy that is noisy: of models that can only be sampled, and of corrected unsound answers
//   that are not finite, negative, or S without a density
// Rows are taught at the cell's wr, all nodes that it can meet, until none is open. What the quadrature did not resolve
// is "-", as is what a rival does not have. JSON on stdout, progress on stderr.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fiber/circle_ray.h"
#include "fiber/fourier_reference.h"
#include "fiber/row_axes.h"
#include "models/direction_panels.h"
#include "models/model_measures.h"
#include "references/registry.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberParameters;

constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr float own_xi1 = 0.37f, own_xi2 = 0.61f, own_h = 0.3f;
constexpr double largest_error = 2e-3;  // of a mass or an energy that is printed
constexpr double largest_fit_error = 0.5;
constexpr int narrow_samples = 300;  // where every sample is a trace of hundreds or thousands of rays

struct Settings {
  bool quick = false;
  int samples = 2000;
  long points = 30000;
  double epsilon = 0.01;
  std::uint64_t seed = 1;
  std::string slice, rival;
  std::vector<double> cell;
};

struct Cell {
  FiberParameters fiber;
  double theta_deg = 40, phi_deg = 40;

  FiberDirection wr() const { return {static_cast<float>(theta_deg * degree), static_cast<float>(phi_deg * degree)}; }
};

struct Axis {
  const char* name;
  const char* unit;
  std::vector<double> values;
  void (*set)(Cell&, double);
};

const Axis theta_axis{"theta_r", "degrees", {0, 20, 60, 80, 88, 89.9}, [](Cell& c, double x) { c.theta_deg = x; }};
const Axis e_axis{
    "e", "", {1, 0.95, 0.85, 0.7, 0.5}, [](Cell& c, double x) { c.fiber.eccentricity = static_cast<float>(x); }};
const Axis sigma_axis{"sigma", "degrees", {0.5, 1, 4, 10, 20, 45}, [](Cell& c, double x) {
                        c.fiber.azimuthal_sigma.fill(static_cast<float>(x * degree));
                      }};
const Axis alpha_axis{
    "alpha", "", {0.01, 0.05, 0.2, 0.5, 1}, [](Cell& c, double x) { c.fiber.roughness = static_cast<float>(x); }};
const Axis eta_axis{
    "eta", "", {1.2, 1.4, 1.55, 1.75, 2}, [](Cell& c, double x) { c.fiber.eta = static_cast<float>(x); }};
const Axis sigma_a_axis{"sigma_a", "a major semi-axis", {0, 0.3, 1, 10, 100}, [](Cell& c, double x) {
                          c.fiber.sigma_a = glm::vec3(static_cast<float>(x));
                        }};
const Axis lambda_axis{"lambda", "degrees", {0.25, 1, 3, 10, 45}, [](Cell& c, double x) {
                         c.fiber.longitudinal_lambda.fill(static_cast<float>(x * degree));
                       }};

struct Slice {
  const char* name;
  Axis x, y;
};

std::vector<double> thinned(const std::vector<double>& all) { return {all[all.size() / 2], all.back()}; }

std::vector<Slice> slices(const Settings& settings) {
  std::vector<Slice> all{
      {"e", theta_axis, e_axis},      {"sigma", theta_axis, sigma_axis},     {"alpha", theta_axis, alpha_axis},
      {"eta", theta_axis, eta_axis},  {"sigma_a", theta_axis, sigma_a_axis}, {"lambda", theta_axis, lambda_axis},
      {"sigma_e", sigma_axis, e_axis}};
  if (!settings.slice.empty()) std::erase_if(all, [&](const Slice& slice) { return slice.name != settings.slice; });
  if (settings.quick) {
    for (Slice& slice : all) {
      slice.x.values = thinned(slice.x.values);
      slice.y.values = thinned(slice.y.values);
    }
  }
  return all;
}

/// Row by row of y.
std::vector<Cell> cells_of(const Slice& slice) {
  std::vector<Cell> cells;
  for (const double y : slice.y.values) {
    for (const double x : slice.x.values) {
      Cell cell;
      cell.fiber.sigma_a = glm::vec3(0);
      slice.y.set(cell, y);
      slice.x.set(cell, x);
      cells.push_back(cell);
    }
  }
  return cells;
}

enum class Own { none, ellipse, circle, functions };
enum class Rows { none, elliptical, rough, pekelis };

struct Rival {
  const char* name;
  const char* model;
  fiber::Estimator estimator = fiber::Estimator::exact;
  int points = 0;
  Rows rows = Rows::none;
  Own own = Own::none;
};

constexpr Rival rivals[] = {
    {"rough fitted", "rough", fiber::Estimator::fitted, 0, Rows::rough},
    {"elliptical fitted", "elliptical", fiber::Estimator::fitted, 0, Rows::elliptical, Own::ellipse},
    {"elliptical corrected", "elliptical", fiber::Estimator::corrected, 0, Rows::elliptical},
    {"elliptical exact", "elliptical", fiber::Estimator::exact, 0, Rows::none, Own::ellipse},
    {"deon2011 10", "deon2011", fiber::Estimator::exact, 10, Rows::none, Own::circle},
    {"deon2011 35", "deon2011", fiber::Estimator::exact, 35, Rows::none, Own::circle},
    {"deon2011 100", "deon2011", fiber::Estimator::exact, 100, Rows::none, Own::circle},
    {"chiang2016", "chiang2016"},
    {"marschner2003", "marschner2003"},
    {"ou2012", "ou2012"},
    {"deon2022", "deon2022"},
    {"pekelis2015 fitted", "pekelis2015", fiber::Estimator::fitted, 0, Rows::pekelis, Own::functions},
    {"pekelis2015 exact", "pekelis2015"},
    {"pekelis2015-printed fitted", "pekelis2015-printed", fiber::Estimator::fitted, 0, Rows::pekelis, Own::functions},
    {"fiber3d", "fiber3d"},
};

constexpr std::array<const char*, 9> measures{"mass", "energy",  "weight",  "variance", "p",
                                              "own",  "ellipse", "unsound", "error"};
using Measured = std::array<std::optional<double>, measures.size()>;

/// One fiber of a model, as test::weights() asks for it.
struct ModelledFiber {
  const fiber::FiberModel& of;
  fiber::FiberId id;
  const fiber::FiberModel& model() const { return of; }
  fiber::FiberEvent begin(const FiberDirection& wr, RandomStream& random) const {
    const float xi1 = random.next(), xi2 = random.next(), h = 2 * random.next() - 1;
    return of.begin(id, wr, xi1, xi2, h);
  }
};

/// The nodes that any xi chooses at wr are asked over all inclinations, so often that rows are created, tested and
/// converge; by `exact` answers nothing is learned.
struct Teacher {
  fiber::ModelService learned;
  adaptive::Service* service;
  adaptive::PassReport report;

  Teacher(const fiber::ModelInfo& info, const Settings& settings) {
    adaptive::Options options;
    options.epsilon = settings.epsilon;
    options.memory_bytes = std::size_t{1} << 30;
    options.heard_share = 0;  // what is heard is drawn from the fiber, and evaluate() knows the row
    learned = fiber::make_service(info, options);
    service = learned.service.get();
  }

  void teach(fiber::FiberModel& model, const std::vector<Cell>& cells) {
    constexpr int passes = 40, thetas = 96, phis = 4;
    for (int pass = 0; pass < passes; ++pass) {
      RandomStream random(7, static_cast<std::uint64_t>(pass));
      for (const Cell& cell : cells) {
        // Fibers of narrower blurs have the rows of the narrowest grid, and would trace for every answer.
        FiberParameters fiber = cell.fiber;
        const std::array<float, 3> sigmas = fiber::azimuthal_sigmas(fiber);
        for (std::size_t i = 0; i < sigmas.size(); ++i) {
          if (sigmas[i] < fiber::smallest_grid_sigma) fiber.azimuthal_sigma[i] = fiber::smallest_grid_sigma;
        }
        const fiber::FiberId id = model.add_fiber(fiber);
        for (const auto& [xi1, xi2] :
             {std::pair{0.001f, 0.001f}, {0.001f, 0.999f}, {0.999f, 0.001f}, {0.999f, 0.999f}}) {
          const fiber::FiberEvent event = model.begin(id, cell.wr(), xi1, xi2, 0);
          for (int k = 0; k < thetas * phis; ++k) {
            const auto theta = static_cast<float>(pi * ((k / phis + double{random.next()}) / thetas - 0.5));
            (void)model.evaluate(event, {theta, static_cast<float>(pi) * (2 * random.next() - 1)});
          }
        }
      }
      report = service->publish();
      if (pass > 2 && report.rows_open == 0) break;
    }
  }
};

float smallest_sigma(const Cell& cell) { return std::ranges::min(fiber::azimuthal_sigmas(cell.fiber)); }

/// Densities, 1/rad, over equal steps of phi_i - phi_r from -180 degrees: of TT, TRT (with its GLINT) and TRRT.
using Curves = std::array<std::vector<double>, 3>;

std::size_t steps_of(const Cell& cell) {
  return static_cast<std::size_t>(std::max(360.0, std::ceil(6 * pi / double{smallest_sigma(cell)})));
}

Curves reference_of(const Cell& cell, bool circle) {
  Curves curves;
  const auto sigmas = fiber::azimuthal_sigmas(cell.fiber);
  const double scale = circle ? double{fiber::circle_radius(cell.fiber.eccentricity)} : 1;
  for (std::size_t lobe = 0; lobe < curves.size(); ++lobe) {
    std::vector<double>& curve = curves[lobe];
    curve.resize(steps_of(cell));
    const fiber::FourierReference reference({.eta = double{cell.fiber.eta},
                                             .eccentricity = circle ? 1.0 : double{cell.fiber.eccentricity},
                                             .theta_d = cell.theta_deg * degree,
                                             .phi_r = cell.phi_deg * degree,
                                             .sigma = double{sigmas[lobe]},
                                             .sigma_a = double{cell.fiber.sigma_a.g} * scale,
                                             .p = static_cast<int>(lobe) + 1,
                                             .nodes = 8192});
    for (std::size_t k = 0; k < curve.size(); ++k) {
      const double x = 2 * pi * static_cast<double>(k) / static_cast<double>(curve.size()) - pi;
      curve[k] = reference.density(cell.phi_deg * degree + x);
    }
  }
  return curves;
}

/// Each lobe's S on the specular cone, of the fiber without tilt, mean over (xi, h): their shapes.
Curves curves_of(fiber::FiberModel& model, const Rival& rival, Cell cell) {
  cell.fiber.tilt = 0;
  const fiber::FiberId id = model.add_fiber(cell.fiber);
  Curves curves;
  curves.fill(std::vector<double>(steps_of(cell)));
  const bool near = std::string(rival.model) == "chiang2016",
             grid = rival.rows == Rows::elliptical && smallest_sigma(cell) >= fiber::smallest_grid_sigma;
  const int events = near ? 32 : grid ? 9 : 1;
  for (int k = 0; k < events; ++k) {
    const float xi1 = grid ? (static_cast<float>(k % 3) + 0.5f) / 3 : own_xi1;
    const float xi2 = grid ? (static_cast<float>(k / 3) + 0.5f) / 3 : own_xi2;
    const float h = near ? (2 * static_cast<float>(k) + 1) / 32 - 1 : 0;
    const fiber::FiberEvent event = model.begin(id, cell.wr(), xi1, xi2, h);
    for (std::size_t i = 0; i < curves[0].size(); ++i) {
      const double x = 2 * pi * static_cast<double>(i) / static_cast<double>(curves[0].size()) - pi;
      const fiber::FiberValue value = model.evaluate(
          event, {-event.wr.theta, static_cast<float>(std::remainder(cell.phi_deg * degree + x, 2 * pi))});
      for (std::size_t lobe = 0; lobe < curves.size(); ++lobe) curves[lobe][i] += double{value.s[lobe + 1].g};
    }
  }
  return curves;
}

double mass_of(const std::vector<double>& curve) {
  return std::accumulate(curve.begin(), curve.end(), 0.0) * 2 * pi / static_cast<double>(curve.size());
}

/// Relative L2 of the lobes together, each with the energy that the ellipse has: of lobes of 1e-3 or more.
std::optional<double> relative_l2(const Curves& curves, const Curves& truth, const Curves& ellipse) {
  std::vector<double> off(truth[0].size()), norm = off;
  double energy_of_all = 0;
  for (std::size_t lobe = 0; lobe < truth.size(); ++lobe) {
    const double energy = mass_of(ellipse[lobe]), mass = mass_of(curves[lobe]), true_mass = mass_of(truth[lobe]);
    if (!(energy >= 1e-3 && true_mass > 0)) continue;
    energy_of_all += energy;
    for (std::size_t i = 0; i < off.size(); ++i) {
      const double true_part = energy / true_mass * truth[lobe][i];
      norm[i] += true_part;
      off[i] += (mass > 0 ? energy / mass * curves[lobe][i] : 0) - true_part;
    }
  }
  if (!(energy_of_all > 0)) return {};
  return std::sqrt(std::inner_product(off.begin(), off.end(), off.begin(), 0.0) /
                   std::inner_product(norm.begin(), norm.end(), norm.begin(), 0.0));
}

class SliceMaps {
 public:
  SliceMaps(const Slice& slice, const Settings& settings) : settings_(settings), cells_(cells_of(slice)) {
    json_ = {{"name", slice.name}, {"x", axis(slice.x)}, {"y", axis(slice.y)}};
    for (const Cell& cell : cells_) {
      ellipses_.push_back(reference_of(cell, false));
      circles_.push_back(reference_of(cell, true));
    }
    print_measures("references");
    for (const Rival& rival : rivals) {
      if (!settings.rival.empty() && settings.rival != rival.name) continue;
      measure(rival);
      print_measures(rival.name);
    }
  }
  nlohmann::ordered_json& json() { return json_; }

 private:
  static nlohmann::ordered_json axis(const Axis& axis) {
    return {{"name", axis.name}, {"unit", axis.unit}, {"values", axis.values}};
  }
  void print_measures(const char* what) const {
    fmt::print(stderr, "{:<8} {:<28} {:7.1f} s of CPU\n", json_["name"].get<std::string>(), what,
               static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
  }

  Teacher* teacher_of(const Rival& rival, const fiber::ModelInfo& info) {
    if (rival.rows == Rows::none) return nullptr;
    std::unique_ptr<Teacher>& teacher = teachers_[rival.rows];
    if (teacher) return teacher.get();
    teacher = std::make_unique<Teacher>(info, settings_);
    const auto model = info.make({.estimator = fiber::Estimator::fitted, .service = teacher->service});
    teacher->teach(*model, cells_);
    const adaptive::PassReport& report = teacher->report;
    json_["rows"][info.name] = {
        {"converged", report.rows_converged}, {"open", report.rows_open}, {"refused", report.rows_refused}};
    teacher->service->set_learning(false);
    return teacher.get();
  }

  void measure(const Rival& rival) {
    const fiber::ModelInfo& info = *references::find_model(rival.model);
    Teacher* teacher = teacher_of(rival, info);
    const auto make = [&](fiber::Estimator estimator) {
      const bool learns = teacher != nullptr && estimator != fiber::Estimator::exact;
      return info.make(
          {.estimator = estimator, .service = learns ? teacher->service : nullptr, .quadrature_points = rival.points});
    };
    const auto model = make(rival.estimator);
    const auto functions = rival.own == Own::functions ? make(fiber::Estimator::exact) : nullptr;
    std::array<std::string, measures.size()> texts;
    for (std::size_t k = 0; k < cells_.size(); ++k) {
      const Measured found = measure(rival, *model, functions.get(), k);
      for (std::size_t m = 0; m < measures.size(); ++m) {
        texts[m] += k > 0 ? " " : "";
        texts[m] += !found[m] ? "-" : m < 2 ? fmt::format("{:.3f}", *found[m]) : fmt::format("{:.2g}", *found[m]);
      }
    }
    for (std::size_t m = 0; m < measures.size(); ++m) {
      if (texts[m].find_first_not_of("- ") != std::string::npos) json_["cells"][rival.name][measures[m]] = texts[m];
    }
  }

  Measured measure(const Rival& rival, fiber::FiberModel& model, fiber::FiberModel* functions, std::size_t k) const {
    const Cell& cell = cells_[k];
    const ModelledFiber one{model, model.add_fiber(cell.fiber)};
    const bool narrow = std::string(rival.model) == "elliptical" && smallest_sigma(cell) < fiber::smallest_grid_sigma;
    const bool corrected = rival.estimator == fiber::Estimator::corrected;
    if (corrected && narrow) return {};  // as good as fitted, which traces there
    const int samples = narrow ? std::min(settings_.samples, narrow_samples) : settings_.samples;
    const test::Weights weights = test::weights(one, cell.wr(), samples, settings_.seed);
    Measured found;
    found[1] = weights.mean;
    found[2] = weights.largest;
    if (weights.mean > 1e-4) found[3] = weights.variance / (weights.mean * weights.mean);
    found[8] = weights.standard_error;
    if (!model.evaluates()) return found;
    const fiber::FiberEvent event = model.begin(one.id, cell.wr(), own_xi1, own_xi2, own_h);
    const test::PanelIntegrals all = test::DirectionPanels(model, event,
                                                           {.samples = samples,
                                                            .pilot = samples / 2,
                                                            .most_points = settings_.points,
                                                            .seed = settings_.seed + 1,
                                                            .smooth = !corrected})
                                         .result();
    found[0] = found[1] = found[8] = std::nullopt;
    if (corrected) found[8] = all.s_error;
    if (all.pdf_error < largest_error) found[0] = all.pdf;
    if (all.s_error < largest_error * std::max(all.s, 1.0) || corrected) found[1] = all.s;
    found[2] = std::max(weights.largest, all.largest_weight);
    if (all.pdf_error < largest_error && all.fit_error < largest_fit_error) found[4] = all.fit.p_value;
    found[7] = static_cast<double>(all.unsound);
    // Of `corrected` one answer in sixteen has sixteen times its error: it is exact in the mean only. `rough` is no sum
    // of blurred lobes.
    if (corrected || rival.rows == Rows::rough) return found;
    const Curves curves = curves_of(model, rival, cell);
    const Curves& ellipse = ellipses_[k];
    found[6] = relative_l2(curves, ellipse, ellipse);
    if (rival.own == Own::ellipse) found[5] = found[6];
    if (rival.own == Own::circle) found[5] = relative_l2(curves, circles_[k], ellipse);
    if (rival.own == Own::functions) found[5] = relative_l2(curves, curves_of(*functions, rival, cell), ellipse);
    return found;
  }

  const Settings& settings_;
  std::vector<Cell> cells_;
  std::vector<Curves> ellipses_, circles_;
  std::map<Rows, std::unique_ptr<Teacher>> teachers_;
  nlohmann::ordered_json json_;
};

int run(const Settings& settings) {
  nlohmann::ordered_json names = nlohmann::ordered_json::array(), maps = nlohmann::ordered_json::array();
  for (const Rival& rival : rivals) names.push_back(rival.name);
  for (const Slice& slice : slices(settings)) maps.push_back(std::move(SliceMaps(slice, settings).json()));
  fmt::print("{}\n", nlohmann::ordered_json{{"samples", settings.samples},
                                            {"epsilon", settings.epsilon},
                                            {"seed", settings.seed},
                                            {"rivals", names},
                                            {"measures", measures},
                                            {"slices", maps}}
                         .dump());
  return 0;
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Settings settings;
  CLI::App app("Maps of every model over slices of the domain");
  app.add_flag("--quick", settings.quick, "two values an axis");
  app.add_option("--samples", settings.samples)->check(CLI::Range(200, 1000000));
  app.add_option("--epsilon", settings.epsilon)->check(CLI::Range(1e-6, 0.1));
  app.add_option("--seed", settings.seed);
  app.add_option("--slice", settings.slice)
      ->check(CLI::IsMember({"e", "sigma", "alpha", "eta", "sigma_a", "lambda", "sigma_e"}));
  app.add_option("--rival", settings.rival, "one of the names in the output");
  CLI11_PARSE(app, argc, argv);
  if (settings.quick) settings.points = 10000;
  return tress::run(settings);
}
