// The single-fiber far field of every model of the registry against fiber3d, the traced rough fiber: per lobe and as a
// whole, over cross-sections, roughness and known directions, in three absorptions at once.
//
// Both sides are fluxes in 36 x 36 bins of (theta_i, phi_i), per unit flux. Truth: paths stratified over the fiber's
// width; its noise floor is half the difference of two halves. Models: S by midpoints over the bins, 6 x 5 a bin, under
// `exact` (no rows); near-field models, found by asking whether h matters, by 4 x 4 a bin at 48 midpoints of h.
//   shape   relative L2 of the lobes, each of mass 1
//   l2      relative L2 of the fluxes themselves
//   energy  ours over theirs, minus 1
// The floor is taken out of shape and l2: sqrt(max(0, error^2 - floor^2)). A lobe is compared where its floor is below
// 0.1; it has no shape where the model has none of it.
//
// --fair gives d'Eon's, Marschner's and Ou's model what ours has, as rivals of their own ("deon2011 fair"): each lobe
// the energy of the truth itself, by a factor on its flux (what a model lacks stays 0), and the widths in theta_i and
// azimuth that bring that lobe nearest to the truth of the cell, all three absorptions together.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "fiber/rough_fiber.h"
#include "references/registry.h"
#include "results_file.h"
#include "tress/base/random.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberParameters;

constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr std::size_t side = 36, channels = 3, parts = 5;
constexpr std::array<const char*, parts> part_names{"R", "TT", "TRT", "rest", "whole"};
constexpr std::size_t whole = parts - 1;
constexpr double largest_floor = 0.1;

struct Setting {
  int paths = 2000000;
  std::uint64_t seed = 1;
  double tilt_deg = 0;
  std::array<float, channels> sigma_a{0.0f, 0.25f, 1.0f};
  bool fair = false;
  std::string model, json;
  std::vector<double> e{1.0, 0.85, 0.7}, alpha{0.05, 0.1, 0.2}, theta_deg{0.0, 30.0, 60.0, 80.0},
      phi_deg{10.0, 45.0, 80.0};
};

struct Cell {
  double e, alpha, theta_deg, phi_deg;
};

/// Of a circle one phi_r alone: they are all alike.
std::vector<Cell> all_cells(const Setting& setting) {
  std::vector<Cell> cells;
  for (const double e : setting.e) {
    for (const double alpha : setting.alpha) {
      for (const double theta : setting.theta_deg) {
        for (const double phi : setting.phi_deg) {
          if (e < 1 || phi == setting.phi_deg[setting.phi_deg.size() / 2]) cells.push_back({e, alpha, theta, phi});
        }
      }
    }
  }
  return cells;
}

FiberParameters parameters_of(const Cell& cell, const Setting& setting) {
  FiberParameters parameters;
  parameters.eccentricity = static_cast<float>(cell.e);
  parameters.roughness = static_cast<float>(cell.alpha);
  parameters.tilt = static_cast<float>(setting.tilt_deg * degree);
  parameters.sigma_a = {setting.sigma_a[0], setting.sigma_a[1], setting.sigma_a[2]};
  return parameters;
}

FiberDirection known_of(const Cell& cell) {
  return {static_cast<float>(cell.theta_deg * degree), static_cast<float>(cell.phi_deg * degree)};
}

/// Flux by channel and part, `whole` being the sum of the others.
struct Flux {
  std::array<std::array<std::vector<double>, parts>, channels> bins;
  Flux() {
    for (auto& channel : bins) channel.fill(std::vector<double>(side * side));
  }
  void add(std::size_t part, std::size_t bin, const glm::vec3& weight, double scale) {
    for (std::size_t c = 0; c < channels; ++c) {
      const double flux = scale * static_cast<double>(weight[static_cast<int>(c)]);
      bins[c][part][bin] += flux;
      bins[c][whole][bin] += flux;
    }
  }
};

std::size_t part_of(std::size_t lobe) {
  if (lobe == static_cast<std::size_t>(fiber::Lobe::glint)) return 2;
  return std::min<std::size_t>(lobe, 3);
}

/// Both halves of the paths, each of unit flux.
std::array<Flux, 2> trace(const Cell& cell, const Setting& setting, std::uint64_t stream) {
  const fiber::RoughFiber rough(parameters_of(cell, setting));
  const FiberDirection known = known_of(cell);
  const int paths = setting.paths / 2;
  std::array<Flux, 2> halves;
  for (std::size_t half = 0; half < 2; ++half) {
    RandomStream random(setting.seed, stream, half);
    for (int i = 0; i < paths; ++i) {
      const double h = 2 * (i + static_cast<double>(random.next())) / paths - 1;
      const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
      const fiber::RoughExit exit = rough.trace(rough.entry(known, static_cast<float>(h)), u, random);
      if (!(exit.throughput.r > 0)) continue;
      const FiberDirection wi = exit.angles();
      const auto index = [](double turn) { return static_cast<std::size_t>(std::clamp(turn * side, 0.0, side - 1.0)); };
      const std::size_t bin =
          index(static_cast<double>(wi.theta) / pi + 0.5) * side + index(0.5 * (static_cast<double>(wi.phi) / pi + 1));
      halves[half].add(static_cast<std::size_t>(std::min(exit.order, 3)), bin, exit.throughput, 1.0 / paths);
    }
  }
  return halves;
}

/// Whether what the model answers depends on where the ray meets the fiber.
bool is_near_field(const fiber::FiberModel& model, fiber::FiberId id, const FiberDirection& known) {
  const fiber::FiberEvent one = model.begin(id, known, 0.5f, 0.5f, -0.6f),
                          other = model.begin(id, known, 0.5f, 0.5f, 0.3f);
  for (int i = 0; i < 32; ++i) {
    const FiberDirection wi{-known.theta, static_cast<float>(-pi + (i + 0.5) * pi / 16)};
    if (model.evaluate(one, wi).total() != model.evaluate(other, wi).total()) return true;
  }
  return false;
}

struct Prediction {
  Flux flux;
  long evaluations = 0;
};

Prediction predict(const fiber::FiberModel& model, fiber::FiberId id, const FiberDirection& known) {
  const bool near = is_near_field(model, id, known);
  const std::size_t thetas = side * (near ? 4 : 6), phis = side * (near ? 4 : 5), offsets = near ? 48 : 1;
  const double scale =
      pi / static_cast<double>(thetas) * 2 * pi / static_cast<double>(phis) / static_cast<double>(offsets);
  Prediction result;
  for (std::size_t k = 0; k < offsets; ++k) {
    const double h = (2 * static_cast<double>(k) + 1) / static_cast<double>(offsets) - 1;
    const fiber::FiberEvent event = model.begin(id, known, 0.5f, 0.5f, static_cast<float>(h));
    for (std::size_t i = 0; i < thetas; ++i) {
      for (std::size_t j = 0; j < phis; ++j) {
        const FiberDirection wi{
            static_cast<float>(-pi / 2 + (static_cast<double>(i) + 0.5) * pi / static_cast<double>(thetas)),
            static_cast<float>(-pi + (static_cast<double>(j) + 0.5) * 2 * pi / static_cast<double>(phis))};
        const fiber::FiberValue value = model.evaluate(event, wi);
        const std::size_t bin = i * side / thetas * side + j * side / phis;
        for (std::size_t lobe = 0; lobe < fiber::lobe_count; ++lobe) {
          if (value.s[lobe] != glm::vec3(0.0f)) result.flux.add(part_of(lobe), bin, value.s[lobe], scale);
        }
      }
    }
  }
  result.evaluations = static_cast<long>(thetas * phis * offsets);
  return result;
}

double sum(const std::vector<double>& bins) {
  double total = 0;
  for (const double x : bins) total += x;
  return total;
}

/// Relative L2 of a/scale_a - b/scale_b to b/scale_b.
double relative_l2(const std::vector<double>& a, double scale_a, const std::vector<double>& b, double scale_b) {
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double theirs = b[i] / scale_b, d = a[i] / scale_a - theirs;
    error += d * d;
    norm += theirs * theirs;
  }
  return std::sqrt(error / norm);
}

struct Truth {
  Flux flux;  ///< mean of the halves
  std::array<std::array<double, parts>, channels> energy{};
  std::array<std::array<std::optional<double>, parts>, channels> floor{};  ///< none where too little light is there

  explicit Truth(const std::array<Flux, 2>& halves) {
    for (std::size_t c = 0; c < channels; ++c) {
      for (std::size_t p = 0; p < parts; ++p) {
        std::vector<double>& mean = flux.bins[c][p];
        const std::vector<double>&one = halves[0].bins[c][p], &other = halves[1].bins[c][p];
        for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = 0.5 * (one[i] + other[i]);
        energy[c][p] = sum(mean);
        if (!(sum(one) > 0 && sum(other) > 0)) continue;
        double difference = 0, norm = 0;
        for (std::size_t i = 0; i < mean.size(); ++i) {
          const double d = 0.5 * (one[i] / sum(one) - other[i] / sum(other)), m = mean[i] / energy[c][p];
          difference += d * d;
          norm += m * m;
        }
        const double noise = std::sqrt(difference / norm);
        if (noise < largest_floor) floor[c][p] = noise;
      }
    }
  }
};

struct Errors {
  std::array<std::array<std::optional<double>, parts>, channels> shape{}, l2{}, energy{};

  Errors(const Flux& ours, const Truth& truth) {
    for (std::size_t c = 0; c < channels; ++c) {
      for (std::size_t p = 0; p < parts; ++p) {
        if (!truth.floor[c][p]) continue;
        const double floor = *truth.floor[c][p], mass = sum(ours.bins[c][p]);
        const auto without_noise = [&](double error) {
          return std::sqrt(std::max(error * error - floor * floor, 0.0));
        };
        const std::vector<double>& theirs = truth.flux.bins[c][p];
        l2[c][p] = without_noise(relative_l2(ours.bins[c][p], 1, theirs, 1));
        energy[c][p] = mass / truth.energy[c][p] - 1;
        if (mass > 1e-9) shape[c][p] = without_noise(relative_l2(ours.bins[c][p], mass, theirs, truth.energy[c][p]));
      }
    }
  }
};

/// Each part with the energy of the truth; the whole is their sum.
Flux with_energies_of(const Truth& truth, Flux flux) {
  for (std::size_t c = 0; c < channels; ++c) {
    std::ranges::fill(flux.bins[c][whole], 0.0);
    for (std::size_t p = 0; p < whole; ++p) {
      const double mass = sum(flux.bins[c][p]), factor = mass > 1e-9 ? truth.energy[c][p] / mass : 0;
      for (std::size_t i = 0; i < flux.bins[c][p].size(); ++i) {
        flux.bins[c][p][i] *= factor;
        flux.bins[c][whole][i] += flux.bins[c][p][i];
      }
    }
  }
  return flux;
}

/// Squared distance of one part to the truth, absorptions together, each over the whole's power.
double distance(const Flux& flux, const Truth& truth, std::size_t part) {
  double total = 0;
  for (std::size_t c = 0; c < channels; ++c) {
    double error = 0, norm = 0;
    for (std::size_t i = 0; i < flux.bins[c][part].size(); ++i) {
      const double d = flux.bins[c][part][i] - truth.flux.bins[c][part][i], w = truth.flux.bins[c][whole][i];
      error += d * d;
      norm += w * w;
    }
    total += error / norm;
  }
  return total;
}

/// The model with the energies of the truth and its widths tuned: from those it takes by itself, factors of 2 and less
/// in theta_i and in azimuth, by turns and all lobes at once, since each has widths and a distance of its own.
Prediction fair(const fiber::ModelInfo& info, const Cell& cell, const Setting& setting, const Truth& truth) {
  const auto model = info.make({fiber::Estimator::exact, nullptr, 0});
  const FiberParameters own = parameters_of(cell, setting);
  const FiberDirection known = known_of(cell);
  const auto at = [&](const std::array<double, whole>& along, const std::array<double, whole>& around) {
    FiberParameters tuned = own;
    const std::array<float, 3> sigma = fiber::azimuthal_sigmas(own);
    for (std::size_t p = 0; p < whole; ++p) {
      const double lambda = static_cast<double>(fiber::longitudinal_lambda(own, static_cast<int>(p), known.theta));
      tuned.longitudinal_lambda[p] = static_cast<float>(std::clamp(lambda * along[p], 0.25 * degree, 45 * degree));
      if (p == 0) continue;
      tuned.azimuthal_sigma[p - 1] =
          static_cast<float>(std::clamp(static_cast<double>(sigma[p - 1]) * around[p], 0.5 * degree, 45 * degree));
    }
    Prediction result = predict(*model, model->add_fiber(tuned), known);
    result.flux = with_energies_of(truth, std::move(result.flux));
    return result;
  };
  std::array<double, whole> along, around, best;
  along.fill(1);
  around.fill(1);
  Prediction current = at(along, around);
  for (std::size_t p = 0; p < whole; ++p) best[p] = distance(current.flux, truth, p);
  for (const double step : {2.0, 1.4, 1.2}) {
    for (const bool is_along : {true, false}) {
      for (const double factor : {step, 1 / step}) {
        std::array<double, whole> tried_along = along, tried_around = around;
        for (double& value : is_along ? tried_along : tried_around) value *= factor;
        current = at(tried_along, tried_around);
        for (std::size_t p = 0; p < whole; ++p) {
          const double reached = distance(current.flux, truth, p);
          if (!(reached < best[p])) continue;
          best[p] = reached;
          along[p] = tried_along[p];
          around[p] = tried_around[p];
        }
      }
    }
  }
  return at(along, around);
}

double rounded(double x) { return std::round(x * 1e5) / 1e5; }

template <class Values>
nlohmann::json to_json(const Values& by_channel) {
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& channel : by_channel) {
    nlohmann::json row = nlohmann::json::array();
    for (const auto& value : channel) {
      if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
        row.push_back(rounded(value));
      } else {
        row.push_back(value ? nlohmann::json(rounded(*value)) : nlohmann::json());
      }
    }
    rows.push_back(row);
  }
  return rows;
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::string output_of(const char* command) {
  std::string text;
  if (FILE* pipe = popen(command, "r")) {
    std::array<char, 256> buffer;
    while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) text += buffer.data();
    pclose(pipe);
  }
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

/// Values gathered over cells and channels.
class Gathered {
 public:
  void add(const std::string& key, const std::optional<double>& value) {
    if (value) values_[key].push_back(std::abs(*value));
  }
  std::string median(const std::string& key) {
    std::vector<double>& all = values_[key];
    if (all.empty()) return "-";
    std::sort(all.begin(), all.end());
    return fmt::format("{:.3f}", all[all.size() / 2]);
  }

 private:
  std::map<std::string, std::vector<double>> values_;
};

std::string key_of(const std::string& model, const char* what, std::size_t part) {
  return fmt::format("{} {} {}", model, what, part);
}
std::string key_of(const std::string& model, const char* axis, double value) {
  return fmt::format("{} {} {}", model, axis, value);
}

void print_tables(const std::vector<std::string>& models, const Setting& setting, Gathered& gathered) {
  fmt::print(
      "Medians over cells and absorptions.\n\n| model | shape: R | TT | TRT | rest | whole | whole, not "
      "normalised | energy off: R | TT | TRT | rest | whole |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const std::string& model : models) {
    fmt::print("| {} |", model);
    for (std::size_t p = 0; p < parts; ++p) fmt::print(" {} |", gathered.median(key_of(model, "shape", p)));
    fmt::print(" {} |", gathered.median(key_of(model, "l2", whole)));
    for (std::size_t p = 0; p < parts; ++p) fmt::print(" {} |", gathered.median(key_of(model, "energy", p)));
    fmt::print("\n");
  }
  fmt::print("| noise of the truth |");
  for (std::size_t p = 0; p < parts; ++p) fmt::print(" {} |", gathered.median(key_of("", "floor", p)));
  fmt::print(" | | | | | |\n\nThe whole, not normalised, by e, alpha, theta_r and sigma_a.\n\n| model |");
  const auto head = [](const char* name, const auto& values) {
    for (const auto value : values) fmt::print(" {} {} |", name, value);
  };
  head("e", setting.e);
  head("alpha", setting.alpha);
  head("theta_r", setting.theta_deg);
  head("sigma_a", setting.sigma_a);
  const std::size_t columns = setting.e.size() + setting.alpha.size() + setting.theta_deg.size() + channels;
  fmt::print("\n|---|");
  for (std::size_t i = 0; i < columns; ++i) fmt::print("---|");
  fmt::print("\n");
  for (const std::string& model : models) {
    fmt::print("| {} |", model);
    for (const double e : setting.e) fmt::print(" {} |", gathered.median(key_of(model, "e", e)));
    for (const double alpha : setting.alpha) fmt::print(" {} |", gathered.median(key_of(model, "alpha", alpha)));
    for (const double theta : setting.theta_deg) fmt::print(" {} |", gathered.median(key_of(model, "theta", theta)));
    for (std::size_t c = 0; c < channels; ++c)
      fmt::print(" {} |", gathered.median(key_of(model, "channel", double(c))));
    fmt::print("\n");
  }
}

int run(const Setting& setting) {
  struct Rival {
    std::string name;
    std::unique_ptr<fiber::FiberModel> model;
    const fiber::ModelInfo* tuned = nullptr;  ///< fair: this model, its widths and energies
    double seconds = 0;
    long evaluations = 0;
  };
  std::vector<Rival> rivals;
  for (const fiber::ModelInfo& info : references::models()) {
    if (!setting.model.empty() && setting.model != info.name) continue;
    auto model = info.make({fiber::Estimator::exact, nullptr, 0});
    if (!model->evaluates()) continue;
    const std::string name = info.name;
    rivals.push_back({.name = name, .model = std::move(model)});
    if (setting.fair && (name == "deon2011" || name == "marschner2003" || name == "ou2012")) {
      rivals.push_back({.name = name + " fair", .model = nullptr, .tuned = &info});
    }
  }
  if (rivals.empty()) {
    fmt::print(stderr, "no model of that name that can be evaluated\n");
    return 2;
  }
  const std::string commit = output_of("git rev-parse --short HEAD 2>/dev/null");
  const std::vector<Cell> cells = all_cells(setting);
  Gathered gathered;
  double truth_seconds = 0;
  std::vector<std::string> lines;
  for (std::size_t n = 0; n < cells.size(); ++n) {
    const Cell& cell = cells[n];
    double start = cpu_seconds();
    const Truth truth(trace(cell, setting, n));
    truth_seconds += cpu_seconds() - start;
    nlohmann::ordered_json line{{"e", cell.e},
                                {"alpha", cell.alpha},
                                {"theta_deg", cell.theta_deg},
                                {"phi_deg", cell.phi_deg},
                                {"energy", to_json(truth.energy)},
                                {"floor", to_json(truth.floor)}};
    for (std::size_t p = 0; p < parts; ++p) {
      for (std::size_t c = 0; c < channels; ++c) gathered.add(key_of("", "floor", p), truth.floor[c][p]);
    }
    for (Rival& rival : rivals) {
      start = cpu_seconds();
      const Prediction prediction =
          rival.tuned != nullptr
              ? fair(*rival.tuned, cell, setting, truth)
              : predict(*rival.model, rival.model->add_fiber(parameters_of(cell, setting)), known_of(cell));
      rival.seconds += cpu_seconds() - start;
      rival.evaluations += prediction.evaluations;
      const Errors errors(prediction.flux, truth);
      line["models"][rival.name] = {
          {"shape", to_json(errors.shape)}, {"l2", to_json(errors.l2)}, {"energy", to_json(errors.energy)}};
      for (std::size_t c = 0; c < channels; ++c) {
        for (std::size_t p = 0; p < parts; ++p) {
          gathered.add(key_of(rival.name, "shape", p), errors.shape[c][p]);
          gathered.add(key_of(rival.name, "l2", p), errors.l2[c][p]);
          gathered.add(key_of(rival.name, "energy", p), errors.energy[c][p]);
        }
        gathered.add(key_of(rival.name, "e", cell.e), errors.l2[c][whole]);
        gathered.add(key_of(rival.name, "alpha", cell.alpha), errors.l2[c][whole]);
        gathered.add(key_of(rival.name, "theta", cell.theta_deg), errors.l2[c][whole]);
        gathered.add(key_of(rival.name, "channel", double(c)), errors.l2[c][whole]);
      }
    }
    lines.push_back(line.dump());
    if ((n + 1) % 12 == 0) fmt::print(stderr, "{} of {} cells, {:.0f} s of CPU\n", n + 1, cells.size(), cpu_seconds());
  }
  std::vector<std::string> names;
  nlohmann::ordered_json times{{"path", rounded(1e9 * truth_seconds / (double(setting.paths) * double(cells.size())))}};
  for (const Rival& rival : rivals) {
    names.push_back(rival.name);
    times[rival.name] = rounded(1e9 * rival.seconds / double(rival.evaluations));
  }
  print_tables(names, setting, gathered);
  if (setting.json.empty()) return 0;
  std::array<double, 1> load{};
  (void)getloadavg(load.data(), 1);
  const nlohmann::ordered_json context{{"commit", commit},
                                       {"compiler", __VERSION__},
                                       {"paths_a_cell", setting.paths},
                                       {"seed", setting.seed},
                                       {"tilt_deg", setting.tilt_deg},
                                       {"sigma_a", setting.sigma_a},
                                       {"parts", part_names},
                                       {"bins", {side, side}},
                                       {"cpu_seconds", rounded(cpu_seconds())},
                                       {"load", load[0]},
                                       {"ns_a_path_or_evaluation", times}};
  return bench::write_results(setting.json, fmt::format("{{\"context\": {},\n\"cells\": [\n{}\n]}}\n", context.dump(),
                                                        fmt::join(lines, ",\n")));
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Setting setting;
  CLI::App app("The far field of every model against the traced rough fiber");
  app.add_option("--paths", setting.paths, "a cell")->check(CLI::Range(2, 2000000000));
  app.add_option("--seed", setting.seed);
  app.add_option("--tilt", setting.tilt_deg, "degrees");
  app.add_option("--model", setting.model, "this one alone");
  app.add_flag("--fair", setting.fair, "rivals with the truth's energies and tuned widths too");
  app.add_option("--json", setting.json, "file to write");
  app.add_option("--e", setting.e)->delimiter(',')->check(CLI::Range(0.5, 1.0));
  app.add_option("--alpha", setting.alpha)->delimiter(',')->check(CLI::Range(0.01, 1.0));
  app.add_option("--theta", setting.theta_deg, "degrees")->delimiter(',')->check(CLI::Range(-90.0, 90.0));
  app.add_option("--phi", setting.phi_deg, "degrees")->delimiter(',');
  CLI11_PARSE(app, argc, argv);
  return tress::run(setting);
}
