#include "cli/manual.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <functional>
#include <vector>

#include "cli/options.h"
#include "tress/version.h"

namespace tress::cli {
namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

/// The options of a command without those that are hidden.
std::vector<const CLI::Option*> shown_options(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return option->get_group() != hidden_group; });
}

/// "-o", "--output"; empty for a positional argument.
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

/// The words that an option accepts, if its values are words: "append|frozen".
std::vector<std::string> words_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  std::vector<std::string> words;
  if (type.find('|') == std::string::npos) return words;
  for (std::size_t begin = 0; begin <= type.size();) {
    const std::size_t end = std::min(type.find('|', begin), type.size());
    words.push_back(type.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

bool takes_file(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return option.get_positional() ? takes_value(option) : type.starts_with("FILE") || type == "OUT";
}

/// Escapes text for troff: a hyphen can be typed, and no line begins with a control character.
std::string troff(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '-' ? "\\-" : c == '\\' ? "\\e" : std::string(1, c);
  return out.starts_with('.') || out.starts_with('\'') ? "\\&" + out : out;
}

std::string page_options(const CLI::App& app) {
  std::string page;
  for (const CLI::Option* option : shown_options(app)) {
    std::string head;
    for (const std::string& name : names_of(*option))
      head += (head.empty() ? "" : ", ") + ("\\fB" + troff(name) + "\\fR");
    if (head.empty())
      head = "\\fI" + troff(option->get_name()) + "\\fR";
    else if (takes_value(*option))
      head += " \\fI" + troff(option->get_type_name()) + "\\fR";
    page += fmt::format(".TP\n{}\n{}\n", head, troff(option->get_description()));
  }
  return page;
}

std::string page_commands(const CLI::App& app, const std::string& path) {
  std::string page = page_options(app);
  for (const CLI::App* command : commands_of(app)) {
    const std::string name = path + " " + command->get_name();
    page +=
        fmt::format(".SS {}\n{}.\n{}", troff(name), troff(command->get_description()), page_commands(*command, name));
  }
  return page;
}

/// Calls `visit` for the command and all below it, with its path: "tress cache merge".
void visit_commands(const CLI::App& app, const std::string& path,
                    const std::function<void(const CLI::App&, const std::string&)>& visit) {
  visit(app, path);
  for (const CLI::App* command : commands_of(app)) visit_commands(*command, path + " " + command->get_name(), visit);
}

std::string spaced(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

/// Escapes text within '[...]' of zsh's _arguments, in single quotes.
std::string zsh_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'')
      out += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      out += std::string("\\") + c;
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string manual_page(const CLI::App& command, const std::string& path) {
  std::string name = path;
  for (char& c : name) c = c == ' ' ? '-' : c;
  std::string upper = name;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  std::string page = fmt::format(".TH \"{}\" 1 \"\" \"tress {}\" \"tress\"\n.ad l\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n",
                                 upper, version(), troff(name), troff(command.get_description()));
  visit_commands(command, path, [&](const CLI::App& app, const std::string& words) {
    const auto is_argument = [](const CLI::Option* option) { return option->get_positional(); };
    if (!commands_of(app).empty() && !std::ranges::any_of(shown_options(app), is_argument)) return;
    std::string line = "\\fB" + troff(words) + "\\fR [\\fIOPTIONS\\fR]";
    for (const CLI::Option* option : shown_options(app)) {
      if (!option->get_positional()) continue;
      const std::string name = "\\fI" + troff(option->get_name(true)) + "\\fR";
      line += option->get_required() ? " " + name : " [" + name + "]";
    }
    page += line + "\n.br\n";
  });
  page += ".SH OPTIONS\n" + page_commands(command, path);
  page +=
      ".SH EXIT STATUS\n0 done, 1 could not (what and why on standard error), 2 wrong usage, 130, 143 or 129 ended by "
      "a\n"
      "signal with picture, cache and telemetry saved.\n";
  if (!command.get_footer().empty()) page += ".SH EXAMPLES\n.nf\n" + troff(command.get_footer()) + "\n.fi\n";
  return page;
}

std::string bash_completion(const CLI::App& tress) {
  std::string options, values;
  visit_commands(tress, "tress", [&](const CLI::App& app, const std::string& path) {
    std::vector<std::string> words;
    for (const CLI::App* command : commands_of(app)) words.push_back(command->get_name());
    for (const CLI::Option* option : shown_options(app)) {
      const std::vector<std::string> names = names_of(*option);
      words.insert(words.end(), names.begin(), names.end());
      for (const std::string& name : names) {
        if (!takes_value(*option)) continue;
        const std::vector<std::string> choices = words_of(*option);
        const std::string what = !choices.empty()
                                     ? fmt::format("COMPREPLY=($(compgen -W '{}' -- \"$word\"))", spaced(choices))
                                 : takes_file(*option) ? std::string("COMPREPLY=($(compgen -f -- \"$word\"))")
                                                       : std::string("COMPREPLY=()");
        values += fmt::format("    '{} {}') {}; return ;;\n", path, name, what);
      }
    }
    options += fmt::format("    '{}') known='{}' ;;\n", path, spaced(words));
  });
  return fmt::format(
      R"(# Completion of tress for bash; made from the program's own options.
_tress() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} path=tress known i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$path ${{COMP_WORDS[i]}}" in
{}    esac
  done
  COMPREPLY=()
  case "$path $before" in
{}  esac
  case $path in
{}  esac
  COMPREPLY=($(compgen -W "$known" -- "$word"))
  [[ $word == -* || ${{#COMPREPLY[@]}} -gt 0 ]] || COMPREPLY=($(compgen -f -- "$word"))
}}
complete -o filenames -F _tress tress
)",
      [&] {
        std::string paths;
        visit_commands(tress, "tress", [&](const CLI::App&, const std::string& path) {
          if (path != "tress") paths += fmt::format("      '{0}') path='{0}' ;;\n", path);
        });
        return paths;
      }(),
      values, options);
}

std::string zsh_completion(const CLI::App& tress) {
  std::string text = "#compdef tress\n# Completion of tress for zsh; made from the program's own options.\n";
  visit_commands(tress, "tress", [&](const CLI::App& app, const std::string& path) {
    std::string name = "_" + path;
    for (char& c : name) c = c == ' ' ? '_' : c;
    if (name == "_tress") name = "_tress_itself";
    text += name + "() {\n  _arguments -S";
    for (const CLI::Option* option : shown_options(app)) {
      if (option->get_positional()) continue;
      const std::vector<std::string> choices = words_of(*option);
      std::string value;
      if (takes_value(*option)) {
        value = ":" + zsh_text(choices.empty() ? option->get_type_name() : std::string("value")) + ":" +
                (!choices.empty()      ? "(" + spaced(choices) + ")"
                 : takes_file(*option) ? std::string("_files")
                                       : std::string(" "));
      }
      for (const std::string& word : names_of(*option)) {
        text += fmt::format(" \\\n    '{}[{}]{}'", word, zsh_text(option->get_description()), value);
      }
    }
    std::vector<std::string> below;
    for (const CLI::App* command : commands_of(app)) below.push_back(command->get_name());
    text +=
        below.empty() ? " \\\n    '*:file:_files'\n}\n" : fmt::format(" \\\n    '1:command:({})'\n}}\n", spaced(below));
  });
  return text + R"(_tress() {
  local at=tress
  while (( CURRENT > 2 )) && [[ $words[2] != -* ]] && (( $+functions[_${at// /_}_$words[2]] )); do
    at="$at $words[2]"
    shift words
    (( CURRENT-- ))
  done
  if [[ $at == tress ]]; then _tress_itself; else _${at// /_}; fi
}
_tress "$@"
)";
}

}  // namespace tress::cli
