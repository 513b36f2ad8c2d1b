// How the error of rows falls while they are learned: after each pass, what it has cost and how far the published fits
// of all rows are from their g. JSON on stdout.
//
//   bench_learning [--rows N] [--seed N] [--domain wide|hard|narrow|whole] [--learner NAME] [--epsilon E]
//                  [--vertices N] [--passes N]
//
// Rows of random_rows.h, asked --vertices look-ups a pass each until they converge, or for --passes. Per row and in sum
// from the start: `vertices` that a row which has not converged has been asked for; `own` azimuths scored, the mean;
// `g` evaluations of all kinds; `cpu_us` of publish(). Errors are relative squared L2 of every row's fit, converged or
// not, those without a fit 1.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "knot_rows.h"
#include "known_learner.h"
#include "learned_rows.h"
#include "random_rows.h"
#include "references/registry.h"

namespace {

using namespace tress;

constexpr double pi = std::numbers::pi;

struct Setting {
  int rows = 500, vertices = 8, passes = 96;
  std::string domain = "wide";
  adaptive::Options options;
};

/// g of one row at equal steps, so that a fit is compared with it again and again.
struct Truth {
  std::vector<float> g;
  double variation = 1;

  explicit Truth(const adaptive::TracedNodes& nodes) : variation(nodes.variation()) {
    const auto n = static_cast<int>(std::max(180.0, std::ceil(4 * pi / static_cast<double>(nodes.blur_rad()))));
    for (int i = 0; i < n; ++i) g.push_back(nodes.density(static_cast<float>(-pi + 2 * pi * i / n)));
  }
  template <class Fit>
  double error(const Fit& view) const {
    const double step = 2 * pi / static_cast<double>(g.size());
    double sum = 0;
    for (std::size_t i = 0; i < g.size(); ++i) {
      const double off =
          static_cast<double>(g[i] - view.density(static_cast<float>(-pi + step * static_cast<double>(i))));
      sum += off * off * step;
    }
    return sum / variation;
  }
};

/// One pass of knots, made of g.
nlohmann::json study_of_knots(const Setting& setting) {
  const auto target = fiber::make_elliptical_target();
  bench::RandomRows random(setting.options.seed, setting.domain, false);
  bench::KnotFitter fitter{setting.options.epsilon};
  std::vector<double> errors;
  int converged = 0, falsely = 0;
  for (int i = 0; i < setting.rows; ++i) {
    const bench::RandomRows::Row drawn = random.next(*target);
    const adaptive::TracedNodes nodes(drawn.rays, drawn.description.blur_rad);
    const bench::KnotRow row = fitter.fit(nodes);
    errors.push_back(row.converged ? Truth(nodes).error(row.table) : 1);
    converged += row.converged ? 1 : 0;
    falsely += row.converged && errors.back() > setting.options.epsilon ? 1 : 0;
  }
  const auto n = static_cast<double>(setting.rows);
  const nlohmann::json pass{{"vertices", setting.vertices},
                            {"own", 0},
                            {"g", static_cast<double>(fitter.g_evaluations) / n},
                            {"cpu_us", 1e6 * fitter.cpu_seconds / n},
                            {"converged", converged / n},
                            {"refused", (setting.rows - converged) / n},
                            {"error", bench::spread(errors)}};
  return {{"domain", setting.domain},
          {"learner", setting.options.learner->name},
          {"epsilon", setting.options.epsilon},
          {"rows", setting.rows},
          {"seed", setting.options.seed},
          {"vertices_a_pass", setting.vertices},
          {"passes", nlohmann::json::array({pass})},
          {"below_a_hundredth_share",
           static_cast<double>(std::ranges::count_if(errors, [](double e) { return e < 0.01; })) / n},
          {"false", falsely}};
}

nlohmann::json study(const Setting& setting) {
  if (setting.options.learner == &bench::knot_learner) return study_of_knots(setting);
  const auto target = fiber::make_elliptical_target();
  bench::RandomRows random(setting.options.seed, setting.domain, false);
  std::vector<adaptive::SliceDescription> slices;
  std::vector<Truth> truths;
  for (int i = 0; i < setting.rows; ++i) {
    const bench::RandomRows::Row row = random.next(*target);
    slices.push_back(row.description);
    truths.emplace_back(adaptive::TracedNodes(row.rays, row.description.blur_rad));
  }
  bench::LearnedRows rows(setting.options, *target, slices);
  const auto n = static_cast<double>(setting.rows);
  std::vector<double> errors(truths.size(), 1.0);
  double cpu = 0, g = 0;
  nlohmann::json passes = nlohmann::json::array();
  adaptive::PassReport report;
  for (int pass = 1; pass <= setting.passes; ++pass) {
    report = rows.pass(setting.vertices);
    cpu += report.learning_cpu_seconds;
    g += static_cast<double>(report.g_evaluations);
    const bool last = pass == setting.passes || report.rows_converged + report.rows_refused == slices.size();
    // Every pass at first, then a tenth apart.
    if (!last && pass > 12 && pass % std::max(1, pass / 10) != 0) continue;
    double own = 0;
    for (std::size_t i = 0; i < truths.size(); ++i) {
      own += static_cast<double>(rows.rows()[i].own);
      const adaptive::RowView view = rows.view(i);
      if (view.fit != nullptr) errors[i] = truths[i].error(view);
    }
    const nlohmann::json spread = bench::spread(errors);
    passes.push_back({{"vertices", pass * setting.vertices},
                      {"own", own / n},
                      {"g", g / n},
                      {"cpu_us", 1e6 * cpu / n},
                      {"converged", static_cast<double>(report.rows_converged) / n},
                      {"refused", static_cast<double>(report.rows_refused) / n},
                      {"error", spread}});
    if (last) break;
  }
  int falsely = 0, below_hundredth = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    below_hundredth += errors[i] < 0.01 ? 1 : 0;
    falsely += rows.rows()[i].state == adaptive::RowState::converged && errors[i] > setting.options.epsilon ? 1 : 0;
  }
  return {{"domain", setting.domain},
          {"learner", setting.options.learner->name},
          {"epsilon", setting.options.epsilon},
          {"rows", setting.rows},
          {"seed", setting.options.seed},
          {"vertices_a_pass", setting.vertices},
          {"passes", passes},
          {"below_a_hundredth_share", below_hundredth / n},
          {"false", falsely}};
}

}  // namespace

int main(int argc, char** argv) {
  Setting setting;
  setting.options.memory_bytes = std::size_t{4} << 30;
  setting.options.seed = 1;
  std::string learner = setting.options.learner->name;
  CLI::App app("how random rows are learned, pass by pass, as JSON");
  app.add_option("--rows", setting.rows)->check(CLI::PositiveNumber);
  app.add_option("--seed", setting.options.seed);
  app.add_option("--domain", setting.domain)->check(CLI::IsMember({"wide", "hard", "narrow", "whole"}));
  app.add_option("--learner", learner)->check(bench::known_row_learner);
  app.add_option("--epsilon", setting.options.epsilon)->check(CLI::PositiveNumber);
  app.add_option("--vertices", setting.vertices)->check(CLI::PositiveNumber);
  app.add_option("--passes", setting.passes)->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  setting.options.learner = bench::find_row_learner(learner);
  fmt::print("{}\n", study(setting).dump());
  return 0;
}
