#include "cli/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/nearest_word.h"
#include "cli/console.h"
#include "models/catalog.h"
#include "scene/model/parameters.h"

namespace tress::cli {

namespace {

/// The text for an option in help, manual and completion: "sentence; range; default: what".
std::string help_of(const scene::Parameter& parameter, const std::string& sentence) {
  std::string text = sentence.empty() ? std::string(parameter.sentence) : sentence;
  std::erase(text, '`');
  text += "; " + scene::words(parameter);
  if (!sentence.empty()) return text;
  if (!parameter.key.empty()) return text + "; default: the scene's";
  return parameter.usual.empty() ? text : fmt::format("{}; default: {}", text, parameter.usual);
}

std::string placeholder(const scene::Parameter& parameter) {
  if (parameter.unit == "degrees") return "DEGREES";
  if (parameter.unit == "seconds") return "SECONDS";
  if (parameter.unit == "stops") return "STOPS";
  if (parameter.unit.starts_with("MB")) return "MB";
  return parameter.kind == scene::ValueKind::whole ? "N" : "X";
}

/// Adds an option with one number, which `parse` makes of a text. An empty sentence is that of the table.
template <class Number>
CLI::Option* add_parsed(CLI::App* app, const std::string& name, std::optional<Number> (*parse)(const std::string&),
                        std::function<void(Number)> set, const std::string& sentence) {
  const scene::Parameter& parameter = scene::option_parameter(name);
  const auto is_in_range = [parse, &parameter](const std::string& text) {
    const std::optional<Number> value = parse(text);
    return value && parameter.range.contains(static_cast<double>(*value));
  };
  return app
      ->add_option_function<std::string>(
          name, [parse, set](const std::string& text) { set(*parse(text)); }, help_of(parameter, sentence))
      ->check(expecting(scene::words(parameter), is_in_range))
      ->type_name(placeholder(parameter));
}

/// The key that --set takes for the parameter of an option: that of all objects, if it is one of several.
std::string key_of(const scene::Parameter& parameter) {
  std::string key(parameter.key.substr(1));
  if (const std::size_t index = key.find("/N/"); index != std::string::npos) key.replace(index, 3, "/*/");
  return key;
}

std::string value_words(const scene::Parameter& parameter) {
  const std::vector<std::string> choices = scene::choices_of(parameter);
  if (parameter.kind == scene::ValueKind::flag) return "on or off";
  if (parameter.kind == scene::ValueKind::choice) return "one of " + joined(choices, ", ");
  if (parameter.kind == scene::ValueKind::number_or_choice)
    return fmt::format("{}, or {}", joined(choices, ", "), scene::words(parameter));
  if (parameter.kind == scene::ValueKind::numbers_by_name)
    return fmt::format("{} values separated by commas, each {}", choices.size(), scene::words(parameter));
  return scene::words(parameter);
}

/// The value of an option as --set takes it; empty if it is not one of the parameter's.
std::optional<std::string> value_of(const scene::Parameter& parameter, const std::string& given) {
  using enum scene::ValueKind;
  const std::vector<std::string> choices = scene::choices_of(parameter);
  const bool is_choice = std::ranges::find(choices, given) != choices.end();
  if (parameter.kind == text) return given;
  if (parameter.kind == flag) return given == "on" ? "true" : given == "off" ? "false" : std::optional<std::string>();
  if (parameter.kind == choice || (parameter.kind == number_or_choice && is_choice))
    return is_choice ? std::optional(given) : std::nullopt;
  const auto numbers = parse_numbers(given);
  const std::size_t count = parameter.kind == numbers_by_name ? choices.size() : parameter.kind == triple ? 3 : 1;
  if (!numbers || numbers->size() != count ||
      !std::ranges::all_of(*numbers, [&](double x) { return parameter.range.contains(x); }))
    return std::nullopt;
  if (parameter.kind == whole) return parse_unsigned(given) ? std::optional(given) : std::nullopt;
  if (parameter.kind == triple) return "[" + given + "]";
  if (parameter.kind != numbers_by_name) return fmt::format("{}", numbers->front());
  std::string object;
  for (std::size_t i = 0; i < count; ++i)
    object += fmt::format("{}\"{}\":{}", i == 0 ? "" : ",", choices[i], (*numbers)[i]);
  return "{" + object + "}";
}

}  // namespace

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

std::optional<std::int64_t> parse_signed(const std::string& text) {
  const bool is_negative = text.starts_with('-');
  const auto size = parse_unsigned(is_negative ? text.substr(1) : text);
  if (!size || *size > std::uint64_t{INT64_MAX}) return std::nullopt;
  return is_negative ? -static_cast<std::int64_t>(*size) : static_cast<std::int64_t>(*size);
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

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

CLI::Validator expecting(const std::string& expected, std::function<bool(const std::string&)> is_good) {
  return CLI::Validator(
      [=](std::string& text) {
        return is_good(text) ? std::string() : fmt::format("expected {}, found {}", expected, text);
      },
      "");
}

CLI::Option* add_number(CLI::App* app, const std::string& name, std::function<void(double)> set,
                        const std::string& sentence) {
  return add_parsed(app, name, parse_number, std::move(set), sentence);
}

CLI::Option* add_whole(CLI::App* app, const std::string& name, std::function<void(std::uint64_t)> set) {
  return add_parsed(app, name, parse_unsigned, std::move(set), "");
}

CLI::Option* add_signed(CLI::App* app, const std::string& name, std::function<void(std::int64_t)> set) {
  return add_parsed(app, name, parse_signed, std::move(set), "");
}

CLI::Option* add_numbers(CLI::App* app, const std::string& name, std::size_t least, std::size_t most,
                         std::function<void(const std::vector<double>&)> set, const std::string& sentence,
                         std::function<void(const std::string&)> set_json) {
  const scene::Parameter& parameter = scene::option_parameter(name);
  const std::string how_many = least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most);
  const auto is_json = [takes = bool(set_json)](const std::string& text) { return takes && text.starts_with('{'); };
  return app
      ->add_option_function<std::string>(
          name,
          [set, set_json, is_json](const std::string& text) {
            is_json(text) ? set_json(text) : set(*parse_numbers(text));
          },
          help_of(parameter, sentence))
      ->check(expecting(fmt::format("{} values separated by commas, each {}", how_many, scene::words(parameter)),
                        [&parameter, least, most, is_json](const std::string& text) {
                          const auto values = parse_numbers(text);
                          if (is_json(text)) return true;
                          return values && values->size() >= least && values->size() <= most &&
                                 std::ranges::all_of(*values, [&](double x) { return parameter.range.contains(x); });
                        }))
      ->type_name("X,...");
}

CLI::Option* add_flag(CLI::App* app, const std::string& name, std::function<void()> set) {
  return app->add_flag_callback(name, std::move(set), std::string(scene::option_parameter(name).sentence));
}

CLI::Option* add_choice(CLI::App* app, const std::string& name, const std::vector<std::string>& choices,
                        std::function<void(const std::string&)> set, const std::string& help,
                        std::span<const std::string_view> elsewhere) {
  const std::string words = joined(choices, "|");
  return app->add_option_function<std::string>(name, set, help)
      ->check(CLI::Validator(
          [=](std::string& text) {
            if (std::ranges::find(choices, text) != choices.end()) return std::string();
            if (std::ranges::find(elsewhere, text) != elsewhere.end())
              return fmt::format("expected {}, found {}, which is in {}", words, text, laboratory_program);
            return fmt::format("expected {}, found {} (nearest: {})", words, text, nearest_word(text, choices));
          },
          ""))
      ->type_name(words);
}

CLI::Option* add_file(CLI::App* app, const std::string& name, std::function<void(const std::string&)> set,
                      const std::string& help, const std::vector<std::string>& endings) {
  CLI::Option* option =
      app->add_option_function<std::string>(name, set, help)->type_name("FILE" + joined(endings, "|"));
  if (endings.empty()) return option;
  return option->check(expecting("a name that ends in " + joined(endings, " or "), [endings](const std::string& file) {
    std::string extension = std::filesystem::path(file).extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return std::ranges::find(endings, extension) != endings.end();
  }));
}

void add_fiber_shape(CLI::App* app, scene::Overrides& overrides) {
  add_number(app, "--eccentricity", [&overrides](double x) { overrides.eccentricity = float(x); });
  add_number(app, "--roughness", [&overrides](double x) { overrides.roughness = float(x); });
}

void add_learner(CLI::App* app, adaptive::Options& table) {
  std::vector<std::string> names;
  std::string help = "how rows are learned";
  for (const adaptive::Learner* info : fiber::learners()) {
    help += std::string(names.empty() ? ": " : "; ") + info->name + ": " + info->summary;
    names.emplace_back(info->name);
  }
  CLI::Option* learner = add_choice(
      app, "--learner", names, [&table](const std::string& name) { table.learner = fiber::find_learner(name); }, help,
      fiber::laboratory_learners());
  CLI::Option* components = add_whole(
      app, "--components", [&table](std::uint64_t n) { table.max_components = static_cast<std::uint32_t>(n); });
  if (names.size() == 1) {
    learner->group(hidden_group);
    components->group(hidden_group);
  }
  add_number(app, "--epsilon", [&table](double x) { table.hold_all_to(x); });
  add_number(app, "--table-memory", [&table](double x) { table.memory_bytes = std::size_t(x * double(1 << 20)); });
}

void add_keyed_options(CLI::App* app, std::vector<std::string>* settings) {
  for (const char* name : keyed_options) {
    const scene::Parameter& parameter = scene::option_parameter(name);
    const auto set = [settings, &parameter](const std::string& value) {
      settings->push_back(key_of(parameter) + "=" + value);
    };
    CLI::Option* option =
        name == std::string_view("--transparent")
            ? app->add_flag_callback(name, [set] { set("true"); })
            : app->add_option_function<std::string>(
                     name, [set, &parameter](const std::string& text) { set(*value_of(parameter, text)); })
                  ->check(expecting(value_words(parameter), [&parameter](const std::string& text) {
                    return value_of(parameter, text).has_value();
                  }));
    option->group(hidden_group);
  }
}

void log_replaced(const CLI::App& app) {
  for (const scene::Parameter& parameter : scene::parameters()) {
    if (parameter.key.empty() || parameter.option.empty()) continue;
    const CLI::Option* option = app.get_option_no_throw(std::string(parameter.option));
    if (option == nullptr || option->count() == 0 || option->get_group() != hidden_group) continue;
    const std::string value =
        option->get_expected_max() == 0 ? "true" : value_of(parameter, option->results().front()).value_or("");
    log_note(
        fmt::format("{} works until version 0.4: write --set '{}={}'", parameter.option, key_of(parameter), value));
  }
}

void add_threads(CLI::App* app, std::optional<int>& threads) {
  add_whole(app, "--threads", [&threads](std::uint64_t n) { threads = int(n); });
}

void add_precision(CLI::App* app, image::Precision& precision) {
  add_choice(
      app, "--precision", {"half", "float"},
      [&precision](const std::string& name) {
        precision = name == "half" ? image::Precision::half : image::Precision::full;
      },
      "half (default): 16 bits where they are enough, 32 for Z, variance and layers that halves cannot hold; float: "
      "32");
}

void add_quiet(CLI::App* app) {
  app->add_flag_callback("--quiet", quiet_console, "no progress and no notes; errors and warnings stay");
}

}  // namespace tress::cli
