// The tress command: finds the command for the words, and returns the exit status.
#include "cli/commands.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/nearest_word.h"
#include "cli/cache_commands.h"
#include "cli/console.h"
#include "cli/groom_commands.h"
#include "cli/manual.h"
#include "cli/options.h"
#include "cli/picture_commands.h"
#include "cli/process.h"
#include "scene/read/mapped_file.h"
#include "tress/version.h"
#include "tress_commit.h"

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

/// Options of other renderers or later versions, with the nearest option here.
const std::map<std::string, std::string>& known_elsewhere() {
  static const std::map<std::string, std::string> known{{"--samples", "--spp"}, {"--cache", "--warm-cache"}};
  return known;
}

bool is_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && (std::isalpha(static_cast<unsigned char>(word[1])) || word[1] == '-') &&
         !parse_number(word) && word != "-nan" && word != "-inf";
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

/// Whether the command may take a word where a command could stand.
bool takes_arguments(const CLI::App& app) {
  return std::ranges::any_of(app.get_options(), [](const CLI::Option* option) { return option->get_positional(); });
}

/// The commands that tress had until version 0.2 and that tress-lab has now.
constexpr std::array<std::string_view, 4> laboratory_commands{"fit", "far-field", "lobes", "measure"};

/// A message about the first word that is no command or option, with the nearest one; empty if all words are known.
/// CLI11 would only say that it did not expect the word.
std::string unknown_word(const CLI::App& root, const std::vector<std::string>& words) {
  const CLI::App* app = &root;
  std::string path = root.get_name();
  std::size_t at = 0;
  for (std::vector<std::string> commands = command_names(*app); !commands.empty(); commands = command_names(*app)) {
    if (at == words.size() || is_option(words[at])) break;
    if (std::find(commands.begin(), commands.end(), words[at]) == commands.end()) {
      if (takes_arguments(*app)) break;
      if (app == &root && std::ranges::find(laboratory_commands, words[at]) != laboratory_commands.end())
        return fmt::format("{} {}: this command is in {}", path, words[at], laboratory_program);
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

int wrong_usage(const CLI::App& app, const std::string& message) {
  log_error(message);
  fmt::print(stderr, "usage: {} {} ...; --help says more\n", app.get_name(), joined(command_names(app), "|"));
  return 2;
}

/// "tress 0.2.0 (commit 1234567)" and the libraries it was built with.
std::string version_text() {
  const std::string commit = TRESS_COMMIT;
  return fmt::format("tress {}{}\nreads and writes warm caches of format {} and telemetry of schema {}\nbuilt with {}",
                     version(), commit.empty() ? "" : fmt::format(" (commit {})", commit), cache_format_version,
                     telemetry_schema_version, TRESS_LIBRARIES);
}

/// The settings of tress help.
struct HelpSettings {
  std::vector<std::string> words;  ///< names of a command; empty: the whole program
  bool manual = false;
  std::string completion;  ///< shell to write a completion for; empty: none
};

int run_help(const CLI::App& tress, const HelpSettings& settings) {
  const CLI::App* app = &tress;
  std::string path = tress.get_name();
  for (const std::string& word : settings.words) {
    const std::vector<std::string> names = command_names(*app);
    if (std::ranges::find(names, word) == names.end()) {
      throw WrongUsage(names.empty()
                           ? fmt::format("{} has no commands, found \"{}\"", path, word)
                           : fmt::format("{}: no command \"{}\", nearest: {}", path, word, nearest_word(word, names)));
    }
    app = app->get_subcommand(word);
    path += " " + word;
  }
  if (!settings.completion.empty()) {
    fmt::print("{}", settings.completion == "bash" ? bash_completion(tress) : zsh_completion(tress));
  } else if (settings.manual) {
    fmt::print("{}", manual_page(*app, path));
  } else {
    fmt::print("{}", app->get_formatter()->make_help(app, path, CLI::AppFormatMode::Normal));
  }
  return 0;
}

Command add_help(CLI::App& tress) {
  const auto settings = std::make_shared<HelpSettings>();
  CLI::App* help = tress.add_subcommand("help", "Print the options of a command, or write its manual page");
  help->add_option("COMMAND", settings->words, "as in: tress help cache merge")->type_name("");
  auto* manual = help->add_flag("--man", settings->manual, "as a manual page: tress help render --man | man -l -");
  add_choice(
      help, "--completion", {"bash", "zsh"}, [settings](const std::string& shell) { settings->completion = shell; },
      "the completion script of this shell")
      ->excludes(manual);
  return {help, [&tress, settings] { return run_help(tress, *settings); }};
}

constexpr const char* examples =
    "Examples:\n"
    "  tress render mine.hair -o mine.exr                        a bare file of strands is a scene\n"
    "  tress render mine.hair -o a.exr --warm-cache mine.cache   the next shot starts calibrated\n"
    "  tress info mine.abc                                       what is in a groom, and what will not be used\n"
    "  tress diff a.exr b.exr                                    how far two pictures are apart\n"
    "  tress help render                                         all options of a command";

/// Leaves hidden options out.
class ShownOptions final : public CLI::Formatter {
 public:
  std::string make_group(std::string group, bool is_positional,
                         std::vector<const CLI::Option*> options) const override {
    return group == hidden_group ? "" : CLI::Formatter::make_group(std::move(group), is_positional, std::move(options));
  }
};

int run_checked(int argc, char** argv, const Program& program) {
  CLI::App app("Renders hair whose fibers have elliptical cross-sections, learning its scattering tables on the way",
               program.name);
  app.formatter(std::make_shared<ShownOptions>());  // commands that are added later have it too
  app.require_subcommand(1);
  app.set_version_flag("--version", version_text());
  app.footer(examples);
  std::vector<Command> commands{add_render(app, {argv, argv + argc}),
                                add_diff(app),
                                add_info(app),
                                add_convert(app),
                                add_denoise(app),
                                add_merge(app),
                                add_report(app)};
  for (const auto& add : program.commands) commands.push_back(add(app));
  for (const Command& command : add_farm(app)) commands.push_back(command);
  CLI::App* cache = app.add_subcommand("cache", "Look into warm caches, merge them, make one beforehand, or make room");
  cache->require_subcommand(1);
  for (const auto& add : {add_cache_info, add_cache_verify, add_cache_merge, add_cache_prebake, add_cache_prune}) {
    commands.push_back(add(*cache));
  }
  commands.push_back(add_help(app));

  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (words.size() >= 2 && words[0] == "cache" && words[1] == "help") std::swap(words[0], words[1]);
  if (const std::string message = unknown_word(app, words); !message.empty()) return wrong_usage(app, message);
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version print to standard output
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
      const CLI::App& asked = cache->parsed() ? *cache : app;
      if (asked.get_subcommands().empty()) {
        const int status = wrong_usage(app, "expected a command: " + joined(command_names(asked), "|"));
        for (const CLI::App* command : asked.get_subcommands([](const CLI::App*) { return true; })) {
          fmt::print(stderr, "  {:8} {}\n", command->get_name(), command->get_description());
        }
        if (&asked == &app) fmt::print(stderr, "{}\n", examples);
        return status;
      }
    }
    return wrong_usage(app, error.what());
  }
  const auto asked = std::ranges::find_if(commands, [](const Command& command) { return command.app->parsed(); });
  try {
    return asked->run();
  } catch (const WrongUsage& error) {
    return wrong_usage(app, error.what());
  }
}

/// Handles SIGBUS, which the system sends if another program truncates a groom while it is read: logs an error and
/// exits. For any other mapping the signal keeps its default action.
void report_cut_file(int, siginfo_t* info, void*) {
  const char* name = scene::name_of_mapping(info->si_addr);
  if (name == nullptr) {
    ::signal(SIGBUS, SIG_DFL);  // the same access raises it again
    return;
  }
  for (const std::string_view part :
       {std::string_view("tress: error: "), std::string_view(name),
        std::string_view(": expected a file that stays as it is while it is read, found one that was cut meanwhile\n")})
    if (::write(STDERR_FILENO, part.data(), part.size()) < 0) break;
  ::_exit(1);
}

}  // namespace

int run(int argc, char** argv, const Program& program) {
  prepare_standard_streams();
  struct sigaction on_cut_file = {};
  on_cut_file.sa_sigaction = report_cut_file;
  on_cut_file.sa_flags = SA_SIGINFO;
  ::sigaction(SIGBUS, &on_cut_file, nullptr);
  int status = 1;
  try {
    status = run_checked(argc, argv, program);
  } catch (const std::bad_alloc&) {
    log_error("memory: expected more, found none left; what had been saved is as it was");
  } catch (const std::system_error& error) {
    const bool no_thread = error.code() == std::errc::resource_unavailable_try_again;
    if (std::ferror(stdout) == 0)
      log_error(no_thread ? "memory: expected enough for one more thread, found none left" : error.what());
  } catch (const std::exception& error) {
    if (std::ferror(stdout) == 0) log_error(error.what());  // otherwise it is logged below
  }
  if (const std::optional<Error> error = flush_results()) {
    log_error(error->message());
    status = std::max(status, 1);
  }
  return status;
}

}  // namespace tress::cli
