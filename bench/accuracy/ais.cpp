// The paper's adaptive importance sampling on the random rows of bench_rows, as a function of its settings: D, h, the
// alternating schemes of section 5.3, the step, the basis. Prints a line a setting; JSON with --json.
//
//   bench_ais [--rows N] [--seed N] [--domain wide|hard|narrow|paper] [--set core|factorial|variants|all]
//             [--only TEXT] [--json FILE]
//
// Domain paper: TRT of Marschner et al. on the grid of the paper's section 6, rows of mass 1e-3 and more, the curves as
// they are; errors by section 7.1 at 3601 azimuths, relative to N minus its mean, and beside it as printed.
// factorial: D 3, 5, 8 x h L2, relative entropy x no scheme, the first (sweeps), the second (weights), both.
// core: of these, no scheme and both.
// only: those whose name has this in it.
// variants: one thing changed at a time from D = 5, L2, both; and the paper's own choices put together.
// CPU time is the thread's; the load of the machine is not recorded: run it on a quiet one.
#include "references/learners/ais.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "random_rows.h"
#include "references/models/pekelis2015_target.h"
#include "results_file.h"

namespace {

using namespace tress;
using adaptive::AisSettings;

struct Named {
  std::string name;
  AisSettings settings;
};

void add_factorial(std::vector<Named>& list, const std::vector<int>& scheme_sets) {
  for (const int d : {3, 5, 8}) {
    for (const auto h : {adaptive::AisDistance::l2, adaptive::AisDistance::relative_entropy}) {
      for (const int schemes : scheme_sets) {
        AisSettings s;
        s.components = d;
        s.distance = h;
        s.sweep = schemes & 1 ? adaptive::AisSweep::alternate : adaptive::AisSweep::complete;
        s.weighting = schemes & 2 ? adaptive::AisWeighting::alternate : adaptive::AisWeighting::target;
        constexpr const char* scheme_names[]{"none", "sweeps", "weights", "both"};
        list.push_back(
            {fmt::format("D {} {} {}", d, h == adaptive::AisDistance::l2 ? "l2" : "entropy", scheme_names[schemes]),
             s});
      }
    }
  }
}

void add_variants(std::vector<Named>& list) {
  const auto add = [&](const char* name, auto change) {
    AisSettings s;
    change(s);
    list.push_back({name, s});
  };
  // The paper's choices wherever it says them, and none of ours: monomials are left out, scales end at 0.5 as B here.
  const auto as_paper = [](AisSettings& s) {
    s.basis = adaptive::AisBasis::line;
    s.uniform_part = false;
    s.uniform_share = 0;
    s.revive = false;
    s.keep_energy = false;
    s.start = adaptive::AisStart::spread;
  };
  add("threshold .01", [](AisSettings& s) { s.threshold = 0.01; });
  add("threshold .0025", [](AisSettings& s) { s.threshold = 0.0025; });
  add("gradient", [](AisSettings& s) { s.step = adaptive::AisStep::gradient; });
  add("1 step", [](AisSettings& s) { s.steps = 1; });
  add("40 steps", [](AisSettings& s) { s.steps = 40; });
  add("sequential sweeps", [](AisSettings& s) { s.sweep = adaptive::AisSweep::sequential; });
  add("weights of f", [](AisSettings& s) { s.weighting = adaptive::AisWeighting::proposal; });
  add("weights 1/q (plain L2)", [](AisSettings& s) { s.weighting = adaptive::AisWeighting::uniform; });
  add("64 samples", [](AisSettings& s) { s.samples = 64; });
  add("128 samples", [](AisSettings& s) { s.samples = 128; });
  add("512 samples", [](AisSettings& s) { s.samples = 512; });
  add("start spread", [](AisSettings& s) { s.start = adaptive::AisStart::spread; });
  add("no revival", [](AisSettings& s) { s.revive = false; });
  add("no uniform part", [](AisSettings& s) { s.uniform_part = false; });
  add("no uniform share", [](AisSettings& s) { s.uniform_share = 0; });
  add("energy free", [](AisSettings& s) { s.keep_energy = false; });
  add("stop mended", [](AisSettings& s) { s.stop = adaptive::AisStop::mended; });
  add("stop none", [](AisSettings& s) { s.stop = adaptive::AisStop::none; });
  add("line, tau 10", [](AisSettings& s) { s.basis = adaptive::AisBasis::line; });
  add("line, tau 0", [](AisSettings& s) { s.basis = adaptive::AisBasis::line, s.periodicity = 0; });
  add("as paper, newton", as_paper);
  add("as paper, gradient", [&](AisSettings& s) { as_paper(s), s.step = adaptive::AisStep::gradient; });
  add("as paper, newton, no scheme", [&](AisSettings& s) {
    as_paper(s);
    s.sweep = adaptive::AisSweep::complete;
    s.weighting = adaptive::AisWeighting::target;
  });
}

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Row {
  adaptive::AisTarget target;
  std::function<double(const adaptive::Mixture&)> error;
  double printed_over_meant = 1;  ///< the printed divisor of section 7.1 over the meant one
};

std::vector<Row> elliptical_rows(int count, std::uint64_t seed, const std::string& domain) {
  const auto target = fiber::make_elliptical_target();
  bench::RandomRows random(seed, domain, false);
  std::vector<Row> rows;
  for (int i = 0; i < count; ++i) {
    const bench::RandomRows::Row row = random.next(*target);
    const auto nodes = std::make_shared<adaptive::TracedNodes>(row.rays, row.description.blur_rad);
    rows.push_back(
        {{[nodes](float x) { return static_cast<double>(nodes->density(x)); }, nodes->energy(), nodes->variation()},
         [nodes](const adaptive::Mixture& fit) { return bench::true_objective(fit, *nodes); }});
  }
  return rows;
}

std::vector<Row> paper_rows(int count, std::uint64_t seed) {
  constexpr int azimuths = 3601;
  constexpr double pi = std::numbers::pi, step = 2 * pi / (azimuths - 1);
  RandomStream random(seed, 25572);
  const auto one_of = [&](std::size_t n) { return static_cast<std::size_t>(random.next() * static_cast<float>(n)); };
  std::vector<Row> rows;
  while (rows.size() < static_cast<std::size_t>(count)) {
    // e = 1 needs one phi_r: 25,572 = 4 (3 46^2 + 45).
    const bool circular = random.next() * 25572 < 4 * 45;
    const float e = circular ? 1.0f : 0.85f + 0.05f * static_cast<float>(one_of(3));
    const auto sigma = static_cast<float>((10.0 + 5.0 * static_cast<double>(one_of(4))) * pi / 180);
    const adaptive::SliceDescription slice = fiber::pekelis_slice(fiber::MarschnerLobe::trt, 1.55f, e, sigma);
    const double a = slice.axis_a[one_of(slice.axis_a.size())], b = slice.axis_b[one_of(slice.axis_b.size())];
    const auto curve = [=](float x) { return fiber::pekelis_curve(slice.key, a, b, static_cast<double>(x)); };
    std::vector<double> values;
    double mass = 0, meant = 0, printed = 0;
    for (int i = 0; i + 1 < azimuths; ++i) {
      values.push_back(curve(static_cast<float>(-pi + i * step)));
      mass += values.back() * step;
    }
    for (const double n : values) {
      meant += std::pow(n - mass / (2 * pi), 2) * step;
      printed += std::pow(n - mass, 2) * step;
    }
    if (mass < 1e-3) continue;
    meant = std::max(meant, 1e-3 / (2 * pi));
    const auto error = [=](const adaptive::Mixture& fit) {
      double sum = 0;
      for (int i = 0; i + 1 < azimuths; ++i) {
        const double f = fit.density(static_cast<float>(-pi + i * step));
        sum += std::pow(values[static_cast<std::size_t>(i)] - f, 2) * step;
      }
      return sum / meant;
    };
    rows.push_back({{curve, mass, meant}, error, printed / meant});
  }
  return rows;
}

nlohmann::json measure(const std::vector<Row>& rows, const Named& named, std::uint64_t seed) {
  std::vector<double> errors, cpu, g;
  double below_tenth = 0, below_printed = 0, below_hundredth = 0, iterations = 0, estimate = 0;
  std::vector<int> ends(4);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double start = cpu_seconds();
    const adaptive::AisFit fit = adaptive::fit_ais(rows[i].target, RandomStream(seed, i), named.settings);
    cpu.push_back(1e3 * (cpu_seconds() - start));
    g.push_back(static_cast<double>(fit.g_evaluations));
    errors.push_back(rows[i].error(fit.mixture));
    below_printed += errors.back() / rows[i].printed_over_meant < 0.1 ? 1 : 0;
    below_tenth += errors.back() < 0.1 ? 1 : 0;
    below_hundredth += errors.back() < 0.01 ? 1 : 0;
    iterations += fit.iterations;
    estimate += fit.objective;
    ++ends[static_cast<std::size_t>(fit.end)];
  }
  const auto n = static_cast<double>(rows.size());
  const auto mean = [&](const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / n;
  };
  nlohmann::json result{{"settings", named.name},
                        {"relative_l2", bench::spread(errors)},
                        {"relative_l2_mean", mean(errors)},
                        {"own_estimate_mean", estimate / n},
                        {"below_a_tenth_share", below_tenth / n},
                        {"below_a_tenth_as_printed_share", below_printed / n},
                        {"below_a_hundredth_share", below_hundredth / n},
                        {"cpu_ms", bench::spread(cpu)},
                        {"cpu_ms_mean", mean(cpu)},
                        {"g_evaluations_a_row", mean(g)},
                        {"iterations_a_row", iterations / n},
                        {"reached", ends[0]},
                        {"stopped", ends[1]},
                        {"exhausted", ends[2]},
                        {"refused", ends[3]}};
  fmt::print("{:<28} {:8.1e} {:8.1e} {:8.1e} {:8.1e}  {:5.1f} {:5.1f} %  {:6.1f} ms {:7.0f} g {:5.1f} it\n", named.name,
             bench::quantile(errors, .5), bench::quantile(errors, .9), bench::quantile(errors, .99),
             bench::quantile(errors, 1), 100 * below_tenth / n, 100 * below_hundredth / n, mean(cpu), mean(g),
             iterations / n);
  std::fflush(stdout);
  return result;
}

int usage() {
  fmt::print(stderr,
             "usage: bench_ais [--rows N] [--seed N] [--domain wide|hard|narrow|paper]\n"
             "                 [--set core|factorial|variants|all] [--only TEXT] [--json FILE]\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  int count = 1000;
  std::uint64_t seed = 1;
  std::string domain = "wide", set = "factorial", only, json;
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    if (i + 1 >= argc) return usage();
    const std::string value = argv[i + 1];
    if (name == "--rows")
      count = std::atoi(value.c_str());
    else if (name == "--seed")
      seed = static_cast<std::uint64_t>(std::atoll(value.c_str()));
    else if (name == "--domain")
      domain = value;
    else if (name == "--set")
      set = value;
    else if (name == "--only")
      only = value;
    else if (name == "--json")
      json = value;
    else
      return usage();
  }
  if (count < 1 || (domain != "wide" && domain != "hard" && domain != "narrow" && domain != "paper")) return usage();
  std::vector<Named> list;
  if (set == "core") add_factorial(list, {0, 3});
  if (set == "factorial" || set == "all") add_factorial(list, {0, 1, 2, 3});
  if (set == "variants" || set == "all") add_variants(list);
  std::erase_if(list, [&](const Named& named) { return named.name.find(only) == std::string::npos; });
  if (list.empty()) return usage();

  const std::vector<Row> rows = domain == "paper" ? paper_rows(count, seed) : elliptical_rows(count, seed, domain);
  fmt::print("{}: {} rows, seed {}; error median, 90, 99 %, max; below .1, .01; a row, mean\n", domain, count, seed);
  nlohmann::json result{{"domain", domain}, {"rows", count}, {"seed", seed}, {"settings", nlohmann::json::array()}};
  for (const Named& named : list) {
    result["settings"].push_back(measure(rows, named, seed));
    // Anew after each, so that a run that is stopped has written what it knew.
    if (!json.empty() && bench::write_results(json, result.dump(1) + "\n") != 0) return 1;
  }
  return 0;
}
