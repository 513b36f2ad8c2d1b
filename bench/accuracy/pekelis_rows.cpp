// How well the rows of pekelis2015 are fitted: rows of the paper's grid (section 6), learned through the service with a
// learner of choice, against Marschner's functions as they are (not blurred), by the error of the paper's section 7.1
// at its 3601 azimuths, the mean of N being its integral over 2 pi. Rows of mass below 1e-3 are counted apart: their
// GLINT has no caustic.
//
//   bench_pekelis_rows [--rows N | --grid all|hardest] [--stride N] [--lobe TRT|GLINT] [--seed N] [--epsilon E]
//                      [--learner NAME] [--components N] [--blur DEG] [--json FILE]
//
// N rows at random of both lobes, or of the one that is named; --grid all: every one of the 25,572; hardest: those of e
// 0.85 and sigma 10 (the paper's figure 9); --stride takes every Nth node of each axis. The JSON has a histogram of the
// errors and, of whole slices, every error: 100 log10 of it, a line for each phi_r, "-" where there is no light; and
// four rows of the hardest slice: the best, the quartiles and the worst, with what they were fitted to.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "knot_rows.h"
#include "known_learner.h"
#include "references/models/pekelis2015_target.h"
#include "references/registry.h"
#include "results_file.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace {

using namespace tress;
using fiber::MarschnerLobe;

constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr int azimuths = 3601, passes = 80, asked_a_pass = 16;
constexpr double least_mass = 1e-3;

struct Setting {
  int rows = 1000, stride = 1;
  std::string grid, lobe, json;
  double blur = 0;
  std::uint32_t components = 0;  ///< 0: the paper's, 5 and 3
  std::uint64_t seed = 1;
  adaptive::Options options;
};

struct Row {
  std::uint32_t a = 0, b = 0;
  bool lit = false, converged = false, fitted = false;
  double error = 1;
  std::uint32_t components = 0;
};

struct Slice {
  double e = 0, sigma_deg = 0;
  adaptive::SliceDescription description;
  std::vector<Row> rows;
  bool hardest() const { return e < 0.86 && sigma_deg < 10.5; }
};

/// At the 3601 azimuths.
std::vector<double> curve_of(const Slice& slice, const Row& row) {
  std::vector<double> curve;
  for (int i = 0; i < azimuths; ++i) {
    curve.push_back(fiber::pekelis_curve(slice.description.key, static_cast<double>(slice.description.axis_a[row.a]),
                                         static_cast<double>(slice.description.axis_b[row.b]),
                                         -pi + i * 2 * pi / (azimuths - 1)));
  }
  return curve;
}

/// fit: what has a density.
template <class Fit>
void measure(const Slice& slice, const Fit& fit, bool converged, bool fitted, Row& row) {
  const std::vector<double> curve = curve_of(slice, row);
  constexpr double step = 2 * pi / (azimuths - 1);
  double mass = 0, variation = 0, sum = 0;
  for (int i = 1; i < azimuths; ++i) mass += curve[static_cast<std::size_t>(i)] * step;
  row.lit = mass >= least_mass;
  row.converged = converged;
  row.fitted = fitted;
  if (!row.lit || !row.fitted) return;
  for (int i = 0; i < azimuths; ++i) {
    const double n = curve[static_cast<std::size_t>(i)];
    const double d = n - static_cast<double>(fit.density(static_cast<float>(-pi + i * step)));
    variation += (n - mass / (2 * pi)) * (n - mass / (2 * pi)) * step;
    sum += d * d * step;
  }
  row.error = sum / std::max(variation, least_mass / (2 * pi));
}

/// The curves of a row and its fit, at every 10th azimuth.
nlohmann::json drawn(const Slice& slice, const Row& row, const adaptive::RowView& view) {
  const std::vector<double> curve = curve_of(slice, row);
  nlohmann::json json{
      {"error", row.error}, {"phi_r_deg", 2 * row.a}, {"theta_d_deg", 2 * row.b}, {"components", row.components}};
  std::string truth, fit;
  for (int i = 0; i < azimuths; i += 10) {
    const auto x = static_cast<float>(-pi + i * 2 * pi / (azimuths - 1));
    truth += fmt::format("{:.4g} ", curve[static_cast<std::size_t>(i)]);
    fit += fmt::format("{:.4g} ", view.density(x));
  }
  json["truth"] = truth;
  json["fit"] = fit;
  return json;
}

struct Learned {
  double cpu_seconds = 0;
  std::uint64_t g_evaluations = 0;
};

/// The rows of one slice by knots.
Learned fit_knots_to(const Setting& setting, const adaptive::Target& target, Slice& slice) {
  bench::KnotFitter fitter{setting.options.epsilon};
  std::vector<adaptive::TracedRay> rays;
  for (Row& row : slice.rows) {
    rays.clear();
    target.trace(slice.description, slice.description.axis_a[row.a], slice.description.axis_b[row.b], rays);
    const bench::KnotRow made = fitter.fit(adaptive::TracedNodes(rays, slice.description.blur_rad));
    measure(slice, made.table, made.converged, made.converged, row);
  }
  return {fitter.cpu_seconds, fitter.g_evaluations};
}

/// The rows of one slice, by a service of its own: no more than a slice is in memory.
Learned learn(const Setting& setting, const adaptive::Target& target, Slice& slice, nlohmann::json& curves) {
  adaptive::Service service(setting.options, target);
  const adaptive::SliceId id = *service.add_slice(slice.description);
  RandomStream random(setting.seed, 7);
  const float share = setting.options.uniform_share_open;
  Learned learned;
  for (int pass = 0; pass < passes; ++pass) {
    bool waiting = false;
    for (const Row& row : slice.rows) {
      for (int i = 0; i < asked_a_pass; ++i) {
        const adaptive::RowView view = service.look_up(id, row.a, row.b);
        if (view.state == adaptive::RowState::converged || view.state == adaptive::RowState::refused) break;
        waiting = true;
        if (view.fit == nullptr) continue;
        const float x = view.fit->sample(random.next(), share);
        service.score(view, x, view.nodes->density(x), view.fit->proposal_density(x, share));
      }
    }
    if (!waiting) break;
    const adaptive::PassReport report = service.publish();
    learned.cpu_seconds += report.learning_cpu_seconds;
    learned.g_evaluations += report.g_evaluations;
  }
  std::vector<const Row*> order;
  for (Row& row : slice.rows) {
    const adaptive::RowView view = service.peek(id, row.a, row.b);
    measure(slice, view, view.state == adaptive::RowState::converged, view.fit != nullptr, row);
    row.components = view.fit ? view.fit->component_count : 0;
    if (row.lit && row.fitted) order.push_back(&row);
  }
  if (!slice.hardest() || order.empty()) return learned;
  std::ranges::sort(order, {}, [](const Row* row) { return row->error; });
  for (const double rank : {0.0, 0.25, 0.75, 1.0}) {
    const Row& row = *order[static_cast<std::size_t>(rank * static_cast<double>(order.size() - 1))];
    curves.push_back(drawn(slice, row, service.peek(id, row.a, row.b)));
  }
  return learned;
}

std::vector<Slice> draw_slices(const Setting& setting, MarschnerLobe lobe) {
  std::vector<Slice> slices;
  std::vector<double> below;  // rows of the slices so far
  for (const double e : {0.85, 0.9, 0.95, 1.0}) {
    for (const double sigma : {10.0, 15.0, 20.0, 25.0}) {
      Slice slice{
          e, sigma, fiber::pekelis_slice(lobe, 1.55f, static_cast<float>(e), static_cast<float>(sigma * degree)), {}};
      if (setting.components > 0) slice.description.max_components = setting.components;
      if (setting.blur > 0) slice.description.blur_rad = static_cast<float>(setting.blur);
      below.push_back((below.empty() ? 0 : below.back()) + slice.description.node_count());
      slices.push_back(std::move(slice));
    }
  }
  if (!setting.grid.empty()) {
    for (Slice& slice : slices) {
      if (setting.grid == "hardest" && !slice.hardest()) continue;
      const auto step = static_cast<std::uint32_t>(setting.stride);
      for (std::uint32_t a = 0; a < slice.description.axis_a.size(); a += step) {
        for (std::uint32_t b = 0; b < slice.description.axis_b.size(); b += step) slice.rows.push_back({a, b});
      }
    }
    return slices;
  }
  RandomStream random(setting.seed, 25572);
  for (int i = 0; i < setting.rows; ++i) {
    const double u = static_cast<double>(random.next()) * below.back();
    Slice& slice = slices[static_cast<std::size_t>(std::upper_bound(below.begin(), below.end(), u) - below.begin())];
    const auto index = [&](std::size_t size) {
      return static_cast<std::uint32_t>(random.next() * static_cast<float>(size));
    };
    const std::uint32_t a = index(slice.description.axis_a.size());
    slice.rows.push_back({a, index(slice.description.axis_b.size())});
  }
  return slices;
}

double quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

nlohmann::json map_of(const Slice& slice) {
  nlohmann::json lines = nlohmann::json::array();
  std::optional<std::uint32_t> a;
  std::string line;
  const auto end_line = [&] {
    if (a) lines.push_back(line);
    line.clear();
  };
  for (const Row& row : slice.rows) {
    if (a != row.a) end_line(), a = row.a;
    const bool usable = row.lit && row.fitted;
    if (!line.empty()) line += ' ';
    if (usable)
      line += fmt::format("{:.0f}", 100 * std::log10(std::max(row.error, 1e-9)));
    else
      line += '-';
  }
  end_line();
  return {{"e", slice.e}, {"sigma_deg", slice.sigma_deg}, {"log10_error_x100", lines}};
}

nlohmann::json study(const Setting& setting, MarschnerLobe lobe) {
  const fiber::PekelisTarget target;
  std::vector<Slice> slices = draw_slices(setting, lobe);
  Learned learned;
  nlohmann::json curves = nlohmann::json::array(), maps = nlohmann::json::array();
  for (Slice& slice : slices) {
    if (slice.rows.empty()) continue;
    const Learned of_slice = setting.options.learner == &bench::knot_learner ? fit_knots_to(setting, target, slice)
                                                                             : learn(setting, target, slice, curves);
    learned.cpu_seconds += of_slice.cpu_seconds;
    learned.g_evaluations += of_slice.g_evaluations;
    if (!setting.grid.empty()) maps.push_back(map_of(slice));
  }
  std::vector<double> errors;
  std::array<int, adaptive::Mixture::max_components + 1> components{};
  int converged = 0, without_light = 0, without_fit = 0;
  for (const Slice& slice : slices) {
    for (const Row& row : slice.rows) {
      if (!row.lit) {
        ++without_light;
        continue;
      }
      converged += row.converged ? 1 : 0;
      without_fit += row.fitted ? 0 : 1;
      if (!row.fitted) continue;
      errors.push_back(row.error);
      ++components[row.components];
    }
  }
  std::ranges::sort(errors);
  if (errors.empty()) errors.push_back(1);
  const auto below = [&](double threshold) {
    return static_cast<double>(std::ranges::lower_bound(errors, threshold) - errors.begin()) /
           static_cast<double>(errors.size());
  };
  // Ten bins a decade from 1e-7 to 10.
  std::vector<int> histogram(80);
  for (const double error : errors) {
    ++histogram[static_cast<std::size_t>(std::clamp(10 * (std::log10(std::max(error, 1e-9)) + 7), 0.0, 79.0))];
  }
  const auto n = static_cast<double>(errors.size() + static_cast<std::size_t>(without_fit));
  return {{"lobe", lobe == MarschnerLobe::trt ? "TRT" : "GLINT"},
          {"learner", setting.options.learner->name},
          {"epsilon", setting.options.epsilon},
          {"most_components", slices.front().description.max_components},
          {"seed", setting.seed},
          {"stride", setting.stride},
          {"rows", n},
          {"without_light", without_light},
          {"without_fit", without_fit},
          {"converged_share", converged / n},
          {"error",
           {{"p50", quantile(errors, 0.5)},
            {"p90", quantile(errors, 0.9)},
            {"p99", quantile(errors, 0.99)},
            {"max", errors.back()}}},
          {"below_a_tenth_share", below(0.1)},
          {"below_a_hundredth_share", below(0.01)},
          {"histogram_from_1e-7_ten_a_decade", histogram},
          {"components", components},
          {"learning_cpu_us_a_row", 1e6 * learned.cpu_seconds / (n + without_light)},
          {"g_evaluations_a_row", static_cast<double>(learned.g_evaluations) / (n + without_light)},
          {"curves", curves},
          {"maps", maps}};
}

void print(const nlohmann::json& r) {
  fmt::print(
      "{} {}: {:.0f} rows ({} more without light), converged {:.1f} %, error median {:.2g}, 90 % {:.2g}, 99 % {:.2g}, "
      "largest {:.2g}, below .1 {:.1f} %\n  components {}, learning {:.0f} us a row\n",
      r["lobe"].get<std::string>(), r["learner"].get<std::string>(), r["rows"].get<double>(),
      r["without_light"].get<int>(), 100 * r["converged_share"].get<double>(), r["error"]["p50"].get<double>(),
      r["error"]["p90"].get<double>(), r["error"]["p99"].get<double>(), r["error"]["max"].get<double>(),
      100 * r["below_a_tenth_share"].get<double>(), r["components"].dump(), r["learning_cpu_us_a_row"].get<double>());
}

}  // namespace

int main(int argc, char** argv) {
  Setting setting;
  setting.options.memory_bytes = std::size_t{4} << 30;
  double blur_deg = 0;
  std::string learner = setting.options.learner->name;
  CLI::App app("rows of the paper's grid fitted to Marschner's TRT and GLINT");
  CLI::Option* rows = app.add_option("--rows", setting.rows, "at random")->check(CLI::PositiveNumber);
  app.add_option("--grid", setting.grid)->check(CLI::IsMember({"all", "hardest"}))->excludes(rows);
  app.add_option("--stride", setting.stride)->check(CLI::PositiveNumber);
  app.add_option("--lobe", setting.lobe)->check(CLI::IsMember({"TRT", "GLINT"}));
  app.add_option("--seed", setting.seed);
  app.add_option("--epsilon", setting.options.epsilon)->check(CLI::PositiveNumber);
  app.add_option("--learner", learner)->check(bench::known_row_learner);
  app.add_option("--components", setting.components, "0: the paper's, 5 and 3")
      ->check(CLI::Range(0, int{adaptive::Mixture::max_components}));
  app.add_option("--blur", blur_deg, "degrees");
  app.add_option("--json", setting.json);
  CLI11_PARSE(app, argc, argv);
  setting.blur = blur_deg * degree;
  setting.options.learner = bench::find_row_learner(learner);
  setting.options.seed = setting.seed;
  nlohmann::json all = nlohmann::json::array();
  for (const MarschnerLobe lobe : {MarschnerLobe::trt, MarschnerLobe::glint}) {
    if (!setting.lobe.empty() && (setting.lobe == "TRT") != (lobe == MarschnerLobe::trt)) continue;
    all.push_back(study(setting, lobe));
    print(all.back());
  }
  return setting.json.empty() ? 0 : bench::write_results(setting.json, all.dump(1) + "\n");
}
