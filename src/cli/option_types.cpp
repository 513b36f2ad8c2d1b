#include "cli/option_types.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>

#include "cli/nearest.h"

namespace tress::cli {

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
}  // namespace tress::cli
