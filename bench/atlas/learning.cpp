// Learning under stress: the same rows of one stress by every learner, through the public service as a host asks it.
// How many converge, how many of them falsely (their true error is above epsilon), how far the fits are off, what they
// cost, and whether anything that is published leaves the constraints. JSON on stdout; exit 3 where something did.
//
//   bench_atlas_learning [--stress NAME ...] [--learner NAME ...] [--rows N] [--rival-rows N] [--seed N] [--list]
//
// A row is created at its first touch and then asked 16 vertices a pass for 64 passes, until it converges or is
// refused, unless its stress says otherwise. Errors are relative squared L2 against g of the row, a sixth of the blur
// apart and no further apart than a component is wide.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "accuracy/known_learner.h"
#include "accuracy/random_rows.h"
#include "references/registry.h"
#include "stress_targets.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace {

using namespace tress;
using adaptive::Learner;
using adaptive::RowState;

constexpr double pi = std::numbers::pi;

/// Where the azimuths of a row come from.
enum class Host {
  own,        ///< its own proposal, scored
  absorbed,   ///< likewise, each component of it a factor 1 to e^-12 weaker: of dark hair
  uniform,    ///< of light sampling: observed, not scored
  clustered,  ///< likewise, all within 0.05 rad of one azimuth of the row's
  one_sided,  ///< likewise, all in [0, pi)
  beside,     ///< own, each with four clustered ones
};

struct Stress {
  const char* name;
  const char* family;
  double epsilon = 0.01;
  Host host = Host::own;
  int samples = 0;  ///< in all; 0: 16 a pass for 64 passes
  int threads = 1;
  double bytes_a_row = 0;  ///< ceiling; 0: 4 GB
};

constexpr std::array stresses{
    Stress{"wide", "wide"},
    Stress{"hard", "hard"},
    Stress{"1 sample", "wide", 0.01, Host::own, 1},
    Stress{"8 samples", "wide", 0.01, Host::own, 8},
    Stress{"32 samples", "wide", 0.01, Host::own, 32},
    Stress{"128 samples", "wide", 0.01, Host::own, 128},
    Stress{"light only, iid", "wide", 0.01, Host::uniform},
    Stress{"light only, clustered", "wide", 0.01, Host::clustered},
    Stress{"light only, one-sided", "wide", 0.01, Host::one_sided},
    Stress{"own and clustered light", "hard", 0.01, Host::beside},
    Stress{"heavy-tailed weights", "hard", 0.01, Host::absorbed},
    Stress{"sigma 1 degree", "degree"},
    Stress{"TIR edges", "tir"},
    Stress{"flat", "flat"},
    Stress{"zero and next to it", "zero"},
    Stress{"spike", "spike"},
    Stress{"comb of spikes", "comb"},
    Stress{"spike in a flat row", "hidden"},
    Stress{"in phase with the gap fill", "phase"},
    Stress{"in phase, blur 0.6 degrees", "fine phase"},
    Stress{"spike in a flat row, 1e-3", "hidden", 1e-3},
    Stress{"two spikes in a flat row, 1e-3", "two hidden", 1e-3},
    Stress{"spike beside a spike", "neighbours"},
    Stress{"spike beside a spike, 1e-3", "neighbours", 1e-3},
    Stress{"epsilon 1e-1", "wide", 1e-1},
    Stress{"epsilon 1e-1, hard", "hard", 1e-1},
    Stress{"epsilon 1e-3", "wide", 1e-3},
    Stress{"epsilon 1e-3, hard", "hard", 1e-3},
    Stress{"epsilon 1e-4", "wide", 1e-4},
    Stress{"epsilon 1e-5", "wide", 1e-5},
    Stress{"epsilon 1e-6", "wide", 1e-6},
    Stress{"table at its ceiling", "wide", 0.01, Host::own, 0, 1, 80},
    Stress{"all threads on a row", "wide", 0.01, Host::own, 0, 8},
};

/// g of one row at equal steps, so that every learner's fit is compared with it.
class Truth {
 public:
  Truth(const bench::ListedTarget& target, std::size_t row) : target_(&target), row_(row) {
    const adaptive::TracedNodes nodes = target.nodes(row);
    variation_ = static_cast<double>(nodes.variation());
    energy_ = static_cast<double>(nodes.energy());
    blur_ = static_cast<double>(nodes.blur_rad());
    g_ = sampled(nodes, std::max(360.0, std::ceil(12 * pi / blur_)));
  }

  double error(const adaptive::RowView& view) const {
    double narrowest = 1;  // where a fit is narrower than the steps
    if (view.fit != nullptr) {
      for (const adaptive::Component& part : adaptive::Mixture(*view.fit).parts()) {
        narrowest = std::min<double>(narrowest, std::min(part.shape.s_left, part.shape.s_right));
      }
    }
    const double steps = 2 * pi / narrowest;
    if (!(steps > static_cast<double>(g_.size()))) return compare(g_, view);
    return compare(sampled(target_->nodes(row_), std::ceil(std::min(2 * steps, 1e5))), view);
  }
  double energy() const { return energy_; }

 private:
  static std::vector<float> sampled(const adaptive::TracedNodes& nodes, double points) {
    std::vector<float> g(static_cast<std::size_t>(points));
    for (std::size_t i = 0; i < g.size(); ++i) g[i] = nodes.density(azimuth(i, g.size()));
    return g;
  }
  static float azimuth(std::size_t i, std::size_t points) {
    return static_cast<float>(2 * pi * (static_cast<double>(i) / static_cast<double>(points) - 0.5));
  }
  double compare(const std::vector<float>& g, const adaptive::RowView& view) const {
    double sum = 0;
    for (std::size_t i = 0; i < g.size(); ++i) {
      const double off = static_cast<double>(g[i]) - static_cast<double>(view.density(azimuth(i, g.size())));
      sum += off * off;
    }
    return sum * 2 * pi / static_cast<double>(g.size()) / variation_;
  }

  const bench::ListedTarget* target_;
  std::size_t row_;
  std::vector<float> g_;
  double variation_ = 1, energy_ = 0, blur_ = 1;
};

/// Whether what is published of a row is a fit at all: weights >= 0, scales in bounds, D, mass, everything finite.
bool within_constraints(const adaptive::RowView& view, double energy, std::uint32_t most_components) {
  if (!std::isfinite(view.objective) || view.objective < 0) return false;
  double mass = 0;
  if (view.fit != nullptr) {
    const adaptive::Mixture fit = *view.fit;
    if (fit.component_count > most_components || !(fit.uniform_weight >= 0)) return false;
    for (const adaptive::Component& part : fit.parts()) {
      for (const float s : {part.shape.s_left, part.shape.s_right}) {
        if (!(s >= 0.004f && s <= 0.5f)) return false;
      }
      if (!(part.weight >= 0) || !(std::abs(part.shape.mu) <= std::numbers::pi_v<float>)) return false;
    }
    mass = static_cast<double>(fit.energy());
  } else {
    return true;
  }
  return std::isfinite(mass) && std::abs(mass - energy) <= 1e-5 * energy + 1e-30;
}

struct Row {
  adaptive::SliceId slice = 0;
  RowState state = RowState::absent;
};

class Asked {
 public:
  Asked(const Stress& stress, std::uint64_t seed) : stress_(stress), seed_(seed) {}

  /// `vertices` of every open row, dealt out to the threads one by one, so that all of them are at a row at once.
  void pass(const adaptive::Service& service, const std::vector<Row>& rows, int number, int vertices,
            int threads) const {
    std::vector<std::thread> workers;
    const auto work = [&](int first) {
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (rows[i].state == RowState::converged) continue;
        for (int k = first; k < vertices; k += threads) vertex(service, rows[i].slice, i, number, k);
      }
    };
    for (int w = 1; w < threads; ++w) workers.emplace_back(work, w);
    work(0);
    for (std::thread& worker : workers) worker.join();
  }

 private:
  void vertex(const adaptive::Service& service, adaptive::SliceId slice, std::size_t i, int number, int k) const {
    RandomStream random(seed_ + static_cast<std::uint64_t>(k), i, static_cast<std::uint64_t>(number) + 1);
    const adaptive::RowView view = service.look_up(slice, 0, 0);
    if (view.state != RowState::open) return;
    const float share = service.options().uniform_share_open;
    const auto observe = [&](float x) { service.observe(view, x, view.nodes->density(x)); };
    RandomStream of_row(seed_, i);
    const float centre = 6.28f * of_row.next();
    switch (stress_.host) {
      case Host::uniform:
        return observe(static_cast<float>(2 * pi) * (random.next() - 0.5f));
      case Host::clustered:
        return observe(centre + 0.1f * (random.next() - 0.5f));
      case Host::one_sided:
        return observe(static_cast<float>(pi) * random.next());
      case Host::beside:
        for (int n = 0; n < 4; ++n) observe(centre + 0.1f * (random.next() - 0.5f));
        break;
      default:
        break;
    }
    if (view.fit == nullptr) return;
    adaptive::Mixture proposal = *view.fit;
    if (stress_.host == Host::absorbed) {
      for (adaptive::Component& part : proposal.components) part.weight *= std::exp(-12 * of_row.next());
      proposal.uniform_weight *= std::exp(-12 * of_row.next());
    }
    const float x = proposal.sample(random.next(), share);
    service.score(view, x, view.nodes->density(x), proposal.proposal_density(x, share));
  }

  Stress stress_;
  std::uint64_t seed_;
};

/// The densities that are published, to the bit.
std::uint64_t fingerprint(const adaptive::Service& service, const std::vector<Row>& rows) {
  std::uint64_t hash = 0;
  for (const Row& row : rows) {
    const adaptive::RowView view = service.peek(row.slice, 0, 0);
    hash = mix_bits(hash ^ static_cast<std::uint64_t>(view.state) ^ std::bit_cast<std::uint32_t>(view.objective));
    for (const float x : {-3.0f, -1.0f, 0.5f, 2.0f})
      hash = mix_bits(hash ^ std::bit_cast<std::uint32_t>(view.density(x)));
  }
  return hash;
}

nlohmann::json study(const Stress& stress, const Learner& learner, const bench::ListedTarget& target,
                     const std::vector<Truth>& truths, std::size_t count, std::uint64_t seed, int threads,
                     std::uint64_t* printed = nullptr) {
  adaptive::Options options;
  options.epsilon = stress.epsilon;
  options.learner = &learner;
  options.seed = seed;
  options.queries_before_creation = 1;
  options.memory_bytes = std::size_t{4} << 30;
  if (stress.bytes_a_row > 0) {
    options.memory_bytes =
        std::size_t{100000} + static_cast<std::size_t>(stress.bytes_a_row * static_cast<double>(count));
  }
  adaptive::Service service(options, target);
  std::vector<Row> rows;
  for (std::size_t i = 0; i < count; ++i) rows.push_back({*service.add_slice(target.slice(i))});

  const Asked host(stress, seed);
  double cpu = 0;
  std::uint64_t g = 0, violations = 0, most_bytes = 0;
  adaptive::PassReport report;
  bool reached_ceiling = false;
  const int most_passes = stress.samples > 0 ? 1 + (stress.samples + 15) / 16 : 65;
  int pass = 0;
  for (int left = stress.samples; pass < most_passes; ++pass) {
    int vertices = 16;
    if (pass == 0) {
      vertices = 1;
    } else if (stress.samples > 0) {
      vertices = std::min(left, 16);
      left -= vertices;
    }
    host.pass(service, rows, pass, vertices, threads);
    report = service.publish();
    cpu += report.learning_cpu_seconds;
    g += report.g_evaluations;
    reached_ceiling = reached_ceiling || report.at_ceiling;
    most_bytes = std::max(most_bytes, report.bytes);
    violations += report.bytes > options.memory_bytes ? 1 : 0;
    for (std::size_t i = 0; i < count; ++i) {
      const adaptive::RowView view = service.peek(rows[i].slice, 0, 0);
      rows[i].state = view.state;
      if (view.fit == nullptr) continue;
      violations += within_constraints(view, truths[i].energy(), options.max_components) ? 0 : 1;
    }
    if (report.rows_converged + report.rows_refused == count) break;
  }
  if (printed != nullptr) *printed = fingerprint(service, rows);

  std::vector<double> errors, all;
  std::uint64_t falsely = 0, created = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const adaptive::RowView view = service.peek(rows[i].slice, 0, 0);
    created += view.state != RowState::absent ? 1 : 0;
    if (view.fit == nullptr) continue;
    const double error = truths[i].error(view);
    all.push_back(error);
    if (view.state != RowState::converged) continue;
    errors.push_back(error);
    falsely += error > stress.epsilon ? 1 : 0;
  }
  const auto n = static_cast<double>(count);
  const auto spread = [](const std::vector<double>& values) {
    return nlohmann::json{{"p50", bench::quantile(values, .5)},
                          {"p99", bench::quantile(values, .99)},
                          {"max", bench::quantile(values, 1)}};
  };
  return {{"stress", stress.name},
          {"learner", learner.name},
          {"epsilon", stress.epsilon},
          {"rows", count},
          {"born", created},
          {"converged", errors.size()},
          {"refused", report.rows_refused},
          {"false", falsely},
          {"violations", violations},
          {"error", spread(errors)},
          {"error_of_all", spread(all)},
          {"g_a_row", static_cast<double>(g) / n},
          {"cpu_us_a_row", 1e6 * cpu / n},
          {"passes", pass + 1},
          {"ceiling_bytes", stress.bytes_a_row > 0 ? options.memory_bytes : 0},
          {"most_bytes", most_bytes},
          {"told_ceiling", reached_ceiling}};
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> names, learners;
  std::size_t rows = 3000, rival_rows = 300;
  std::uint64_t seed = 1;
  bool list = false;
  CLI::App app("rows under stress by every learner, as JSON");
  app.add_option("--stress", names);
  app.add_option("--learner", learners)->check(bench::known_learner);
  app.add_option("--rows", rows, "of sketch and eager")->check(CLI::PositiveNumber);
  app.add_option("--rival-rows", rival_rows, "of the others")->check(CLI::PositiveNumber);
  app.add_option("--seed", seed);
  app.add_flag("--list", list, "only the names of the stresses");
  CLI11_PARSE(app, argc, argv);
  nlohmann::json found = nlohmann::json::array();
  bool good = true;
  for (const Stress& stress : stresses) {
    if (list) fmt::print("{}\n", stress.name);
    if (list || (!names.empty() && std::ranges::find(names, stress.name) == names.end())) continue;
    std::vector<bench::StressRow> listed;
    bench::StressTargets targets(seed, stress.family);
    for (std::size_t i = 0; i < std::max(rows, rival_rows); ++i) listed.push_back(targets.next());
    const bench::ListedTarget target(std::move(listed));
    std::vector<Truth> truths;
    for (std::size_t i = 0; i < target.size(); ++i) truths.emplace_back(target, i);
    for (const adaptive::Learner* info : references::learners()) {
      if (!learners.empty() && std::ranges::find(learners, info->name) == learners.end()) continue;
      const bool many = info == &adaptive::sketch_learner || info == &references::eager_learner;
      const std::size_t count = many ? rows : rival_rows;
      std::uint64_t printed = 0, alone = 0;
      nlohmann::json cell = study(stress, *info, target, truths, count, seed, stress.threads, &printed);
      if (stress.threads > 1) {
        study(stress, *info, target, truths, count, seed, 1, &alone);
        cell["same_bits"] = printed == alone;
        good = good && printed == alone;
      }
      good = good && cell["violations"] == 0;
      found.push_back(std::move(cell));
    }
  }
  if (!list) fmt::print("{}\n", found.dump());
  return good ? 0 : 3;
}
