// How well and how fast rows of the elliptical target are learned, through the public service alone: every row of a
// random set is asked as a render asks it, some vertices a pass, until it converges. Prints a table; JSON with --json.
//
//   bench_rows [--rows N] [--seed N] [--epsilon E] [--domain wide|hard|narrow] [--vertices N] [--foreign N]
//              [--passes N] [--sigma-a S] [--trt whole|split] [--learner NAME] [--components N] [--tests N]
//              [--json FILE]
//
// Domains: wide, sigma 5..25 degrees; hard, sigma 1..10 on the grid sigma of the program (at least 4 degrees); narrow,
// sigma 1..10 as it is. e 0.7..1, eta 1.55, lobes and nodes of the slice uniform, E_p >= 0.001 (less is uniform in the
// program). A vertex is one look-up with one azimuth drawn from the row's own proposal; --foreign adds uniform ones
// that are observed and not scored. --trt split asks GLINT and the rest of TRT instead of TT, TRT and TRRT. --sigma-a
// draws from the proposal under that absorption (per semi-axis), and prints how far the fits are from g under it,
// relative to the variation of that. `floor`: of the rows whose variation is below the least one that errors are
// relative to.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "fit/fit_mixture.h"
#include "knot_rows.h"
#include "known_learner.h"
#include "random_rows.h"
#include "references/registry.h"
#include "results_file.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace {

using namespace tress;

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;

struct Setting {
  int rows = 2000, vertices = 16, foreign = 0, passes = 64;
  std::uint64_t seed = 1;
  double epsilon = 0.01, sigma_a = 0;
  std::string domain = "wide", trt = "whole", json;
  const adaptive::Learner* learner = &adaptive::sketch_learner;
  std::uint32_t components = adaptive::Options{}.max_components;
  std::uint32_t tests = adaptive::Options{}.tests_before_refusal;
};

struct Row {
  adaptive::SliceId slice = 0;
  adaptive::SliceDescription description;
  std::uint64_t own = 0, vertices = 0;  ///< until it converged
  bool converged = false;
};

std::vector<Row> draw_rows(const Setting& setting, const adaptive::Target& target, adaptive::Service& service) {
  bench::RandomRows random(setting.seed, setting.domain, setting.trt == "split");
  std::vector<Row> rows;
  while (rows.size() < static_cast<std::size_t>(setting.rows)) {
    Row row;
    row.description = random.next(target).description;
    const Result<adaptive::SliceId> slice = service.add_slice(row.description);
    if (!slice || *slice != rows.size()) continue;  // its key was drawn before, for this node or another
    row.slice = *slice;
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The mixture under an absorption: the gamma law of each component's attribute (ESTIMATOR.md, E1).
adaptive::Mixture absorbed(adaptive::Mixture fit, const adaptive::TracedNodes& nodes, double sigma_a) {
  if (sigma_a <= 0) return fit;
  adaptive::assign_attributes(fit, nodes);
  const auto share = [&](double mean, double variance) {
    if (!(mean > 0) || variance < 1e-9 * mean * mean) return std::exp(-sigma_a * mean);
    return std::pow(1 + sigma_a * variance / mean, -mean * mean / variance);
  };
  for (adaptive::Component& part : fit.components) {
    part.weight *= static_cast<float>(share(part.attribute_mean, part.attribute_variance));
  }
  fit.uniform_weight *= static_cast<float>(share(fit.uniform_attribute_mean, fit.uniform_attribute_variance));
  return fit;
}

/// The rays under an absorption.
std::vector<adaptive::TracedRay> absorbed(std::vector<adaptive::TracedRay> rays, double sigma_a) {
  for (adaptive::TracedRay& ray : rays) {
    ray.weight *= static_cast<float>(std::exp(-sigma_a * static_cast<double>(ray.attribute)));
  }
  return rays;
}

/// Integral of (g - mean g)^2, as TracedNodes::variation() without its floor.
double own_variation(const adaptive::TracedNodes& nodes) {
  const double mean = static_cast<double>(nodes.energy()) / (2 * pi);
  double sum = 0;
  for (const float g : nodes.grid()) sum += (static_cast<double>(g) - mean) * (static_cast<double>(g) - mean);
  return sum * 2 * pi / static_cast<double>(nodes.grid().size());
}

void ask(const Setting& setting, const adaptive::Service& service, Row& row, RandomStream& random) {
  const float share = service.options().uniform_share_open;
  adaptive::Mixture proposal;
  for (int i = 0; i < setting.vertices; ++i) {
    const adaptive::RowView view = service.look_up(row.slice, 0, 0);
    ++row.vertices;
    if (view.state != adaptive::RowState::open) continue;
    for (int k = 0; k < setting.foreign; ++k) {
      const auto x = static_cast<float>(2 * pi * (static_cast<double>(random.next()) - 0.5));
      service.observe(view, x, view.nodes->density(x));
    }
    if (view.fit == nullptr) continue;
    if (i == 0) proposal = absorbed(*view.fit, *view.nodes, setting.sigma_a);
    const float x = proposal.sample(random.next(), share);
    service.score(view, x, view.nodes->density(x), proposal.proposal_density(x, share));
    ++row.own;
  }
}

nlohmann::json study(const Setting& setting) {
  const auto target = fiber::make_elliptical_target();
  adaptive::Options options;
  options.epsilon = setting.epsilon;
  options.memory_bytes = std::size_t{4} << 30;
  options.seed = setting.seed;
  options.learner = setting.learner;
  options.max_components = setting.components;
  options.tests_before_refusal = setting.tests;
  adaptive::Service service(options, *target);
  std::vector<Row> rows = draw_rows(setting, *target, service);

  double cpu = 0;
  std::uint64_t evaluations = 0, validation_draws = 0, refits = 0;
  adaptive::PassReport report;
  std::vector<double> open_share;
  for (int pass = 0; pass < setting.passes; ++pass) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].converged) continue;
      RandomStream random(setting.seed, i, static_cast<std::uint64_t>(pass) + 1);
      ask(setting, service, rows[i], random);
    }
    report = service.publish();
    cpu += report.learning_cpu_seconds;
    evaluations += report.g_evaluations;
    validation_draws += report.validation_draws;
    refits += report.refits;
    for (Row& row : rows) {
      row.converged = row.converged || service.peek(row.slice, 0, 0).state == adaptive::RowState::converged;
    }
    if (report.rows_converged == rows.size()) break;
  }

  std::vector<double> errors, all_errors, own, vertices;
  std::map<std::string, std::vector<double>> errors_of_lobe, absorbed_of_lobe;
  int at_floor = 0, above_own = 0;
  double worst = -1;
  std::string worst_row;
  int falsely = 0, below_a_tenth = 0;
  std::vector<double> slack;  // stored bound over true error
  for (const Row& row : rows) {
    const adaptive::RowView view = service.peek(row.slice, 0, 0);
    if (view.fit == nullptr) continue;
    std::vector<adaptive::TracedRay> rays;
    target->trace(row.description, row.description.axis_a[0], row.description.axis_b[0], rays);
    const adaptive::TracedNodes nodes(rays, row.description.blur_rad);
    const double error = bench::true_objective(view, nodes);
    below_a_tenth += error < 0.1 ? 1 : 0;
    all_errors.push_back(error);
    if (!row.converged) continue;
    own.push_back(static_cast<double>(row.own));
    vertices.push_back(static_cast<double>(row.vertices));
    errors.push_back(error);
    const std::string lobe = fmt::format("p{}", row.description.key.lobe);
    errors_of_lobe[lobe].push_back(error);
    const double variation = own_variation(nodes), stated = static_cast<double>(nodes.variation());
    if (variation < stated * (1 - 1e-6)) {
      ++at_floor;
      above_own += error * stated > setting.epsilon * variation ? 1 : 0;
    }
    if (setting.sigma_a > 0 && view.fit != nullptr) {
      const adaptive::TracedNodes colored(absorbed(rays, setting.sigma_a), row.description.blur_rad);
      absorbed_of_lobe[lobe].push_back(bench::true_objective(absorbed(*view.fit, nodes, setting.sigma_a), colored) *
                                       static_cast<double>(colored.variation()) / own_variation(colored));
    }
    slack.push_back(static_cast<double>(view.objective) / std::max(error, 1e-12));
    falsely += error > setting.epsilon ? 1 : 0;
    if (error > worst) {
      worst = error;
      worst_row =
          fmt::format("p {} e {:.4f} sigma {:.3f} phi_r {:.3f} theta_d {:.3f} degrees", row.description.key.lobe,
                      row.description.key.parameters[1], row.description.key.parameters[2] / degree,
                      row.description.axis_a[0] / degree, row.description.axis_b[0] / degree);
    }
  }
  const auto n = static_cast<double>(rows.size());
  std::vector<std::uint64_t> components(report.components.begin(), report.components.end());
  double cache_row_bytes = 0;  // of the rows alone: a slice has many, here each has one
  const adaptive::TableSnapshot image = service.snapshot();
  for (const adaptive::CachedSlice& slice : image.slices) {
    for (const adaptive::CachedRow& row : slice.rows) {
      const std::size_t parts = 12 + 24 * row.density()->fit.component_count;
      cache_row_bytes += static_cast<double>(28 + (row.state == adaptive::RowState::converged ? parts : 0));
    }
  }
  const auto by_lobe = [](const std::map<std::string, std::vector<double>>& errors_by_lobe) {
    nlohmann::json lobes = nlohmann::json::object();
    for (const auto& [lobe, values] : errors_by_lobe) lobes[lobe] = bench::spread(values);
    return lobes;
  };
  return {{"domain", setting.domain},
          {"learner", setting.learner->name},
          {"most_components", setting.components},
          {"tests_before_refusal", setting.tests},
          {"trt", setting.trt},
          {"epsilon", setting.epsilon},
          {"rows", setting.rows},
          {"seed", setting.seed},
          {"vertices_a_pass", setting.vertices},
          {"foreign_a_vertex", setting.foreign},
          {"sigma_a", setting.sigma_a},
          {"converged_share", static_cast<double>(errors.size()) / n},
          {"below_a_tenth_share", below_a_tenth / n},
          {"refused", report.rows_refused},
          {"false", falsely},
          {"own_samples", bench::spread(own)},
          {"vertices", bench::spread(vertices)},
          {"relative_l2", bench::spread(errors)},
          {"relative_l2_of_all", bench::spread(all_errors)},
          {"relative_l2_of_lobe", by_lobe(errors_of_lobe)},
          {"absorbed_relative_l2_of_lobe", by_lobe(absorbed_of_lobe)},
          {"at_floor_share", at_floor / n},
          {"at_floor_above_epsilon_share", above_own / n},
          {"worst_row", worst_row},
          {"bound_over_error_p50", bench::quantile(slack, .5)},
          {"components", components},
          {"g_evaluations_a_row", static_cast<double>(evaluations) / n},
          {"top_ups_a_row", static_cast<double>(validation_draws) / n},
          {"refits_a_row", static_cast<double>(refits) / n},
          {"bytes_a_row", static_cast<double>(report.bytes) / n},
          {"cache_row_bytes", cache_row_bytes / n},
          {"learning_cpu_us_a_row", 1e6 * cpu / n}};
}

void print(const nlohmann::json& r) {
  const auto line = [&](const char* what, const char* key) {
    const nlohmann::json& s = r[key];
    fmt::print("{:<28}{:>10.3g}{:>10.3g}{:>10.3g}{:>10.3g}\n", what, s["p50"].get<double>(), s["p90"].get<double>(),
               s["p99"].get<double>(), s["max"].get<double>());
  };
  fmt::print("{} {} epsilon {} sigma_a {}: {} rows, seed {}, {} vertices a pass\n", r["learner"].get<std::string>(),
             r["domain"].get<std::string>(), r["epsilon"].get<double>(), r["sigma_a"].get<double>(),
             r["rows"].get<int>(), r["seed"].get<int>(), r["vertices_a_pass"].get<int>());
  fmt::print("{:<28}{:>10}{:>10}{:>10}{:>10}\n", "", "median", "90 %", "99 %", "max");
  line("own samples to converge", "own_samples");
  line("vertices to converge", "vertices");
  line("relative squared L2", "relative_l2");
  line("... of all rows", "relative_l2_of_all");
  fmt::print("converged {:.2f} %, below .1 {:.2f} %, refused {}, false {} (worst: {})\n",
             100 * r["converged_share"].get<double>(), 100 * r["below_a_tenth_share"].get<double>(),
             r["refused"].get<int>(), r["false"].get<int>(), r["worst_row"].get<std::string>());
  for (const auto& [lobe, of_lobe] : r["absorbed_relative_l2_of_lobe"].items()) {
    fmt::print("{} clear: median {:.2g}, 90 % {:.2g}; absorbed: {:.2g}, {:.2g}\n", lobe,
               r["relative_l2_of_lobe"][lobe]["p50"].get<double>(), r["relative_l2_of_lobe"][lobe]["p90"].get<double>(),
               of_lobe["p50"].get<double>(), of_lobe["p90"].get<double>());
  }
  fmt::print("floor: {:.2f} % of rows below it, {:.2f} % beyond epsilon of their own variation\n",
             100 * r["at_floor_share"].get<double>(), 100 * r["at_floor_above_epsilon_share"].get<double>());
  fmt::print("in a cache {:.0f} bytes a row\n", r["cache_row_bytes"].get<double>());
  fmt::print("components {}; a row: g {:.1f} (top-up {:.2f}), refits {:.2f}, bytes {:.0f}, learning {:.0f} us\n",
             r["components"].dump(), r["g_evaluations_a_row"].get<double>(), r["top_ups_a_row"].get<double>(),
             r["refits_a_row"].get<double>(), r["bytes_a_row"].get<double>(), r["learning_cpu_us_a_row"].get<double>());
}

/// The same rows by knots, which are made of g alone. bytes_a_row: of a row in a table that keeps its knots.
nlohmann::json study_of_knots(const Setting& setting) {
  const auto target = fiber::make_elliptical_target();
  bench::RandomRows random(setting.seed, setting.domain, setting.trt == "split");
  bench::KnotFitter fitter{setting.epsilon};
  std::vector<double> errors, slack;
  std::map<std::size_t, int> knots;
  double bytes = 0;
  int falsely = 0, below_a_tenth = 0;
  for (int i = 0; i < setting.rows; ++i) {
    const bench::RandomRows::Row drawn = random.next(*target);
    const adaptive::TracedNodes nodes(drawn.rays, drawn.description.blur_rad);
    const bench::KnotRow row = fitter.fit(nodes);
    if (!row.converged) continue;
    const double error = bench::true_objective(row.table, nodes);
    errors.push_back(error);
    slack.push_back(row.objective / std::max(error, 1e-12));
    falsely += error > setting.epsilon ? 1 : 0;
    below_a_tenth += error < 0.1 ? 1 : 0;
    ++knots[row.table.knots().size()];
    bytes += static_cast<double>(sizeof(adaptive::KnotDensity) + row.table.bytes());
  }
  const auto n = static_cast<double>(setting.rows);
  return {{"domain", setting.domain},
          {"learner", setting.learner->name},
          {"trt", setting.trt},
          {"epsilon", setting.epsilon},
          {"rows", setting.rows},
          {"seed", setting.seed},
          {"converged_share", static_cast<double>(errors.size()) / n},
          {"below_a_tenth_share", below_a_tenth / n},
          {"refused", setting.rows - static_cast<int>(errors.size())},
          {"false", falsely},
          {"relative_l2", bench::spread(errors)},
          {"relative_l2_of_all", bench::spread(errors)},
          {"bound_over_error_p50", bench::quantile(slack, .5)},
          {"knots", {knots[32], knots[64], knots[128]}},
          {"g_evaluations_a_row", static_cast<double>(fitter.g_evaluations) / n},
          {"bytes_a_row", bytes / n},
          {"learning_cpu_us_a_row", 1e6 * fitter.cpu_seconds / n}};
}

void print_knots(const nlohmann::json& r) {
  const nlohmann::json& error = r["relative_l2"];
  fmt::print(
      "{} {} epsilon {}: {} rows, seed {}\nrelative squared L2: median {:.2g}, 90 % {:.2g}, 99 % {:.2g}, {:.2g}\n",
      r["learner"].get<std::string>(), r["domain"].get<std::string>(), r["epsilon"].get<double>(), r["rows"].get<int>(),
      r["seed"].get<int>(), error["p50"].get<double>(), error["p90"].get<double>(), error["p99"].get<double>(),
      error["max"].get<double>());
  fmt::print("converged {:.2f} %, refused {}, false {}; rows of 32, 64, 128 knots {}\n",
             100 * r["converged_share"].get<double>(), r["refused"].get<int>(), r["false"].get<int>(),
             r["knots"].dump());
  fmt::print("a row: g {:.1f}, bytes {:.0f}, fit {:.0f} us\n", r["g_evaluations_a_row"].get<double>(),
             r["bytes_a_row"].get<double>(), r["learning_cpu_us_a_row"].get<double>());
}

int usage() {
  fmt::print(stderr,
             "usage: bench_rows [--rows N] [--seed N] [--epsilon E] [--domain wide|hard|narrow] [--vertices N]\n"
             "                  [--foreign N] [--passes N] [--sigma-a S] [--trt whole|split]\n"
             "                  [--learner NAME] [--components N] [--tests N] [--json FILE]\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  Setting setting;
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    if (i + 1 >= argc) return usage();
    const std::string value = argv[i + 1];
    const double number = std::atof(value.c_str());
    if (name == "--rows")
      setting.rows = static_cast<int>(number);
    else if (name == "--seed")
      setting.seed = static_cast<std::uint64_t>(number);
    else if (name == "--epsilon")
      setting.epsilon = number;
    else if (name == "--domain")
      setting.domain = value;
    else if (name == "--vertices")
      setting.vertices = static_cast<int>(number);
    else if (name == "--foreign")
      setting.foreign = static_cast<int>(number);
    else if (name == "--passes")
      setting.passes = static_cast<int>(number);
    else if (name == "--sigma-a")
      setting.sigma_a = number;
    else if (name == "--trt")
      setting.trt = value;
    else if (name == "--learner") {
      const adaptive::Learner* learner = bench::find_row_learner(value);
      if (!learner) return usage();
      setting.learner = learner;
    } else if (name == "--components")
      setting.components = static_cast<std::uint32_t>(number);
    else if (name == "--tests")
      setting.tests = static_cast<std::uint32_t>(number);
    else if (name == "--json")
      setting.json = value;
    else
      return usage();
  }
  const bool known = setting.domain == "wide" || setting.domain == "hard" || setting.domain == "narrow";
  const bool known_trt = setting.trt == "whole" || setting.trt == "split";
  if (!known || !known_trt || setting.rows < 1 || !(setting.epsilon > 0) || setting.vertices < 1 ||
      setting.components < 1 || setting.components > adaptive::Mixture::max_components)
    return usage();
  const bool by_knots = setting.learner == &bench::knot_learner;
  const nlohmann::json result = by_knots ? study_of_knots(setting) : study(setting);
  if (by_knots)
    print_knots(result);
  else
    print(result);
  return setting.json.empty() ? 0 : bench::write_results(setting.json, result.dump(2) + "\n");
}
