// Asks models at the corners of everything and counts what comes back wrong: study 1 of the atlas.
//
// A case is a model under an estimator, with the rows it meets in a given state. Every fiber of the seed is asked by
// events: one sample, the same direction again, that direction through the world and back as light sampling has it,
// and five directions at corners; nine queries with begin() left out. Every second block of events flushes denormals
// to zero. JSON on stdout (by_fiber: e, sigma of TRT in degrees, queries, bad ones); every bad query, up to --print of
// a kind, with its whole state on stderr, from which
//   bench_atlas_queries --case NAME --replay FIBER,BLOCK,EVENT
// asks it again. Deterministic by seed, whatever the threads.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/denormals.h"
#include "fiber/energy_table.h"
#include "models/adversarial_points.h"
#include "models/adversarial_queries.h"

namespace tress {
namespace {

using fiber::Estimator;
using test::AdversarialEvent;
using test::AdversarialFiber;
using test::Failure;
using test::Taught;

struct Case : test::Asked {
  std::string name;
  double share = 1e-3;  ///< of the queries asked in all
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const char* model : {"elliptical", "pekelis2015", "pekelis2015-printed"}) {
    const bool ours = std::string_view(model) == "elliptical";
    const double of = ours ? 1 : 0.02;
    const auto add = [&](const std::string& what, Estimator estimator, Taught taught, double share) {
      cases.push_back({{model, estimator, taught, 0}, std::string(model) + " " + what, share});
    };
    add("fitted", Estimator::fitted, Taught::converged, 0.88 * of);
    add("fitted, open rows", Estimator::fitted, Taught::open, 0.001 * of);
    add("fitted, no rows", Estimator::fitted, Taught::no_rows, 0.001 * of);
    if (ours) add("corrected", Estimator::corrected, Taught::converged, 0.015);
    add("exact", Estimator::exact, Taught::nothing, ours ? 0.0008 : 0.01);
  }
  cases.push_back({{"rough", Estimator::fitted, Taught::converged, 0}, "rough fitted", 0.05});
  cases.push_back({{"rough", Estimator::exact, Taught::nothing, 0}, "rough exact", 0.001});
  for (const char* model : {"chiang2016", "marschner2003", "ou2012", "deon2022", "fiber3d"})
    cases.push_back({{model, Estimator::exact, Taught::nothing, 0}, model, 0.01});
  for (const int points : {10, 35, 100}) {
    cases.push_back({{"deon2011", Estimator::exact, Taught::nothing, points},
                     "deon2011, " + std::to_string(points) + " points",
                     0.1 / points});
  }
  return cases;
}

struct Settings {
  std::string only;
  std::uint64_t seed = 1;
  std::uint32_t fibers = 128;
  std::int64_t queries = 1000000;  ///< of ours, in all its cases
  int print = 3;
  std::vector<std::uint32_t> replay;
};

constexpr std::int64_t events_per_block = 512;

constexpr std::size_t kinds = test::failure_kinds;
using Counts = std::array<std::uint64_t, kinds>;

constexpr std::size_t bins = 9;  ///< of |theta_r|: every 10 degrees, and within half a degree of the pole

std::size_t bin_of_inclination(float theta_r) {
  const float at = std::abs(theta_r) / test::degrees;
  return at >= 89.5f ? bins : static_cast<std::size_t>(std::min(at / 10, 8.0f));
}

struct Example {
  std::size_t kind = 0;
  std::uint32_t fiber = 0, block = 0, event = 0;
  std::string state;
};

/// What one block of events found. Blocks are added in their order.
struct Found {
  std::uint64_t events = 0, queries = 0;
  Counts bad{};
  std::array<Counts, bins + 1> by_theta{};
  std::array<std::uint64_t, bins + 1> events_by_theta{};
  double largest_weight = 0, largest_of_r = 0;
  std::vector<Example> examples;

  void add(const Found& other, int most) {
    events += other.events;
    queries += other.queries;
    for (std::size_t k = 0; k < kinds; ++k) bad[k] += other.bad[k];
    for (std::size_t b = 0; b <= bins; ++b) {
      events_by_theta[b] += other.events_by_theta[b];
      for (std::size_t k = 0; k < kinds; ++k) by_theta[b][k] += other.by_theta[b][k];
    }
    largest_weight = std::max(largest_weight, other.largest_weight);
    largest_of_r = std::max(largest_of_r, other.largest_of_r);
    for (const Example& example : other.examples) {
      const auto same =
          std::count_if(examples.begin(), examples.end(), [&](const Example& e) { return e.kind == example.kind; });
      if (same < most) examples.push_back(example);
    }
  }
};

double number(float x) { return static_cast<double>(x); }

std::string text_of(const fiber::FiberParameters& p) {
  std::string text = fmt::format("eta {:.9g} e {:.9g} alpha {:.9g} tilt {:.9g} sigma_a {:.9g} {:.9g} {:.9g} sigma",
                                 p.eta, p.eccentricity, p.roughness, p.tilt, p.sigma_a.x, p.sigma_a.y, p.sigma_a.z);
  for (const float sigma : fiber::azimuthal_sigmas(p)) text += fmt::format(" {:.9g}", sigma);
  text += " lambda";
  for (int k = 0; k < 4; ++k) text += fmt::format(" {:.9g}", fiber::longitudinal_lambda(p, k, 0));
  text += fmt::format(" shape {} fresnel {}{} gain", static_cast<int>(p.longitudinal_shape),
                      static_cast<int>(p.reflection_fresnel), p.split_glint ? " glint" : "");
  for (const glm::vec3& gain : p.gain) text += fmt::format(" ({:g} {:g} {:g})", gain.x, gain.y, gain.z);
  return text;
}

std::string text_of(const AdversarialEvent& event, const fiber::FiberDirection& wi, const fiber::FiberValue& value) {
  std::string text = fmt::format(
      "theta_r {:.9g} phi_r {:.9g} xi {:.9g} {:.9g} h {:.9g} u {:.9g} {:.9g} {:.9g} {:.9g} theta_i {:.9g} phi_i {:.9g} "
      "pdf {:.9g} S",
      event.wr.theta, event.wr.phi, event.xi1, event.xi2, event.h, event.u[0], event.u[1], event.u[2], event.u[3],
      wi.theta, wi.phi, value.pdf);
  for (const glm::vec3& s : value.s) text += fmt::format(" ({:.5g} {:.5g} {:.5g})", s.x, s.y, s.z);
  return text;
}

Found ask(const Settings& settings, const test::TaughtModel& taught, const AdversarialFiber& fiber, std::uint32_t f,
          std::uint32_t block, std::int64_t events) {
  Found found;
  std::unique_ptr<FlushDenormals> flush;
  if (block % 2 == 1) flush = std::make_unique<FlushDenormals>();
  test::AdversarialQueries queries(taught, fiber, f);
  for (std::uint32_t e = 0; e < static_cast<std::uint32_t>(events); ++e) {
    const bool shown = !settings.replay.empty() && e == settings.replay[2];
    std::size_t bin = 0;
    queries.ask(RandomStream{settings.seed, (std::uint64_t{f} << 32) | block, e},
                [&](const AdversarialEvent& event, const fiber::FiberDirection& wi, const fiber::FiberValue& value,
                    const std::vector<Failure>& failures) {
                  if (shown) std::printf("%s\n", text_of(event, wi, value).c_str());
                  bin = bin_of_inclination(event.wr.theta);
                  ++found.queries;
                  for (const Failure failure : failures) {
                    const auto kind = static_cast<std::size_t>(failure);
                    ++found.by_theta[bin][kind];
                    if (shown) std::printf("  %s\n", test::failure_names[kind]);
                    if (found.bad[kind]++ < static_cast<std::uint64_t>(settings.print))
                      found.examples.push_back({kind, f, block, e, text_of(event, wi, value)});
                  }
                });
    ++found.events;
    ++found.events_by_theta[bin];
  }
  found.largest_weight = queries.checks().largest_weight;
  found.largest_of_r = queries.checks().largest_of_r;
  return found;
}

nlohmann::ordered_json counts_json(const Counts& counts) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (std::size_t k = 0; k < kinds; ++k) {
    if (counts[k] > 0) json[test::failure_names[k]] = counts[k];
  }
  return json;
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

nlohmann::ordered_json run_case(const Case& what, const Settings& settings) {
  const double queries = static_cast<double>(settings.queries) * what.share;
  const auto events = static_cast<std::int64_t>(std::ceil(queries / settings.fibers / test::queries_per_event));
  Found all;
  nlohmann::ordered_json by_fiber = nlohmann::ordered_json::array();
  double asking = 0;
  const double start = cpu_seconds();
  std::vector<AdversarialFiber> fibers;
  for (std::uint32_t f = 0; f < settings.fibers; ++f) fibers.push_back(test::adversarial_fiber(settings.seed, f));
  const test::TaughtModel subject(what, fibers);
  for (std::uint32_t f = 0; f < settings.fibers; ++f) {
    if (!settings.replay.empty() && f != settings.replay[0]) continue;
    const AdversarialFiber& fiber = fibers[f];
    // Narrow blurs are traced at every query of ours.
    const bool slow = fiber.is_narrow && std::string_view(what.model) == "elliptical";
    const std::int64_t of_fiber =
        slow ? std::max<std::int64_t>(std::min<std::int64_t>(events, 16), events / 1000) : events;
    const auto blocks = static_cast<std::uint32_t>((of_fiber + events_per_block - 1) / events_per_block);
    std::vector<Found> found(blocks);
    const double before = cpu_seconds();
    tbb::parallel_for(std::uint32_t{0}, blocks, [&](std::uint32_t block) {
      if (!settings.replay.empty() && block != settings.replay[1]) return;
      const std::int64_t first = std::int64_t{block} * events_per_block;
      found[block] = ask(settings, subject, fiber, f, block, std::min(events_per_block, of_fiber - first));
    });
    asking += cpu_seconds() - before;
    Found of;
    for (const Found& block : found) of.add(block, settings.print);
    std::uint64_t bad = 0;
    for (const std::uint64_t count : of.bad) bad += count;
    const fiber::FiberParameters& made = fiber.parameters;
    by_fiber.push_back(
        {number(made.eccentricity), number(fiber::azimuthal_sigmas(made)[1] / test::degrees), of.queries, bad});
    all.add(of, settings.print);
  }
  nlohmann::ordered_json json{{"case", what.name},
                              {"model", what.model},
                              {"fibers", settings.fibers},
                              {"events", all.events},
                              {"queries", all.queries},
                              {"bad", counts_json(all.bad)},
                              {"largest_weight", all.largest_weight},
                              {"largest_weight_of_r", all.largest_of_r},
                              {"cpu_seconds", cpu_seconds() - start},
                              {"ns_per_query", all.queries > 0 ? 1e9 * asking / static_cast<double>(all.queries) : 0}};
  if (subject.rows > 0) json["rows"] = {{"all", subject.rows}, {"converged", subject.converged}};
  json["events_by_theta"] = all.events_by_theta;
  nlohmann::ordered_json by_theta = nlohmann::ordered_json::array();
  for (const Counts& counts : all.by_theta) by_theta.push_back(counts_json(counts));
  json["bad_by_theta"] = by_theta;
  json["by_fiber"] = by_fiber;
  nlohmann::ordered_json examples = nlohmann::ordered_json::array();
  for (const Example& example : all.examples) {
    const std::string place = fmt::format("{},{},{}", example.fiber, example.block, example.event);
    const std::string fiber = text_of(fibers[example.fiber].parameters);
    examples.push_back(
        {{"kind", test::failure_names[example.kind]}, {"replay", place}, {"fiber", fiber}, {"query", example.state}});
    std::fprintf(stderr, "%s: %s --replay %s\n  %s\n  %s\n", what.name.c_str(), test::failure_names[example.kind],
                 place.c_str(), fiber.c_str(), example.state.c_str());
  }
  json["examples"] = examples;
  const double made = cpu_seconds() - start - asking;
  json["setup_cpu_seconds"] = made;
  std::fprintf(stderr,
               "%-32s %11llu queries %7.0f ns  weight %.4g (R %.4g)  bad %s, made in %.1f s, converged %llu of %llu\n",
               what.name.c_str(), static_cast<unsigned long long>(all.queries), json["ns_per_query"].get<double>(),
               all.largest_weight, all.largest_of_r, json["bad"].dump().c_str(), made,
               static_cast<unsigned long long>(subject.converged), static_cast<unsigned long long>(subject.rows));
  return json;
}

int run(const Settings& settings) {
  nlohmann::ordered_json cases = nlohmann::ordered_json::array();
  for (const Case& what : all_cases()) {
    if (!settings.only.empty() && what.name.find(settings.only) == std::string::npos) continue;
    cases.push_back(run_case(what, settings));
  }
  if (cases.empty()) {
    std::fprintf(stderr, "--case %s: unknown\n", settings.only.c_str());
    return 2;
  }
  std::printf("%s\n", nlohmann::ordered_json{{"seed", settings.seed}, {"cases", cases}}.dump(1).c_str());
  return 0;
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Settings settings;
  CLI::App app("adversarial queries of every model and estimator, and what was wrong with the answers, as JSON");
  app.add_option("--case", settings.only, "only cases whose names contain this");
  app.add_option("--seed", settings.seed);
  app.add_option("--fibers", settings.fibers)->check(CLI::PositiveNumber);
  app.add_option("--queries", settings.queries, "of elliptical, all its cases together")->check(CLI::PositiveNumber);
  app.add_option("--print", settings.print, "examples of a kind")->check(CLI::NonNegativeNumber);
  app.add_option("--replay", settings.replay, "FIBER,BLOCK,EVENT of one case: asks those again and prints them")
      ->delimiter(',')
      ->expected(3);
  CLI11_PARSE(app, argc, argv);
  return tress::run(settings);
}
