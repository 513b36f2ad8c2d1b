// The far field of models with rows, as a render has them once they have converged, against the traced rough fiber:
// e x alpha x theta_r, with phi_r, the tilt of the cuticle and the sign of theta_r taking turns, three absorptions.
//
// Fluxes in bins of (theta_i, phi_i), per unit flux. Truth: two independent runs of `fiber3d`, A and B. The model is
// integrated twice, f and g, by independent points. The error,
//   sqrt(sum (f - A)(g - B) / sum A B),
// has neither the noise of the truth nor that of the integration in it. A lobe is compared where it has 1e-4 of the
// light and where the truth resolves it: |A - B| / 2 below half of it, in L2.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "references/far_field.h"
#include "references/registry.h"
#include "references/taught_fiber.h"
#include "results_file.h"

namespace tress {
namespace {

using references::FarField;
using references::flux_parts;
using references::PartialFlux;
using references::whole_flux;

constexpr double degree = std::numbers::pi / 180;
constexpr std::size_t channels = 3;
constexpr double least_energy = 1e-4, largest_noise = 0.5;

struct Setting {
  std::vector<std::string> models{"elliptical", "rough"};
  std::uint64_t paths = 300'000, points = 40'000, seed = 1;
  double epsilon = 0;
  std::array<float, channels> sigma_a{0.0f, 0.25f, 1.0f};
  std::size_t theta_bins = 120, phi_bins = 180;
  std::vector<double> e{0.5, 0.75, 0.85, 1.0}, alpha{0.05, 0.1, 0.2, 0.3}, theta_deg{0.0, 30.0, 60.0, 80.0};
  std::string json;
};

struct Cell {
  double e, alpha, theta_deg, phi_deg, tilt_deg;
};

std::vector<Cell> all_cells(const Setting& setting) {
  constexpr std::array phi_deg{10.0, 45.0, 80.0};
  constexpr std::array tilt_deg{0.0, 3.0};
  std::vector<Cell> cells;
  for (const double e : setting.e) {
    for (const double alpha : setting.alpha) {
      for (const double theta : setting.theta_deg) {
        const std::size_t n = cells.size(), round = n / setting.theta_deg.size();
        const double sign = (n + round / 2) % 3 == 0 ? -1 : 1;
        cells.push_back({e, alpha, sign * theta, phi_deg[(n + round) % 3], tilt_deg[(n + round) % 2]});
      }
    }
  }
  return cells;
}

FarField measure(const fiber::ModelInfo& info, const Cell& cell, const Setting& setting, std::uint64_t run,
                 references::TaughtFiber& taught) {
  const bool is_truth = !info.has_rows();
  references::FarFieldRequest request;
  request.wr = {static_cast<float>(cell.theta_deg * degree), static_cast<float>(cell.phi_deg * degree)};
  request.theta_bins = setting.theta_bins;
  request.phi_bins = setting.phi_bins;
  // Narrow lobes need more points. Where `elliptical` traces them anew at each, they are left at the fewest.
  const double finer = std::clamp(0.1 / cell.alpha, 1.0, 2.0);
  const double points = double(setting.points) * (info.learns_samples() ? 8 * finer * finer : 1);
  request.paths = is_truth ? setting.paths : static_cast<std::uint64_t>(points);
  request.shifts = 2;
  request.seed = setting.seed * 100 + run;
  return references::far_field(taught.model(), taught.fiber(), request);
}

references::TaughtFiber teach(const fiber::ModelInfo& info, const Cell& cell, const Setting& setting,
                              references::Lesson& lesson) {
  fiber::FiberParameters parameters;
  parameters.eccentricity = static_cast<float>(cell.e);
  parameters.roughness = static_cast<float>(cell.alpha);
  parameters.tilt = static_cast<float>(cell.tilt_deg * degree);
  parameters.sigma_a = {setting.sigma_a[0], setting.sigma_a[1], setting.sigma_a[2]};
  adaptive::Options options;
  if (setting.epsilon > 0) options.epsilon = options.sampled_epsilon = setting.epsilon;
  options.seed = setting.seed;
  references::TaughtFiber taught(info, parameters, options);
  const fiber::FiberDirection wr{static_cast<float>(cell.theta_deg * degree),
                                 static_cast<float>(cell.phi_deg * degree)};
  lesson = taught.teach([&](RandomStream&) { return wr; }, setting.seed);
  return taught;
}

using Values = std::array<std::array<std::optional<double>, flux_parts>, channels>;

double product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// The two runs of the truth, and where they resolve a lobe.
struct Truth {
  FarField a, b;
  double energy(std::size_t part, std::size_t c) const {
    return 0.5 * (a.parts[part].energy[c] + b.parts[part].energy[c]);
  }
  std::optional<double> noise(std::size_t part, std::size_t c) const {
    const std::vector<double>&one = a.parts[part].flux[c], &other = b.parts[part].flux[c];
    const double power = product(one, other);
    if (energy(part, c) < least_energy || !(power > 0)) return std::nullopt;
    const double off = product(one, one) + product(other, other) - 2 * power;
    const double noise = 0.5 * std::sqrt(std::max(off, 0.0) / power);
    return noise < largest_noise ? std::optional(noise) : std::nullopt;
  }
};

struct Errors {
  Values l2, energy;  ///< energy: ours over theirs less 1 for the whole, else ours less theirs over all that leaves

  Errors(const FarField& f, const FarField& g, const Truth& truth) {
    for (std::size_t c = 0; c < channels; ++c) {
      for (std::size_t p = 0; p < flux_parts; ++p) {
        if (!truth.noise(p, c)) continue;
        const std::vector<double>&a = truth.a.parts[p].flux[c], &b = truth.b.parts[p].flux[c];
        const std::vector<double>&one = f.parts[p].flux[c], &other = g.parts[p].flux[c];
        const double square = product(one, other) - product(one, b) - product(a, other) + product(a, b);
        l2[c][p] = std::sqrt(std::max(square, 0.0) / product(a, b));
        const double ours = 0.5 * (f.parts[p].energy[c] + g.parts[p].energy[c]);
        energy[c][p] = (ours - truth.energy(p, c)) / truth.energy(whole_flux, c);
      }
    }
  }
};

nlohmann::json to_json(const Values& values) {
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& channel : values) {
    nlohmann::json row = nlohmann::json::array();
    for (const auto& value : channel)
      row.push_back(value ? nlohmann::json(std::round(*value * 1e5) / 1e5) : nlohmann::json());
    rows.push_back(row);
  }
  return rows;
}

/// Values by name, and their median and 90 %.
class Gathered {
 public:
  void add(const std::string& key, const std::optional<double>& value) {
    if (value) values_[key].push_back(std::abs(*value));
  }
  std::string text_of(const std::string& key) {
    std::vector<double>& all = values_[key];
    if (all.empty()) return "-";
    std::ranges::sort(all);
    const auto at = [&](double share) {
      return all[std::min(all.size() - 1, std::size_t(share * double(all.size())))];
    };
    return fmt::format("{:.4f} / {:.4f}", at(0.5), at(0.9));
  }
  std::string largest(const std::string& key) {
    std::vector<double>& all = values_[key];
    return all.empty() ? "-" : fmt::format("{:.4f}", std::ranges::max(all));
  }

 private:
  std::map<std::string, std::vector<double>> values_;
};

template <class... Parts>
std::string key_of(const Parts&... parts) {
  std::string key;
  ((key += fmt::format("{} ", parts)), ...);
  return key;
}

void gather(Gathered& gathered, const std::string& model, const Cell& cell, const Errors& errors) {
  for (std::size_t c = 0; c < channels; ++c) {
    for (std::size_t p = 0; p < flux_parts; ++p) {
      gathered.add(key_of(model, "lobe", p), errors.l2[c][p]);
      gathered.add(key_of(model, "energy", p), errors.energy[c][p]);
    }
    const auto& whole = errors.l2[c][whole_flux];
    gathered.add(key_of(model, "sigma_a", c), whole);
    gathered.add(key_of(model, "e", cell.e), whole);
    gathered.add(key_of(model, "alpha", cell.alpha), whole);
    gathered.add(key_of(model, "theta_r", std::abs(cell.theta_deg)), whole);
    gathered.add(key_of(model, "tilt", cell.tilt_deg), whole);
  }
}

void print_tables(const Setting& setting, Gathered& gathered) {
  fmt::print("Relative L2, median / 90 % over cells and absorptions.\n\n| model |");
  for (const char* part : references::flux_part_names) fmt::print(" {} |", part);
  for (const float sigma_a : setting.sigma_a) fmt::print(" whole, sigma_a {} |", sigma_a);
  fmt::print("\n");
  for (const std::string& model : setting.models) {
    fmt::print("| {} |", model);
    for (std::size_t p = 0; p < flux_parts; ++p) fmt::print(" {} |", gathered.text_of(key_of(model, "lobe", p)));
    for (std::size_t c = 0; c < channels; ++c) fmt::print(" {} |", gathered.text_of(key_of(model, "sigma_a", c)));
    fmt::print("\n");
  }
  const auto by = [&](const char* name, const std::vector<double>& values) {
    fmt::print("\n| whole, by {} |", name);
    for (const double x : values) fmt::print(" {} |", x);
    fmt::print("\n");
    for (const std::string& model : setting.models) {
      fmt::print("| {} |", model);
      for (const double x : values) fmt::print(" {} |", gathered.text_of(key_of(model, name, x)));
      fmt::print("\n");
    }
  };
  by("e", setting.e);
  by("alpha", setting.alpha);
  by("theta_r", setting.theta_deg);
  by("tilt", {0.0, 3.0});
  fmt::print("\n| energy off, of all that leaves, median / 90 %; largest |");
  for (const char* part : references::flux_part_names) fmt::print(" {} |", part);
  fmt::print("\n");
  for (const std::string& model : setting.models) {
    fmt::print("| {} |", model);
    for (std::size_t p = 0; p < flux_parts; ++p) {
      fmt::print(" {}; {} |", gathered.text_of(key_of(model, "energy", p)),
                 gathered.largest(key_of(model, "energy", p)));
    }
    fmt::print("\n");
  }
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

int run(const Setting& setting) {
  std::vector<const fiber::ModelInfo*> infos;
  for (const std::string& model : setting.models) {
    infos.push_back(references::find_model(model));
    if (infos.back() == nullptr || !infos.back()->has_rows()) {
      fmt::print(stderr, "{}: expected a model with rows\n", model);
      return 2;
    }
  }
  Gathered gathered;
  std::vector<std::string> lines;
  std::map<std::string, double> seconds;
  const std::vector<Cell> cells = all_cells(setting);
  for (const Cell& cell : cells) {
    double start = cpu_seconds();
    references::Lesson lesson;
    references::TaughtFiber traced = teach(fiber::fiber3d_info, cell, setting, lesson);
    const Truth truth{measure(fiber::fiber3d_info, cell, setting, 0, traced),
                      measure(fiber::fiber3d_info, cell, setting, 1, traced)};
    seconds["truth"] += cpu_seconds() - start;
    nlohmann::ordered_json line{{"e", cell.e},
                                {"alpha", cell.alpha},
                                {"theta_deg", cell.theta_deg},
                                {"phi_deg", cell.phi_deg},
                                {"tilt_deg", cell.tilt_deg}};
    Values energy, noise;
    for (std::size_t c = 0; c < channels; ++c) {
      for (std::size_t p = 0; p < flux_parts; ++p) {
        energy[c][p] = truth.energy(p, c);
        noise[c][p] = truth.noise(p, c);
      }
    }
    line["energy"] = to_json(energy);
    line["noise"] = to_json(noise);
    for (std::size_t m = 0; m < infos.size(); ++m) {
      const std::string& model = setting.models[m];
      start = cpu_seconds();
      references::TaughtFiber taught = teach(*infos[m], cell, setting, lesson);
      seconds[model + " taught"] += cpu_seconds() - start;
      start = cpu_seconds();
      const Errors errors(measure(*infos[m], cell, setting, 2, taught), measure(*infos[m], cell, setting, 3, taught),
                          truth);
      seconds[model + " measured"] += cpu_seconds() - start;
      gather(gathered, model, cell, errors);
      line["models"][model] = {{"l2", to_json(errors.l2)},
                               {"energy_off", to_json(errors.energy)},
                               {"rows", {lesson.converged, lesson.open, lesson.refused}},
                               {"passes", lesson.passes}};
    }
    lines.push_back(line.dump());
    if (lines.size() % 8 == 0) {
      fmt::print(stderr, "{} of {} cells, {:.0f} s of CPU\n", lines.size(), cells.size(), cpu_seconds());
    }
  }
  print_tables(setting, gathered);
  if (setting.json.empty()) return 0;
  const nlohmann::ordered_json context{{"compiler", __VERSION__},
                                       {"paths_a_truth", setting.paths},
                                       {"points_a_run", setting.points},
                                       {"seed", setting.seed},
                                       {"epsilon", setting.epsilon},
                                       {"sigma_a", setting.sigma_a},
                                       {"parts", references::flux_part_names},
                                       {"bins", {setting.theta_bins, setting.phi_bins}},
                                       {"cpu_seconds_by_part", seconds}};
  return bench::write_results(setting.json, fmt::format("{{\"context\": {},\n\"cells\": [\n{}\n]}}\n", context.dump(),
                                                        fmt::join(lines, ",\n")));
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Setting setting;
  CLI::App app("The far field of models with learned rows against the traced rough fiber");
  app.add_option("--model", setting.models, "models with rows")->delimiter(',');
  app.add_option("--paths", setting.paths, "of each of the two runs of the truth")->check(CLI::Range(2, 2000000000));
  app.add_option("--points", setting.points,
                 "of each of the two integrations of a model, two a bin at least; 8 times as many, and up to 32 below "
                 "alpha 0.1, of "
                 "rows of samples");
  app.add_option("--epsilon", setting.epsilon, "of rows; without it each model's default")
      ->check(CLI::Range(1e-6, 1.0));
  app.add_option("--seed", setting.seed);
  app.add_option("--theta-bins", setting.theta_bins)->check(CLI::Range(1, 720));
  app.add_option("--phi-bins", setting.phi_bins)->check(CLI::Range(1, 720));
  app.add_option("--e", setting.e)->delimiter(',')->check(CLI::Range(0.5, 1.0));
  app.add_option("--alpha", setting.alpha)->delimiter(',')->check(CLI::Range(0.01, 1.0));
  app.add_option("--theta", setting.theta_deg, "degrees; the sign takes turns")
      ->delimiter(',')
      ->check(CLI::Range(0.0, 89.9));
  app.add_option("--json", setting.json, "file to write");
  CLI11_PARSE(app, argc, argv);
  return tress::run(setting);
}
