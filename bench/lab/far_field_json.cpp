#include "lab/far_field_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "cli/console.h"
#include "scene/model/parameters.h"
#include "tress/version.h"
#include "tress_commit.h"

namespace tress::lab {

using namespace cli;
namespace {

using Json = nlohmann::ordered_json;

float radians(double degrees) { return static_cast<float>(degrees * std::numbers::pi / 180); }

bool are_bins(const std::string& text) {
  const scene::Range& range = scene::option_parameter("--bins").range;
  const std::optional<Resolution> bins = parse_resolution(text);
  return bins && range.contains(bins->width) && range.contains(bins->height);
}

void add_bins(CLI::App* app, FarFieldSettings& s) {
  const scene::Parameter& parameter = scene::option_parameter("--bins");
  const std::string expected = fmt::format("NxN, each {}", scene::words(parameter));
  app->add_option_function<std::string>(
         "--bins", [&s](const std::string& text) { s.bins = *parse_resolution(text); },
         fmt::format("{}; {}; default: {}", parameter.sentence, expected, parameter.usual))
      ->check(expecting(expected, are_bins))
      ->type_name("NxN");
}

}  // namespace

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

MeasuredFarField measure_far_field(const FarFieldSettings& s) {
  adaptive::Options options = s.table;
  options.seed = s.seed;
  references::TaughtFiber fiber(s.info(), parameters_of(s), options, {.loses_masked_light = s.loses_masked_light});
  references::FarFieldRequest request;
  request.wr = {radians(s.theta_r), radians(std::remainder(s.phi_r, 360.0))};
  request.theta_bins = static_cast<std::size_t>(s.bins.width);
  request.phi_bins = static_cast<std::size_t>(s.bins.height);
  request.paths = s.paths;
  request.seed = s.seed;
  MeasuredFarField measured;
  measured.has_rows = fiber.has_rows();
  measured.lesson = fiber.teach([&](RandomStream&) { return request.wr; }, s.seed);
  measured.field = references::far_field(fiber.model(), fiber.fiber(), request);
  return measured;
}

void warn_of_rows(const FarFieldSettings& s, const MeasuredFarField& measured) {
  const references::Lesson& lesson = measured.lesson;
  if (lesson.open + lesson.refused == 0) return;
  log_warning(fmt::format("{}: {} of {} rows did not converge ({} refused); those are traced", s.model,
                          lesson.open + lesson.refused, lesson.converged + lesson.open + lesson.refused,
                          lesson.refused));
}

namespace {

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
           "comes in from (theta_r_deg, phi_r_deg), uniform over the projected width, and is counted where it "
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

}  // namespace

Json far_field_json(const FarFieldSettings& s, const MeasuredFarField& measured) {
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
  return json;
}

void add_far_field_options(CLI::App* app, FarFieldSettings& s) {
  add_number(app, "--e", [&s](double x) { s.eccentricity = x; });
  add_number(app, "--alpha", [&s](double x) { s.alpha = x; });
  add_number(app, "--tilt", [&s](double x) { s.tilt = x; });
  add_number(app, "--eta", [&s](double x) { s.eta = x; });
  add_number(app, "--theta-r", [&s](double x) { s.theta_r = x; });
  add_number(app, "--phi-r", [&s](double x) { s.phi_r = x; });
  add_numbers(
      app, "--sigma-a", 1, 3, [&s](const auto& x) { s.sigma_a = x; },
      "absorption per major semi-axis: one value for grey, three for red, green and blue; default: 0");
  add_bins(app, s);
  add_whole(app, "--paths", [&s](std::uint64_t n) { s.paths = n; });
  add_number(app, "--epsilon", [&s](double x) { s.table.epsilon = s.table.sampled_epsilon = x; });
  add_whole(app, "--seed", [&s](std::uint64_t seed) { s.seed = seed; });
}

std::string far_field_contradiction(const FarFieldSettings& s) {
  if (s.channels() == 2) return "--sigma-a: expected 1 value or 3, found 2";
  return {};
}

}  // namespace tress::lab
