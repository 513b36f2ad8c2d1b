// tress-lab far-field: what one fiber of any model does with the light of one direction.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/console.h"
#include "cli/options.h"
#include "cli/process.h"
#include "lab/commands.h"
#include "lab/far_field_json.h"

namespace tress::lab {
namespace {

using namespace cli;

struct Settings : FarFieldSettings {
  bool json = false;
  std::optional<int> threads;
};

void print_table(const FarFieldSettings& s, const MeasuredFarField& measured) {
  const references::FarField& field = measured.field;
  fmt::print("{}: e {}, alpha {}, tilt {}, eta {}, theta_r {}, phi_r {}, sigma_a {}\n", s.model, s.eccentricity,
             s.alpha, s.tilt, s.eta, s.theta_r, s.phi_r, fmt::join(s.sigma_a, ","));
  if (measured.has_rows)
    fmt::print("rows      {} converged to epsilon {}\n", measured.lesson.converged, s.info().epsilon(s.table));
  if (field.evaluations > 0) fmt::print("evaluated {} directions\n", field.evaluations);
  if (field.paths > 0) fmt::print("traced    {} paths\n", field.paths);
  fmt::print("\n{:10}", "energy");
  for (std::size_t c = 0; c < s.channels(); ++c) {
    fmt::print("{:>10} {:>10}", s.channels() == 1 ? "grey" : channel_names[c], "+-");
  }
  fmt::print("\n");
  for (std::size_t p = 0; p < references::flux_parts; ++p) {
    fmt::print("{:10}", references::flux_part_names[p]);
    for (std::size_t c = 0; c < s.channels(); ++c) {
      fmt::print("{:>10.6f} {:>10.1e}", field.parts[p].energy[c], field.parts[p].energy_error[c]);
    }
    fmt::print("\n");
  }
  fmt::print("\n--json has the {} x {} bins of each lobe with their standard errors\n", s.bins.width, s.bins.height);
}

int run_far_field(const Settings& settings) {
  return run_threaded(settings.threads, [&](int) {
    const MeasuredFarField measured = measure_far_field(settings);
    warn_of_rows(settings, measured);
    if (settings.json)
      fmt::print("{}\n", far_field_json(settings, measured).dump());
    else
      print_table(settings, measured);
    return 0;
  });
}

/// Empty if all is well; else wrong usage.
std::string contradiction(const Settings& s) {
  if (const std::string message = far_field_contradiction(s); !message.empty()) return message;
  if (s.loses_masked_light && s.model != "fiber3d") {
    return fmt::format("--lose-masked: expected --model fiber3d, found {}", s.model);
  }
  return {};
}

}  // namespace

cli::Command add_far_field(CLI::App& tress) {
  const auto settings = std::make_shared<Settings>();
  Settings& s = *settings;
  CLI::App* far_field =
      tress.add_subcommand("far-field", "Print where one fiber of a model sends the light of a direction");
  std::vector<std::string> models;
  for (const fiber::ModelInfo& model : references::models()) models.emplace_back(model.name);
  add_choice(
      far_field, "--model", models, [&s](const std::string& name) { s.model = name; },
      "fiber model; one that has rows learns them first; default: rough");
  add_far_field_options(far_field, s);
  far_field->add_flag("--lose-masked", s.loses_masked_light,
                      "fiber3d only: light that a facet masks is lost, as in a tracer of one facet a hit");
  add_threads(far_field, s.threads);
  far_field->add_flag("--json", s.json, "print bins, standard errors and conventions as JSON");
  add_quiet(far_field);
  return {far_field, [settings] {
            if (const std::string message = contradiction(*settings); !message.empty()) throw WrongUsage(message);
            return run_far_field(*settings);
          }};
}

}  // namespace tress::lab
