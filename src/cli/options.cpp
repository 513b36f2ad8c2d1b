#include "cli/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/nearest_word.h"
#include "cli/console.h"
#include "references/registry.h"
#include "tress/adaptive/mixture.h"

namespace tress::cli {

std::string Range::words() const {
  return fmt::format("a number {} {} and {} {}", low_open ? ">" : ">=", low, high_open ? "<" : "<=", high);
}

bool Range::contains(double x) const { return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high); }

std::optional<double> parse_number(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::uint64_t> parse_unsigned(const std::string& text) {
  std::uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

std::optional<std::vector<double>> parse_numbers(const std::string& text) {
  std::vector<double> values;
  std::size_t begin = 0;
  while (true) {
    const std::size_t comma = text.find(',', begin);
    const std::optional<double> value = parse_number(text.substr(begin, comma - begin));
    if (!value) return std::nullopt;
    values.push_back(*value);
    if (comma == std::string::npos) return values;
    begin = comma + 1;
  }
}

std::optional<Resolution> parse_resolution(const std::string& text) {
  const std::size_t by = text.find('x');
  if (by == std::string::npos) return std::nullopt;
  const auto width = parse_unsigned(text.substr(0, by));
  const auto height = parse_unsigned(text.substr(by + 1));
  constexpr std::uint64_t largest = std::numeric_limits<int>::max();
  if (!width || !height || *width > largest || *height > largest) return std::nullopt;
  return Resolution{static_cast<int>(*width), static_cast<int>(*height)};
}

std::optional<image::Window> parse_crop(const std::string& text) {
  constexpr std::uint64_t largest = 1 << 24;
  std::vector<int> edges;
  std::size_t begin = 0;
  while (begin != std::string::npos) {
    const std::size_t comma = text.find(',', begin);
    const auto edge = parse_unsigned(text.substr(begin, comma == std::string::npos ? comma : comma - begin));
    if (!edge || *edge > largest) return std::nullopt;
    edges.push_back(static_cast<int>(*edge));
    begin = comma == std::string::npos ? comma : comma + 1;
  }
  if (edges.size() != 4 || edges[0] >= edges[2] || edges[1] >= edges[3]) return std::nullopt;
  return image::Window{edges[0], edges[1], edges[2] - edges[0], edges[3] - edges[1]};
}

void refuse(const std::string& option, const std::string& expected, const std::string& found) {
  throw CLI::ValidationError(option, fmt::format("expected {}, found {}", expected, found));
}

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

CLI::Option* add_number(CLI::App* app, const std::string& name, const Range& range, std::function<void(double)> set,
                        const std::string& help) {
  return app
      ->add_option_function<std::string>(
          name,
          [=](const std::string& text) {
            const std::optional<double> value = parse_number(text);
            if (!value || !range.contains(*value)) refuse(name, range.words(), text);
            set(*value);
          },
          help)
      ->type_name("X");
}

CLI::Option* add_integer(CLI::App* app, const std::string& name, int low, int high, std::function<void(int)> set,
                         const std::string& help) {
  return app
      ->add_option_function<std::string>(
          name,
          [=](const std::string& text) {
            const std::optional<std::uint64_t> value = parse_unsigned(text);
            if (!value || *value < std::uint64_t(low) || *value > std::uint64_t(high)) {
              refuse(name, fmt::format("a whole number from {} to {}", low, high), text);
            }
            set(static_cast<int>(*value));
          },
          help)
      ->type_name("N");
}

CLI::Option* add_unsigned(CLI::App* app, const std::string& name, std::function<void(std::uint64_t)> set,
                          const std::string& help) {
  return app
      ->add_option_function<std::string>(
          name,
          [=](const std::string& text) {
            const std::optional<std::uint64_t> value = parse_unsigned(text);
            if (!value) refuse(name, "a whole number from 0 to 2^64 - 1", text);
            set(*value);
          },
          help)
      ->type_name("N");
}

CLI::Option* add_numbers(CLI::App* app, const std::string& name, std::size_t least, std::size_t most,
                         const Range& range, std::function<void(const std::vector<double>&)> set,
                         const std::string& help) {
  return app
      ->add_option_function<std::string>(
          name,
          [=](const std::string& text) {
            const auto values = parse_numbers(text);
            const bool good = values && values->size() >= least && values->size() <= most &&
                              std::all_of(values->begin(), values->end(), [&](double x) { return range.contains(x); });
            if (!good) {
              const std::string how_many =
                  least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most);
              refuse(name, fmt::format("{} values separated by commas, each {}", how_many, range.words()), text);
            }
            set(*values);
          },
          help)
      ->type_name("X,...");
}

CLI::Option* add_choice(CLI::App* app, const std::string& name, const std::vector<std::string>& choices,
                        std::function<void(const std::string&)> set, const std::string& help) {
  const std::string words = joined(choices, "|");
  return app
      ->add_option_function<std::string>(
          name,
          [=](const std::string& text) {
            if (std::find(choices.begin(), choices.end(), text) == choices.end()) {
              refuse(name, words, fmt::format("{} (nearest: {})", text, nearest_word(text, choices)));
            }
            set(text);
          },
          help)
      ->type_name(words);
}

void add_fiber_shape(CLI::App* app, scene::Overrides& overrides) {
  add_number(
      app, "--eccentricity", {0.5, 1}, [&overrides](double x) { overrides.eccentricity = float(x); },
      "minor over major semi-axis of the cross-section, .5 to 1");
  add_number(
      app, "--roughness", {0.01, 1}, [&overrides](double x) { overrides.roughness = float(x); },
      "Beckmann roughness of the fiber surface, .01 to 1");
}

void add_learner(CLI::App* app, adaptive::Options& table) {
  std::vector<std::string> names;
  std::string help = "how rows are learned";
  for (const adaptive::Learner* info : references::learners()) {
    help += std::string(names.empty() ? ": " : "; ") + info->name + ": " + info->summary;
    names.emplace_back(info->name);
  }
  add_choice(
      app, "--learner", names, [&table](const std::string& name) { table.learner = references::find_learner(name); },
      help);
  add_integer(
      app, "--components", 1, adaptive::Mixture::max_components,
      [&table](int n) { table.max_components = static_cast<std::uint32_t>(n); },
      "components of a row, at most or, for learners of a fixed number, exactly; default 8");
  add_number(
      app, "--epsilon", {0, 1, true}, [&table](double x) { table.epsilon = x; },
      "relative squared error under which a row is converged, default .01");
  add_number(
      app, "--table-memory", {0, 1 << 20},
      [&table](double x) { table.memory_bytes = std::size_t(x * double(1 << 20)); },
      "ceiling of the table in MB (2^20 bytes), fractions too, default 256");
}

void add_threads(CLI::App* app, std::optional<int>& threads) {
  add_integer(app, "--threads", 1, 1024, [&threads](int n) { threads = n; }, "default: one per hardware thread");
}

void add_quiet(CLI::App* app) { app->add_flag_callback("--quiet", quiet_console, "no progress and no notes"); }

}  // namespace tress::cli
