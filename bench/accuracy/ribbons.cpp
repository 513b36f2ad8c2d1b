// Rows of the rough fiber, learned from split paths, against the truth of many more: how far off, and what they cost.
//
// Truth: two independent halves of split paths, by part and absorption, in 120 x 180 bins of (theta_i, phi_i). Error of
// a row's flux f: sqrt(sum (f - A)(f - B)/sum A B), A and B the halves: their noise is in no mean. Rows are learned
// without a test from 1,024, 4,096 and 16,384 paths, and to `epsilon`. Under absorption each part has the energy of the
// truth, as a model would give it. Configurations: e x alpha x theta_r; phi_r and the tilt rotate through them.
//
// --rows N instead: false passes. N random rows are learned to epsilon, and what passed is tested by fresh paths: the
// fit that passed and what is published, which knows the batch that tested it too.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "adaptive/learn_samples.h"
#include "fiber/rough_rows.h"
#include "fiber/traced_parts.h"
#include "fit/learn_stage.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/ribbon.h"
#include "tress/base/random.h"

namespace tress {
namespace {

constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr std::size_t thetas = 120, phis = 180, bins = thetas * phis, parts = fiber::rough_parts, absorptions = 3;
constexpr std::array<float, absorptions> sigma_a{0.0f, 0.25f, 1.0f};
constexpr std::array<const char*, parts + 1> part_names{"R", "TT", "TRT", "rest", "whole"};
constexpr std::uint64_t truth_streams = std::uint64_t{1} << 56;

struct Setting {
  std::uint32_t truth_paths = 1u << 20;  // a half
  double epsilon = adaptive::Options{}.sampled_epsilon;
  std::uint32_t rows = 0, test_paths = 1u << 17;
  std::uint64_t seed = 1;
  bool quick = false;
  std::array<float, fiber::TracedParts::count> parts{};
  std::vector<double> e{0.5, 0.75, 0.85, 1}, alpha{0.05, 0.1, 0.2, 0.3}, theta{0, 30, 60, 80};
};

struct Node {
  double e, alpha, theta_deg, phi_deg, tilt_deg;
  std::array<float, fiber::TracedParts::count> parts{};  ///< as fiber::TracedParts::values()
  fiber::FiberParameters fiber() const {
    fiber::FiberParameters f;
    f.eccentricity = static_cast<float>(e);
    f.roughness = static_cast<float>(alpha);
    f.tilt = static_cast<float>(tilt_deg * degree);
    fiber::TracedParts::from(parts.data()).give_to(f);
    return f;
  }
  float a() const { return static_cast<float>(theta_deg * degree); }
  float b() const { return static_cast<float>(phi_deg * degree); }
};

std::vector<Node> all_nodes(const Setting& setting) {
  constexpr std::array<double, 3> phi{10, 45, 80};
  std::vector<Node> nodes;
  std::size_t i = 0;
  for (const double e : setting.e) {
    for (const double alpha : setting.alpha) {
      for (const double theta : setting.theta) {
        const double sign = i % 4 == 3 ? -1 : 1;
        nodes.push_back({e, alpha, sign * theta, phi[i % 3], i % 2 == 0 ? 0.0 : 3.0, setting.parts});
        ++i;
      }
      ++i;  // so that phi_r and tilt do not go with theta_r
    }
  }
  return nodes;
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Counts the time that its draws take.
class TimedTarget : public adaptive::SampledTarget {
 public:
  std::uint32_t parts(const adaptive::SliceDescription& slice) const override { return target_->parts(slice); }
  void draw(const adaptive::SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
            std::uint32_t count, std::vector<adaptive::SampledExit>& out) const override {
    const double before = cpu_seconds();
    target_->draw(slice, a, b, stream, first, count, out);
    seconds_ += cpu_seconds() - before;
  }
  std::string model_name() const override { return target_->model_name(); }
  double seconds() const { return seconds_; }

 private:
  std::unique_ptr<adaptive::SampledTarget> target_ = fiber::make_rough_target();
  mutable double seconds_ = 0;
};

/// Flux a bin, by absorption and part; the last part is the whole.
struct Flux {
  std::array<std::array<std::vector<double>, parts + 1>, absorptions> bins_;
  Flux() {
    for (auto& of : bins_) of.fill(std::vector<double>(bins, 0.0));
  }
  double energy(std::size_t s, std::size_t part) const {
    double sum = 0;
    for (const double x : bins_[s][part]) sum += x;
    return sum;
  }
  void add_up() {
    for (auto& of : bins_) {
      for (std::size_t p = 0; p < parts; ++p) {
        for (std::size_t b = 0; b < bins; ++b) of[parts][b] += of[p][b];
      }
    }
  }
};

std::size_t bin_of(double theta, double phi) {
  const auto index = [](double turn, std::size_t n) {
    return static_cast<std::size_t>(std::clamp(turn * static_cast<double>(n), 0.0, static_cast<double>(n) - 1));
  };
  return index(theta / pi + 0.5, thetas) * phis + index(phi / (2 * pi) + 0.5, phis);
}

std::array<Flux, 2> trace_truth(const adaptive::SampledTarget& target, const adaptive::SliceDescription& slice,
                                const Node& node, std::uint32_t paths) {
  std::array<Flux, 2> halves;
  const double specular = fiber::specular_height(node.a());
  std::vector<adaptive::SampledExit> exits;
  for (std::size_t half = 0; half < 2; ++half) {
    constexpr std::uint32_t at_once = 1u << 14;
    for (std::uint32_t first = 0; first < paths; first += at_once) {
      exits.clear();
      target.draw(slice, node.a(), node.b(), truth_streams + half, first, at_once, exits);
      for (const adaptive::SampledExit& exit : exits) {
        const double theta = fiber::theta_of(static_cast<float>(static_cast<double>(exit.height) + specular));
        const std::size_t bin = bin_of(theta, adaptive::wrap_angle(exit.azimuth));
        for (std::size_t s = 0; s < absorptions; ++s) {
          halves[half].bins_[s][exit.part][bin] +=
              static_cast<double>(exit.weight * std::exp(-sigma_a[s] * exit.attribute)) / paths;
        }
      }
    }
    halves[half].add_up();
  }
  return halves;
}

/// The ribbon under absorption: each knot keeps what its gamma law leaves.
adaptive::Ribbon colored(const adaptive::Ribbon& ribbon, float rate) {
  std::array<adaptive::RibbonKnot, adaptive::Ribbon::main_knots> main;
  std::array<adaptive::RibbonKnot, adaptive::Ribbon::broad_knots> broad;
  const auto color = [rate](const auto& from, auto& to) {
    for (std::size_t k = 0; k < to.size(); ++k) {
      to[k] = from[k];
      to[k].density *= adaptive::GammaDecay::from(from[k].decays).at(rate);
    }
  };
  color(ribbon.main(), main);
  color(ribbon.broad(), broad);
  return adaptive::Ribbon(main, ribbon.main_law(), broad);
}

Flux flux_of(const adaptive::RibbonRow& row, const Node& node, const std::array<Flux, 2>& truth) {
  constexpr int fine = 2;
  Flux flux;
  const double specular = fiber::specular_height(node.a());
  for (std::uint32_t p = 0; p < row.parts(); ++p) {
    if (!(row.mass(p) > 0)) continue;
    for (std::size_t s = 0; s < absorptions; ++s) {
      const adaptive::Ribbon ribbon = s == 0 ? row.ribbon(p) : colored(row.ribbon(p), sigma_a[s]);
      const double energy =
          s == 0 ? static_cast<double>(row.mass(p)) : 0.5 * (truth[0].energy(s, p) + truth[1].energy(s, p));
      for (std::size_t i = 0; i < thetas * fine; ++i) {
        const double theta = pi * ((static_cast<double>(i) + 0.5) / (thetas * fine) - 0.5);
        const auto t = static_cast<float>(std::asinh(std::tan(theta)) - specular);
        const double scale = energy / std::cos(theta) * (pi / (thetas * fine)) * (2 * pi / (phis * fine));
        for (std::size_t j = 0; j < phis * fine; ++j) {
          const double phi = 2 * pi * ((static_cast<double>(j) + 0.5) / (phis * fine) - 0.5);
          flux.bins_[s][p][i / fine * phis + j / fine] +=
              scale * static_cast<double>(ribbon.density(static_cast<float>(phi), t));
        }
      }
    }
  }
  flux.add_up();
  return flux;
}

double error_of(const Flux& f, const std::array<Flux, 2>& truth, std::size_t s, std::size_t part) {
  const auto &x = f.bins_[s][part], &a = truth[0].bins_[s][part], &b = truth[1].bins_[s][part];
  double off = 0, all = 0;
  for (std::size_t i = 0; i < bins; ++i) {
    off += (x[i] - a[i]) * (x[i] - b[i]);
    all += a[i] * b[i];
  }
  return all > 0 ? std::sqrt(std::max(off, 0.0) / all) : 0;
}

double quantile(std::vector<double> of, double q) {
  if (of.empty()) return 0;
  std::sort(of.begin(), of.end());
  const double at = q * static_cast<double>(of.size() - 1);
  const auto i = static_cast<std::size_t>(at);
  return i + 1 < of.size() ? of[i] + (at - static_cast<double>(i)) * (of[i + 1] - of[i]) : of[i];
}

double mean_of(const std::vector<double>& of) {
  double sum = 0;
  for (const double x : of) sum += x;
  return of.empty() ? 0 : sum / static_cast<double>(of.size());
}

/// What is learned: from a number of paths, or to epsilon where it is 0.
struct Budget {
  std::string name;
  std::uint32_t paths;
};

/// What the rows of a budget came to.
struct Results {
  std::array<std::array<std::vector<double>, parts + 1>, absorptions> errors;
  std::map<double, std::vector<double>> by_alpha, by_theta;
  std::vector<double> paths, draw_ms, learn_ms;
  int converged = 0;
};

/// A row of the budget's paths; without a budget one that learns until it passes.
adaptive::SampledRow learned_row(const TimedTarget& target, const adaptive::SliceDescription& slice, const Node& node,
                                 const Budget& budget, const Setting& setting) {
  if (budget.paths == 0)
    return adaptive::learn_samples(target, slice, node.a(), node.b(), {.epsilon = setting.epsilon});
  adaptive::SampledRow row;
  row.row = adaptive::learn_stage(target, slice, node.a(), node.b(), budget.paths, 0, nullptr, nullptr).row;
  row.paths = budget.paths;
  return row;
}

void measure(const Node& node, const Setting& setting, const std::vector<Budget>& budgets,
             std::vector<Results>& results) {
  const TimedTarget target;
  const adaptive::SliceDescription slice = fiber::rough_slice(node.fiber());
  const std::array<Flux, 2> truth = trace_truth(target, slice, node, setting.truth_paths);
  std::string line = fmt::format("e {:4} alpha {:4} theta {:3} phi {:2} tilt {}:", node.e, node.alpha, node.theta_deg,
                                 node.phi_deg, node.tilt_deg);
  for (std::size_t i = 0; i < budgets.size(); ++i) {
    Results& into = results[i];
    const double drawn = target.seconds(), before = cpu_seconds();
    const adaptive::SampledRow learned = learned_row(target, slice, node, budgets[i], setting);
    const double draw = target.seconds() - drawn, all = cpu_seconds() - before;
    const Flux flux = flux_of(learned.row, node, truth);
    for (std::size_t s = 0; s < absorptions; ++s) {
      for (std::size_t p = 0; p <= parts; ++p) into.errors[s][p].push_back(error_of(flux, truth, s, p));
    }
    const double error = into.errors[0][parts].back();
    into.by_alpha[node.alpha].push_back(error);
    into.by_theta[std::abs(node.theta_deg)].push_back(error);
    into.paths.push_back(static_cast<double>(learned.paths));
    into.draw_ms.push_back(1e3 * draw);
    into.learn_ms.push_back(1e3 * (all - draw));
    into.converged += learned.verdict == adaptive::SampledRow::Verdict::converged ? 1 : 0;
    line += fmt::format("  {} {:.3f}", budgets[i].name, error);
    if (budgets[i].paths == 0) line += fmt::format(" ({} paths, objective {:.3f})", learned.paths, learned.objective);
  }
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

void print(const Budget& budget, const Results& results) {
  fmt::print("\n{}: relative L2, median / 90 %", budget.name);
  for (std::size_t s = 0; s < absorptions; ++s) {
    fmt::print("\n  sigma_a {:<5}", sigma_a[s]);
    for (std::size_t p = 0; p <= parts; ++p) {
      fmt::print("  {} {:.3f} / {:.3f}", part_names[p], quantile(results.errors[s][p], 0.5),
                 quantile(results.errors[s][p], 0.9));
    }
  }
  fmt::print("\n  by alpha    ");
  for (const auto& [alpha, errors] : results.by_alpha) fmt::print("  {}: {:.3f}", alpha, quantile(errors, 0.5));
  fmt::print("\n  by theta_r  ");
  for (const auto& [theta, errors] : results.by_theta) fmt::print("  {}: {:.3f}", theta, quantile(errors, 0.5));
  fmt::print("\n  converged {} of {}, paths {:.0f}; CPU: draws {:.1f} ms, tests and fits {:.1f} ms\n",
             results.converged, results.paths.size(), mean_of(results.paths), mean_of(results.draw_ms),
             mean_of(results.learn_ms));
}

/// A row of any fiber: alpha by its logarithm, the others evenly.
Node random_node(RandomStream& random) {
  const auto within = [&random](double from, double to) {
    return from + (to - from) * static_cast<double>(random.next());
  };
  return {within(0.5, 1), 0.02 * std::pow(25.0, within(0, 1)), within(-87, 87), within(0, 90), within(0, 5), {}};
}

int run_false_passes(const Setting& setting) {
  const TimedTarget target;
  const double epsilon = setting.epsilon;
  std::vector<double> tested, published, paths, off;
  for (std::uint64_t i = 0; i < setting.rows; ++i) {
    RandomStream random(setting.seed, i);
    const Node node = random_node(random);
    const adaptive::SliceDescription slice = fiber::rough_slice(node.fiber());
    const auto learn = [&](adaptive::SampledLimits limits) {
      return adaptive::learn_samples(target, slice, node.a(), node.b(), limits);
    };
    adaptive::SampledLimits limits;
    limits.epsilon = epsilon;
    const adaptive::SampledRow learned = learn(limits);
    paths.push_back(static_cast<double>(learned.paths));
    if (learned.verdict != adaptive::SampledRow::Verdict::converged) continue;
    limits.epsilon = -1;  // what passed is the row of the stage before
    limits.most_paths = learned.paths - 1;
    const auto test = [&](const adaptive::RibbonRow& row) {
      return adaptive::test_samples(target, slice, node.a(), node.b(), row, 0, setting.test_paths);
    };
    const adaptive::SampledTest of_tested = test(learn(limits).row), of_published = test(learned.row);
    tested.push_back(of_tested.chi2);
    published.push_back(of_published.chi2);
    off.push_back((static_cast<double>(learned.objective) - of_tested.chi2) / epsilon);
  }
  const auto above = [](const std::vector<double>& of, double bound) {
    return std::count_if(of.begin(), of.end(), [bound](double x) { return x > bound; });
  };
  fmt::print("epsilon {}: {} of {} rows passed, {:.0f} paths on average (median {:.0f})\n", epsilon, tested.size(),
             setting.rows, mean_of(paths), quantile(paths, 0.5));
  fmt::print(
      "chi-square by {} fresh paths: the fit that passed {:.4f} / {:.4f} / {:.4f} (median, 99 %, most), above "
      "epsilon {}, above 1.5 epsilon {}\n",
      setting.test_paths, quantile(tested, 0.5), quantile(tested, 0.99), quantile(tested, 1), above(tested, epsilon),
      above(tested, 1.5 * epsilon));
  fmt::print(
      "  what is published {:.4f} / {:.4f} / {:.4f}, above epsilon {}; objective minus the fit's chi-square, over "
      "epsilon: median {:.2f}\n",
      quantile(published, 0.5), quantile(published, 0.99), quantile(published, 1), above(published, epsilon),
      quantile(off, 0.5));
  return 0;
}

int run(const Setting& setting) {
  if (setting.rows > 0) return run_false_passes(setting);
  const std::vector<Budget> budgets{{"1024", 1024}, {"4096", 4096}, {"16384", 16384}, {"learned", 0}};
  std::vector<Results> results(budgets.size());
  for (const Node& node : all_nodes(setting)) measure(node, setting, budgets, results);
  for (std::size_t i = 0; i < budgets.size(); ++i) print(budgets[i], results[i]);
  return 0;
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Setting setting;
  CLI::App app("Rows of the rough fiber against its paths.");
  app.add_option("--truth-paths", setting.truth_paths, "a half");
  app.add_option("--epsilon", setting.epsilon);
  app.add_option("--e", setting.e);
  app.add_option("--alpha", setting.alpha);
  app.add_option("--theta", setting.theta, "theta_r, degrees");
  app.add_option("--parts", setting.parts,
                 "of the configurations: the medulla's radius, scattering, asymmetry and absorption, the cortex's "
                 "scattering and asymmetry, wetness");
  app.add_option("--rows", setting.rows, "false passes of so many random rows instead");
  app.add_option("--test-paths", setting.test_paths, "fresh paths a row");
  app.add_option("--seed", setting.seed, "of the random rows");
  app.add_flag("--quick", setting.quick, "twelve configurations and an eighth of the paths");
  CLI11_PARSE(app, argc, argv);
  if (setting.quick) {
    setting.e = {0.5, 0.85, 1};
    setting.alpha = {0.05, 0.2};
    setting.theta = {0, 60};
    setting.truth_paths = 1u << 17;
  }
  return tress::run(setting);
}
