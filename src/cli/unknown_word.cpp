#include "cli/unknown_word.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <map>

#include "cli/argument.h"
#include "cli/nearest.h"

namespace tress::cli {
namespace {

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

/// Options that other renderers or later versions have, and what does nearly that here.
const std::map<std::string, std::string>& known_elsewhere() {
  static const std::map<std::string, std::string> known{{"--samples", "--spp"}, {"--cache", "--warm-cache"}};
  return known;
}

bool is_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && (std::isalpha(static_cast<unsigned char>(word[1])) || word[1] == '-') &&
         !parse_number(word) && word != "-nan" && word != "-inf";
}

}  // namespace

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

std::string unknown_word(const CLI::App& root, const std::vector<std::string>& words) {
  const CLI::App* app = &root;
  std::string path = "tress";
  std::size_t at = 0;
  for (std::vector<std::string> commands = command_names(*app); !commands.empty(); commands = command_names(*app)) {
    if (at == words.size() || is_option(words[at])) break;
    if (std::find(commands.begin(), commands.end(), words[at]) == commands.end()) {
      return fmt::format("{}: no command \"{}\", nearest: {}", path, words[at], nearest_word(words[at], commands));
    }
    app = app->get_subcommand(words[at]);
    path += " " + words[at++];
  }
  const std::vector<std::string> names = option_names(*app);
  const auto has = [&](const std::string& name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  for (; at < words.size() && words[at] != "--"; ++at) {
    if (!is_option(words[at])) continue;
    const bool is_long = words[at][1] == '-';
    const std::string name = is_long ? words[at].substr(0, words[at].find('=')) : words[at].substr(0, 2);
    if (has(name)) continue;
    const auto elsewhere = known_elsewhere().find(name);
    const bool use_it = elsewhere != known_elsewhere().end() && has(elsewhere->second);
    return fmt::format("{}: no option {}, nearest: {}", path, name,
                       use_it ? elsewhere->second : nearest_word(name, names));
  }
  return {};
}
}  // namespace tress::cli
