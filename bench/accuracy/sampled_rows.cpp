// Rows of samples under stress: how many converge, and how many of them falsely, by many fresh paths each.
//
//   bench_sampled_rows [--family NAME ...] [--rows N] [--epsilon X] [--paths N] [--seed N] [--json FILE]
//
// Rows are learned by a service as a host asks it. Each that converged is compared with `paths` fresh paths: chi^2 of
// what is published, at the resolution of the test's cells, is what epsilon speaks of; it is false where it is above
// epsilon by more than twice its own error. Of targets whose density S is known chi^2 is taken without cells as well,
// by the mean of S/f over paths, and the share of the light that is misplaced: what no test of cells can see is in
// both.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "accuracy/random_rows.h"
#include "adaptive/listed_samples.h"
#include "fiber/rough_rows.h"
#include "fit/learn_stage.h"
#include "tress/adaptive/service.h"

namespace {

using namespace tress;
using adaptive::RowState;
using nlohmann::json;

const std::vector<std::string> families{"wide", "rare", "spike", "comb", "ring", "double", "heavy", "fiber"};

struct Setting {
  std::size_t rows = 200;
  double epsilon = adaptive::Options{}.sampled_epsilon;
  std::uint32_t paths = 1u << 17;
  std::uint64_t seed = 1;
};

/// The nodes of a family: slices of one node each.
struct Nodes {
  std::unique_ptr<adaptive::SampledTarget> target;
  const testing::ListedSamples* listed = nullptr;  ///< where the density is known
  std::vector<adaptive::SliceDescription> slices;
};

Nodes nodes_of(const std::string& family, const Setting& setting) {
  Nodes nodes;
  if (family != "fiber") {
    auto listed = std::make_unique<testing::ListedSamples>(testing::sampled_stress(family, setting.rows, setting.seed));
    for (std::size_t i = 0; i < setting.rows; ++i) nodes.slices.push_back(testing::ListedSamples::slice(i));
    nodes.listed = listed.get();
    nodes.target = std::move(listed);
    return nodes;
  }
  nodes.target = fiber::make_rough_target();
  for (std::size_t i = 0; i < setting.rows; ++i) {
    RandomStream random(setting.seed, i, 2);
    fiber::FiberParameters fiber;
    fiber.eccentricity = 0.5f + 0.5f * random.next();
    fiber.roughness = 0.04f * std::pow(10.0f, random.next());
    fiber.tilt = random.next() < 0.5f ? 0.0f : 0.05f;
    adaptive::SliceDescription slice = fiber::rough_slice(fiber);
    slice.axis_a = {slice.axis_a[static_cast<std::size_t>(random.next() * static_cast<float>(slice.axis_a.size()))]};
    slice.axis_b = {slice.axis_b[static_cast<std::size_t>(random.next() * static_cast<float>(slice.axis_b.size()))]};
    slice.coarse.clear();  // one node
    nodes.slices.push_back(slice);
  }
  return nodes;
}

/// How far a row is from a density that is known, without cells.
struct Whole {
  double chi2 = 0;       ///< integral (S - f)^2/f over all parts, over the mass
  double misplaced = 0;  ///< share of the light that is not where f has it: integral max(0, S - f), over the mass
};

Whole whole_error(const testing::ListedSamples& target, std::size_t i, const adaptive::RibbonRow& row,
                  std::uint32_t paths) {
  constexpr std::uint64_t fresh = std::uint64_t{1} << 60;
  std::vector<adaptive::Ribbon> ribbons;
  for (std::uint32_t p = 0; p < row.parts(); ++p) ribbons.push_back(row.ribbon(p));
  std::vector<adaptive::SampledExit> exits;
  target.draw(testing::ListedSamples::slice(i), 0, 0, fresh, 0, paths, exits);
  double of_square = 0, misplaced = 0, mass = 0;
  for (const adaptive::SampledExit& exit : exits) {
    const auto weight = static_cast<double>(exit.weight);
    const double f = static_cast<double>(row.mass(exit.part)) *
                     static_cast<double>(ribbons[exit.part].density(exit.azimuth, exit.height));
    const double s = target.density(i, exit.part, static_cast<double>(exit.azimuth), static_cast<double>(exit.height));
    // A place that the row leaves out altogether counts as a thousand times too little.
    of_square += weight * std::min(s / std::max(f, 1e-30), 1e3);
    misplaced += weight * std::max(0.0, 1 - f / s);
    mass += weight;
  }
  const double of_row = static_cast<double>(row.total_mass());
  return {((of_square - 2 * mass) / paths + of_row) / of_row, misplaced / mass};
}

json spread(const std::vector<double>& values) {
  return {{"p50", bench::quantile(values, 0.5)},
          {"p90", bench::quantile(values, 0.9)},
          {"p99", bench::quantile(values, 0.99)},
          {"max", bench::quantile(values, 1)}};
}

json study(const std::string& family, const Setting& setting) {
  const Nodes nodes = nodes_of(family, setting);
  adaptive::Options options;
  options.sampled_epsilon = setting.epsilon;
  options.queries_before_creation = 1;
  options.learns_to_epsilon = true;
  adaptive::Service service(options, *nodes.target);
  for (const adaptive::SliceDescription& slice : nodes.slices) service.look_up(*service.add_slice(slice), 0, 0);
  const adaptive::PassReport report = service.publish();

  struct Measured {
    adaptive::SampledTest cells;
    Whole whole;
  };
  std::vector<Measured> all(setting.rows);
  tbb::parallel_for(std::size_t{0}, setting.rows, [&](std::size_t i) {
    const adaptive::RowView view = service.peek(static_cast<adaptive::SliceId>(i), 0, 0);
    if (view.ribbons == nullptr) return;
    const adaptive::SliceDescription& slice = nodes.slices[i];
    all[i].cells = adaptive::test_samples(*nodes.target, slice, slice.axis_a[0], slice.axis_b[0], *view.ribbons,
                                          std::uint64_t{1} << 40, setting.paths);
    if (nodes.listed != nullptr) all[i].whole = whole_error(*nodes.listed, i, *view.ribbons, setting.paths / 4);
  });

  std::vector<double> cells, whole, misplaced, objectives;
  std::uint64_t falsely = 0, by_half = 0, finer = 0;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < setting.rows; ++i) {
    const adaptive::RowView view = service.peek(static_cast<adaptive::SliceId>(i), 0, 0);
    if (view.state != RowState::converged) continue;
    const double surely = all[i].cells.chi2 - 2 * all[i].cells.deviation;
    if (all[i].cells.chi2 > all[worst].cells.chi2) worst = i;
    cells.push_back(all[i].cells.chi2);
    objectives.push_back(static_cast<double>(view.objective));
    falsely += surely > setting.epsilon ? 1 : 0;
    by_half += surely > 1.5 * setting.epsilon ? 1 : 0;
    whole.push_back(all[i].whole.chi2);
    misplaced.push_back(all[i].whole.misplaced);
    finer += all[i].whole.chi2 > setting.epsilon ? 1 : 0;
  }
  json fields{{"family", family},
              {"epsilon", setting.epsilon},
              {"rows", setting.rows},
              {"converged", report.rows_converged},
              {"refused", report.rows_refused},
              {"false", falsely},
              {"false_by_half", by_half},
              {"chi2", spread(cells)},
              {"objective", spread(objectives)},
              {"paths_a_row", static_cast<double>(report.g_evaluations) / static_cast<double>(setting.rows)},
              {"cpu_ms_a_row", 1e3 * report.learning_cpu_seconds / static_cast<double>(setting.rows)}};
  const adaptive::SliceDescription& of_worst = nodes.slices[worst];
  fields["worst"] = {{"row", worst},
                     {"chi2", all[worst].cells.chi2},
                     {"deviation", all[worst].cells.deviation},
                     {"objective", service.peek(static_cast<adaptive::SliceId>(worst), 0, 0).objective},
                     {"parameters", of_worst.key.used_parameters()},
                     {"node", {of_worst.axis_a[0], of_worst.axis_b[0]}}};
  if (nodes.listed != nullptr) {
    fields["chi2_without_cells"] = spread(whole);
    fields["above_without_cells"] = finer;
    fields["misplaced"] = spread(misplaced);
  }
  return fields;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Rows of samples under stress, and how many converge falsely"};
  Setting setting;
  std::vector<std::string> wanted = families;
  std::string file;
  app.add_option("--family", wanted, "which")->check(CLI::IsMember(families));
  app.add_option("--rows", setting.rows, "of each family")->capture_default_str();
  app.add_option("--epsilon", setting.epsilon, "Options::sampled_epsilon")->capture_default_str();
  app.add_option("--paths", setting.paths, "fresh ones for each row")->capture_default_str();
  app.add_option("--seed", setting.seed, "of the rows")->capture_default_str();
  app.add_option("--json", file, "written as well");
  CLI11_PARSE(app, argc, argv);
  json cases = json::array();
  fmt::print("{:7} {:>6} {:>9} {:>7} {:>5} {:>5} {:>8} {:>7} {:>9} {:>7} {:>6} {:>9} {:>7} {:>6} {:>5}\n", "family",
             "rows", "converged", "refused", "false", "x1.5", "chi2 p50", "p99", "whole p50", "p99", "above",
             "moved p50", "p99", "paths", "ms");
  for (const std::string& family : wanted) {
    const json found = study(family, setting);
    cases.push_back(found);
    const auto of = [&](const char* name, const char* quantile) {
      return found.contains(name) ? found[name][quantile].get<double>() : NAN;
    };
    fmt::print("{:7} {:6} {:9} {:7} {:5} {:5} {:8.4f} {:7.4f} {:9.4f} {:7.4f} {:6} {:9.4f} {:7.4f} {:6.0f} {:5.1f}\n",
               family, setting.rows, found["converged"].get<int>(), found["refused"].get<int>(),
               found["false"].get<int>(), found["false_by_half"].get<int>(), of("chi2", "p50"), of("chi2", "p99"),
               of("chi2_without_cells", "p50"), of("chi2_without_cells", "p99"), found.value("above_without_cells", -1),
               of("misplaced", "p50"), of("misplaced", "p99"), found["paths_a_row"].get<double>(),
               found["cpu_ms_a_row"].get<double>());
    std::fflush(stdout);
  }
  if (file.empty()) return 0;
  std::ofstream out(file);
  out << json{{"paths", setting.paths}, {"seed", setting.seed}, {"cases", cases}}.dump(2) << "\n";
  return out ? 0 : 1;
}
