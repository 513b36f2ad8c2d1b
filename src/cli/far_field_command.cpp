// tress far-field: what one fiber of any model does with the light of one direction.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/options.h"
#include "cli/process.h"
#include "references/far_field.h"
#include "references/registry.h"
#include "references/taught_fiber.h"
#include "scene/model/parameters.h"
#include "tress/version.h"
#include "tress_commit.h"

namespace tress::cli {
namespace {

using Json = nlohmann::ordered_json;

/// Angles in degrees, as typed. Every value in range.
struct FarFieldSettings {
  std::string model = "elliptical";  ///< of references::models()
  double eccentricity = 0.85, alpha = 0.2, tilt = 3, eta = 1.55;
  double theta_r = 30, phi_r = 45;  ///< where light comes from
  std::vector<double> sigma_a{0};   ///< per major semi-axis: grey, or three channels
  Resolution bins{36, 36};          ///< of theta_i, of phi_i
  std::uint64_t paths = 1'000'000, seed = 0;
  adaptive::Options table;
  bool loses_masked_light = false;
  bool json = false;
  std::optional<int> threads;

  std::size_t channels() const { return sigma_a.size(); }
  const fiber::ModelInfo& info() const { return *references::find_model(model); }
};

constexpr std::array<const char*, 3> channel_names{"red", "green", "blue"};

float radians(double degrees) { return static_cast<float>(degrees * std::numbers::pi / 180); }

fiber::FiberParameters parameters_of(const FarFieldSettings& s) {
  fiber::FiberParameters parameters;
  parameters.eta = static_cast<float>(s.eta);
  parameters.eccentricity = static_cast<float>(s.eccentricity);
  parameters.roughness = static_cast<float>(s.alpha);
  parameters.tilt = radians(s.tilt);
  for (std::size_t c = 0; c < channel_names.size(); ++c) {
    parameters.sigma_a[static_cast<int>(c)] = static_cast<float>(s.sigma_a[std::min(c, s.channels() - 1)]);
  }
  return parameters;
}

/// What was measured, and the rows that it was measured with.
struct Measured {
  references::Lesson lesson;
  bool has_rows = false;
  references::FarField field;
};

Measured measure(const FarFieldSettings& s) {
  adaptive::Options options = s.table;
  options.seed = s.seed;
  references::TaughtFiber fiber(s.info(), parameters_of(s), options, {.loses_masked_light = s.loses_masked_light});
  references::FarFieldRequest request;
  request.wr = {radians(s.theta_r), radians(std::remainder(s.phi_r, 360.0))};
  request.theta_bins = static_cast<std::size_t>(s.bins.width);
  request.phi_bins = static_cast<std::size_t>(s.bins.height);
  request.paths = s.paths;
  request.seed = s.seed;
  Measured measured;
  measured.has_rows = fiber.has_rows();
  measured.lesson = fiber.teach([&](RandomStream&) { return request.wr; }, s.seed);
  measured.field = references::far_field(fiber.model(), fiber.fiber(), request);
  return measured;
}

void warn_of_rows(const Measured& measured) {
  const references::Lesson& lesson = measured.lesson;
  if (lesson.open + lesson.refused == 0) return;
  log_warning(fmt::format("{} of {} rows did not converge ({} refused); those are traced", lesson.open + lesson.refused,
                          lesson.converged + lesson.open + lesson.refused, lesson.refused));
}

/// To 7 digits: more are noise.
double rounded(double x) { return std::stod(fmt::format("{:.7g}", x)); }

template <class Values>
Json by_channel(const Values& values, std::size_t channels) {
  Json json = Json::array();
  for (std::size_t c = 0; c < channels; ++c) json.push_back(rounded(values[c]));
  return json;
}

/// [channel][theta_i][phi_i].
Json bins_by_channel(const std::array<std::vector<double>, 3>& bins, const FarFieldSettings& s) {
  Json json = Json::array();
  for (std::size_t c = 0; c < s.channels(); ++c) {
    Json channel = Json::array();
    for (std::size_t i = 0; i < bins[c].size(); ++i) {
      if (i % static_cast<std::size_t>(s.bins.height) == 0) channel.push_back(Json::array());
      channel.back().push_back(rounded(bins[c][i]));
    }
    json.push_back(std::move(channel));
  }
  return json;
}

Json channels_of(const FarFieldSettings& s) {
  if (s.channels() == 1) return Json::array({"grey"});
  return Json(channel_names);
}

Json conventions() {
  return {{"frame",
           "u tangent from root to tip, v major axis, w minor axis; directions point away from the fiber: "
           "(sin theta, cos theta cos phi, cos theta sin phi)"},
          {"light",
           "comes in from (theta_r_deg, phi_r_deg), uniform over the projected width, and is told where it "
           "leaves, (theta_i, phi_i)"},
          {"flux",
           "fraction of the intercepted flux that leaves into a bin, no density: [channel][theta_i][phi_i], "
           "theta_i in equal steps from -90 degrees up, phi_i absolute from -180 up"},
          {"sigma_a", "absorption per major semi-axis; one value: grey"},
          {"lobes", "by order; GLINT is in TRT, rest is TRRT and everything later"}};
}

Json parameters_as_json(const FarFieldSettings& s) {
  return {{"eta", s.eta},        {"e", s.eccentricity},      {"alpha", s.alpha},
          {"tilt_deg", s.tilt},  {"theta_r_deg", s.theta_r}, {"phi_r_deg", s.phi_r},
          {"sigma_a", s.sigma_a}};
}

void print_json(const FarFieldSettings& s, const Measured& measured) {
  const references::FarField& field = measured.field;
  Json json{{"version", version()},
            {"commit", TRESS_COMMIT},
            {"model", s.model},
            {"conventions", conventions()},
            {"parameters", parameters_as_json(s)},
            {"masked_light", s.model == "fiber3d" && s.loses_masked_light ? "lost" : "goes on"},
            {"seed", s.seed},
            {"evaluations", field.evaluations},
            {"paths", field.paths}};
  if (measured.has_rows) {
    json["rows"] = {{"epsilon", s.info().epsilon(s.table)},
                    {"converged", measured.lesson.converged},
                    {"open", measured.lesson.open},
                    {"refused", measured.lesson.refused}};
  }
  json["bins"] = {s.bins.width, s.bins.height};
  json["channels"] = channels_of(s);
  for (std::size_t p = 0; p < references::flux_parts; ++p) {
    const references::PartialFlux& part = field.parts[p];
    json["lobes"][references::flux_part_names[p]] = {{"energy", by_channel(part.energy, s.channels())},
                                                     {"energy_error", by_channel(part.energy_error, s.channels())},
                                                     {"flux", bins_by_channel(part.flux, s)},
                                                     {"standard_error", bins_by_channel(part.standard_error, s)}};
  }
  fmt::print("{}\n", json.dump());
}

void print_table(const FarFieldSettings& s, const Measured& measured) {
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

int run_far_field(const FarFieldSettings& settings) {
  return run_threaded(settings.threads, [&](int) {
    const Measured measured = measure(settings);
    warn_of_rows(measured);
    (settings.json ? print_json : print_table)(settings, measured);
    return 0;
  });
}

bool are_bins(const std::string& text) {
  const scene::Range& range = scene::option_parameter("--bins").range;
  const std::optional<Resolution> bins = parse_resolution(text);
  return bins && range.contains(bins->width) && range.contains(bins->height);
}

void add_bins(CLI::App* far_field, FarFieldSettings& s) {
  const scene::Parameter& parameter = scene::option_parameter("--bins");
  const std::string expected = fmt::format("NxN, each {}", scene::words(parameter));
  far_field
      ->add_option_function<std::string>(
          "--bins", [&s](const std::string& text) { s.bins = *parse_resolution(text); },
          fmt::format("{}; {}; default: {}", parameter.sentence, expected, parameter.usual))
      ->check(expecting(expected, are_bins))
      ->type_name("NxN");
}

/// Empty if all is well; else wrong usage.
std::string contradiction(const FarFieldSettings& s) {
  if (s.channels() == 2) return "--sigma-a: expected 1 value or 3, found 2";
  if (s.loses_masked_light && s.model != "fiber3d") {
    return fmt::format("--lose-masked: expected --model fiber3d, found {}", s.model);
  }
  return {};
}

}  // namespace

Command add_far_field(CLI::App& tress) {
  const auto settings = std::make_shared<FarFieldSettings>();
  FarFieldSettings& s = *settings;
  CLI::App* far_field =
      tress.add_subcommand("far-field", "Tell where one fiber of a model sends the light of a direction");
  std::vector<std::string> models;
  for (const fiber::ModelInfo& model : references::models()) models.emplace_back(model.name);
  add_choice(
      far_field, "--model", models, [&s](const std::string& name) { s.model = name; },
      "fiber model; one that has rows learns them first; default: elliptical");
  add_number(far_field, "--e", [&s](double x) { s.eccentricity = x; });
  add_number(far_field, "--alpha", [&s](double x) { s.alpha = x; });
  add_number(far_field, "--tilt", [&s](double x) { s.tilt = x; });
  add_number(far_field, "--eta", [&s](double x) { s.eta = x; });
  add_number(far_field, "--theta-r", [&s](double x) { s.theta_r = x; });
  add_number(far_field, "--phi-r", [&s](double x) { s.phi_r = x; });
  add_numbers(
      far_field, "--sigma-a", 1, 3, [&s](const auto& x) { s.sigma_a = x; },
      "absorption per major semi-axis: one value for grey, three for red, green and blue; default: 0");
  add_bins(far_field, s);
  add_whole(far_field, "--paths", [&s](std::uint64_t n) { s.paths = n; });
  add_number(far_field, "--epsilon", [&s](double x) { s.table.epsilon = s.table.sampled_epsilon = x; });
  add_whole(far_field, "--seed", [&s](std::uint64_t seed) { s.seed = seed; });
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

}  // namespace tress::cli
