// tress-lab measure: the fiber that scatters light as a goniophotometer measured it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "base/pi.h"
#include "cli/console.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "cli/process.h"
#include "lab/commands.h"
#include "lab/fiber_fit.h"
#include "scene/model/parameters.h"
#include "scene/read/input_files.h"
#include "tress/base/replace_file.h"

namespace tress::lab {
namespace {

using namespace cli;

/// Of the source and the detector, in degrees. Each is an option and a key of the file.
constexpr std::array<const char*, 3> geometry_keys{"incidence", "rotation", "detector"};
using Geometry = std::array<std::optional<double>, geometry_keys.size()>;

struct MeasureSettings {
  FiberFitRequest request;
  Geometry geometry;
  std::filesystem::path file;
  std::optional<std::filesystem::path> residuals;
  std::vector<std::string> held;  ///< NAME=VALUE
  bool has_medulla = false;
  std::optional<int> threads;
};

std::vector<std::string> split_words(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// Reads "# incidence 40" or "# incidence 40 degrees"; other comments are skipped.
std::optional<Error> read_key(const std::vector<std::string>& words, Geometry& geometry) {
  if (words.empty()) return std::nullopt;
  const auto key = std::ranges::find(geometry_keys, words[0]) - geometry_keys.begin();
  if (key == std::ssize(geometry_keys) || (words.size() != 2 && !(words.size() > 2 && parse_number(words[1]))))
    return std::nullopt;
  const scene::Parameter& parameter = scene::option_parameter("--" + words[0]);
  const std::optional<double> value = parse_number(words[1]);
  const bool is_unit = words.size() == 2 || (words.size() == 3 && words[2] == "degrees");
  if (!value || !parameter.range.contains(*value) || !is_unit)
    return Error{"", "", fmt::format("# {} and {}", words[0], scene::words(parameter)), joined(words, " ")};
  auto& place = geometry[static_cast<std::size_t>(key)];
  if (place) return Error{"", "", "one " + words[0], "a second one"};
  place = value;
  return std::nullopt;
}

std::optional<Error> read_row(const std::vector<std::string>& words, std::vector<GonioSample>& samples) {
  if (words.empty()) return std::nullopt;
  std::vector<double> numbers;
  for (const std::string& word : words) {
    if (const std::optional<double> number = parse_number(word)) numbers.push_back(*number);
  }
  if (words.size() != 3 || numbers.size() != 3)
    return Error{"", "", "three numbers: phi theta value", joined(words, " ")};
  constexpr scene::Range phi{-360, 360}, theta{-90, 90};
  if (!phi.contains(numbers[0])) return Error{"", "", "phi within -360..360 degrees", words[0]};
  if (!theta.contains(numbers[1])) return Error{"", "", "theta within -90..90 degrees", words[1]};
  samples.push_back({numbers[0] * degree, numbers[1] * degree, numbers[2]});
  return std::nullopt;
}

/// Reads the samples, and those angles that no option gives.
std::optional<Error> read_measurement(MeasureSettings& s) {
  const auto bytes = scene::read_input_file(s.file, "a measurement, rows of phi theta value", 1 << 28);
  if (!bytes) return bytes.error();
  std::istringstream text(std::string(bytes->begin(), bytes->end()));
  Geometry in_file;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    const std::size_t mark = line.find('#');
    std::optional<Error> error = read_row(split_words(line.substr(0, mark)), s.request.samples);
    if (!error && mark != std::string::npos) error = read_key(split_words(line.substr(mark + 1)), in_file);
    if (!error) continue;
    error->file = s.file.string();
    error->place = fmt::format("line {}", number);
    return error;
  }
  for (std::size_t k = 0; k < in_file.size(); ++k) {
    if (!s.geometry[k]) s.geometry[k] = in_file[k];
  }
  const auto wrong = [&](const std::string& expected, const std::string& found) {
    return Error{s.file.string(), "", expected, found};
  };
  if (!s.geometry[0]) return wrong("# incidence DEGREES, or the option --incidence", "neither");
  const std::size_t least = fiber_numbers.size() + 2;
  if (s.request.samples.size() < least)
    return wrong(fmt::format("{} rows or more", least), fmt::format("{}", s.request.samples.size()));
  if (std::ranges::all_of(s.request.samples, [](const GonioSample& sample) { return !(sample.value > 0); }))
    return wrong("a value above 0", "none");
  s.request.incidence = *s.geometry[0] * degree;
  if (s.geometry[1]) s.request.rotation = *s.geometry[1] * degree;
  s.request.detector = s.geometry[2].value_or(3) * degree;
  return std::nullopt;
}

/// Sets what is held; a message about what is wrong with it, empty if all is well.
std::string hold_numbers(MeasureSettings& s) {
  for (std::size_t n = first_of_medulla; n < fiber_numbers.size() && !s.has_medulla; ++n) s.request.held[n] = 0;
  for (const std::string& text : s.held) {
    const std::size_t sign = text.find('=');
    const auto number = std::ranges::find(fiber_numbers, text.substr(0, sign), &FiberNumber::name);
    if (sign == std::string::npos || number == fiber_numbers.end()) {
      std::vector<std::string> names;
      for (const FiberNumber& one : fiber_numbers) names.emplace_back(one.name);
      return fmt::format("--fix: expected NAME=VALUE with one of {}, found {}", joined(names, "|"), text);
    }
    const std::optional<double> value = parse_number(text.substr(sign + 1));
    if (!value || !number->range.contains(*value))
      return fmt::format("--fix: expected {} within {}..{}, found {}", number->name, number->range.least,
                         number->range.most, text.substr(sign + 1));
    s.request.held[static_cast<std::size_t>(number - fiber_numbers.begin())] = value;
  }
  return {};
}

void print_fiber(const MeasureSettings& s, const FiberFit& fit) {
  const FiberFitRequest& request = s.request;
  fmt::print("{} samples, incidence {}, rotation {}, detector {} degrees; {} candidates of {} paths\n\n",
             request.samples.size(), *s.geometry[0], s.geometry[1] ? fmt::format("{}", *s.geometry[1]) : "averaged",
             s.geometry[2].value_or(3), fit.candidates, request.paths);
  for (std::size_t n = 0; n < fiber_numbers.size(); ++n) {
    const FiberNumber& number = fiber_numbers[n];
    const double value = fit.values[n];
    if (n >= first_of_medulla && request.held[first_of_medulla] == 0.0) continue;
    if (request.held[n]) {
      fmt::print("{:20}{:.5g} held\n", number.name, value);
      continue;
    }
    const double near_end = 1e-6 * (number.range.most - number.range.least);
    const bool at_end = value - number.range.least < near_end || number.range.most - value < near_end;
    fmt::print("{:20}{:.5g} +- {:.2g}{}\n", number.name, value, fit.errors[n],
               at_end ? ", at the end of its range" : "");
  }
  fmt::print("{:20}{:.5g}\n{:20}{:.3g}\n{:20}{:.3g}\n", "scale", fit.scale, "residual", fit.residual, "noise",
             fit.noise);
}

std::optional<Error> write_residuals(const std::filesystem::path& file, const FiberFitRequest& request,
                                     const FiberFit& fit) {
  std::string text = "phi\ttheta\tvalue\tfitted\tdifference\n";
  for (std::size_t i = 0; i < request.samples.size(); ++i) {
    const GonioSample& sample = request.samples[i];
    text += fmt::format("{:.7g}\t{:.7g}\t{:.7g}\t{:.7g}\t{:.7g}\n", sample.phi / degree, sample.theta / degree,
                        sample.value, fit.light[i], sample.value - fit.light[i]);
  }
  return replace_file(file, text);
}

int run_measure(MeasureSettings& s) {
  std::optional<Error> error = read_measurement(s);
  if (!error && s.residuals) error = check_output(*s.residuals);
  if (error) {
    log_error(error->message());
    return 1;
  }
  return run_threaded(s.threads, [&](int) {
    const FiberFit fit = fit_fiber(s.request);
    print_fiber(s, fit);
    if (!s.residuals) return 0;
    if (const std::optional<Error> unwritten = write_residuals(*s.residuals, s.request, fit)) {
      log_error(unwritten->message());
      return 1;
    }
    cli::remove_leftovers(*s.residuals);
    return 0;
  });
}

}  // namespace

cli::Command add_measure(CLI::App& tress) {
  const auto settings = std::make_shared<MeasureSettings>();
  MeasureSettings& s = *settings;
  CLI::App* measure = tress.add_subcommand(
      "measure", "Fit a traced fiber to the light that a goniophotometer measured, with errors and residuals");
  measure
      ->add_option("FILE", s.file,
                   "rows of phi theta value: degrees, phi from the source's azimuth, power per solid angle of any "
                   "scale; # begins a comment; # incidence 40, # rotation 0 and # detector 3 stand for the options")
      ->required()
      ->type_name("FILE");
  for (std::size_t k = 0; k < geometry_keys.size(); ++k)
    add_number(measure, std::string("--") + geometry_keys[k], [&s, k](double x) { s.geometry[k] = x; });
  add_number(measure, "--eta", [&s](double x) { s.request.eta = x; });
  measure->add_flag("--medulla", s.has_medulla, "fit the radius and the scattering of a medulla too");
  measure->add_option("--fix", s.held, "hold numbers of the fiber: --fix roughness=0.2,tilt=3")
      ->delimiter(',')
      ->type_name("NAME=VALUE,...");
  add_whole(measure, "--fit-paths", [&s](std::uint64_t n) { s.request.paths = n; });
  add_whole(measure, "--seed", [&s](std::uint64_t seed) { s.request.seed = seed; });
  add_file(measure, "--residuals", [&s](const std::string& file) { s.residuals = file; },
           "write phi, theta, value, fitted, difference of each sample", {".tsv"});
  add_threads(measure, s.threads);
  return {measure, [settings] {
            if (const std::string message = hold_numbers(*settings); !message.empty()) throw WrongUsage(message);
            return run_measure(*settings);
          }};
}

}  // namespace tress::lab
