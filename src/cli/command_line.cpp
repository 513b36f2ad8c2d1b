#include "cli/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <exception>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "cli/argument.h"
#include "cli/cache_command.h"
#include "cli/console.h"
#include "cli/diff_command.h"
#include "cli/fit_command.h"
#include "cli/nearest.h"
#include "cli/render_command.h"

namespace tress::cli {
namespace {

[[noreturn]] void refuse(const std::string& option, const std::string& expected, const std::string& found) {
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

/// `least` to `most` numbers in range, separated by commas.
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

glm::vec3 color_of(const std::vector<double>& x) { return glm::vec3(float(x[0]), float(x[1]), float(x[2])); }

void add_appearance(CLI::App* app, scene::Overrides& o) {
  auto* color = add_numbers(
      app, "--color", 3, 3, {0, 1, true, true}, [&o](const auto& x) { o.color = color_of(x); },
      "multiple scattering albedo R,G,B that the hair should have");
  auto* melanin = add_numbers(
      app, "--melanin", 1, 2, {0, 100},
      [&o](const auto& x) { o.melanin = {float(x[0]), x.size() > 1 ? float(x[1]) : 0.0f}; },
      "concentrations: eumelanin[,pheomelanin]");
  auto* sigma_a = add_numbers(
      app, "--sigma-a", 3, 3, {0, 1000}, [&o](const auto& x) { o.sigma_a = color_of(x); },
      "absorption R,G,B per major semi-axis");
  color->excludes(melanin)->excludes(sigma_a);
  melanin->excludes(sigma_a);
  add_number(
      app, "--eccentricity", {0.5, 1}, [&o](double x) { o.eccentricity = float(x); },
      "minor over major semi-axis of the cross-section, .5 to 1");
  add_number(
      app, "--roughness", {0.01, 1}, [&o](double x) { o.roughness = float(x); },
      "Beckmann roughness of the fiber surface, .01 to 1");
  auto* environment = app->add_option_function<std::string>(
      "--environment", [&o](const std::string& file) { o.environment_file = file; },
      "latitude-longitude picture that lights the scene");
  environment->type_name("FILE");
  add_number(
      app, "--rotate", {-36000, 36000}, [&o](double x) { o.environment_rotate_deg = x; },
      "turn of the environment about the vertical, degrees")
      ->needs(environment);
  add_choice(
      app, "--up", {"y", "z"}, [&o](const std::string& axis) { o.y_up = axis == "y"; },
      "axis of the hair file that points up");
  add_number(
      app, "--cm-per-unit", {0, 1e6, true}, [&o](double x) { o.cm_per_unit = x; }, "length of a unit of the hair file");
}

void add_learning(CLI::App* app, RenderSettings& s) {
  add_choice(
      app, "--model", {"elliptical", "exact"},
      [&s](const std::string& name) {
        if (name == "exact") s.estimator = fiber::Estimator::exact;
      },
      "fiber model; exact is elliptical with --estimator exact");
  add_choice(
      app, "--estimator", {"fitted", "exact"},
      [&s](const std::string& name) {
        s.estimator = name == "exact" ? fiber::Estimator::exact : fiber::Estimator::fitted;
      },
      "fitted: converged rows answer; exact: traced at every vertex");
  add_choice(app, "--learner", {"sketch"}, [](const std::string&) {}, "how rows are learned");
  add_number(
      app, "--epsilon", {0, 1, true}, [&s](double x) { s.table.epsilon = x; },
      "relative squared error under which a row is converged, default .01");
  add_number(
      app, "--table-memory", {0, 1 << 20}, [&s](double x) { s.table.memory_bytes = std::size_t(x * double(1 << 20)); },
      "ceiling of the table in MB (2^20 bytes), fractions too, default 256");
  auto* cache = app->add_option_function<std::string>(
      "--warm-cache", [&s](const std::string& file) { s.warm_cache = file; }, "table to start from and to save");
  cache->type_name("FILE");
  const std::map<std::string, CacheMode> modes{{"append", CacheMode::append},
                                               {"frozen", CacheMode::frozen},
                                               {"scratch", CacheMode::scratch},
                                               {"require", CacheMode::require}};
  add_choice(
      app, "--cache-mode", {"append", "frozen", "scratch", "require"},
      [&s, modes](const std::string& name) { s.cache_mode = modes.at(name); },
      "append (default): load, refine, save merged; frozen: never save; scratch: start cold and replace; "
      "require: append, but the file must be there and whole")
      ->needs(cache);
  auto* telemetry = app->add_option_function<std::string>(
      "--telemetry", [&s](const std::string& file) { s.telemetry = file; }, "convergence as JSON Lines");
  telemetry->type_name("FILE");
  add_choice(
      app, "--telemetry-level", {"pass", "rows"},
      [&s](const std::string& level) { s.telemetry_rows = level == "rows"; }, "rows: a line a changed row too")
      ->needs(telemetry);
}

CLI::App* add_render(CLI::App& app, RenderSettings& s, bool& quiet) {
  CLI::App* render = app.add_subcommand("render", "Render a scene, or a bare .hair file");
  render
      ->add_option_function<std::string>(
          "SCENE", [&s](const std::string& file) { s.scene = file; }, "scene JSON or .hair file")
      ->required();
  render
      ->add_option_function<std::string>(
          "-o,--output",
          [&s](const std::string& file) {
            if (std::filesystem::path(file).extension() != ".exr") refuse("-o", "a name that ends in .exr", file);
            s.output = file;
          },
          "picture; a .png is written beside it")
      ->required()
      ->type_name("OUT.exr");
  add_integer(render, "--spp", 1, 1 << 20, [&s](int n) { s.overrides.samples = n; }, "samples a pixel");
  render
      ->add_option_function<std::string>(
          "--resolution",
          [&s](const std::string& text) {
            const auto size = parse_resolution(text);
            if (!size || size->width < 1 || size->height < 1 || size->width > 16384 || size->height > 16384) {
              refuse("--resolution", "WxH, each from 1 to 16384", text);
            }
            s.overrides.width = size->width;
            s.overrides.height = size->height;
          },
          "size of the picture")
      ->type_name("WxH");
  add_integer(render, "--threads", 1, 1024, [&s](int n) { s.threads = n; }, "default: one per hardware thread");
  render
      ->add_option_function<std::string>(
          "--seed",
          [&s](const std::string& text) {
            const auto seed = parse_unsigned(text);
            if (!seed) refuse("--seed", "a whole number from 0 to 2^64 - 1", text);
            s.render.seed = *seed;
          },
          "same seed, same picture, for any number of threads")
      ->type_name("N");
  add_integer(
      render, "--light-samples", 1, 4096, [&s](int n) { s.render.light_samples = n; },
      "at the first fiber hit, default 1");
  add_integer(
      render, "--bcsdf-samples", 1, 4096, [&s](int n) { s.render.bcsdf_samples = n; },
      "at the first fiber hit, default 1");
  add_integer(
      render, "--max-depth", 1, 4096, [&s](int n) { s.render.max_depth = n; }, "fiber hits of a path, default 64");
  add_appearance(render, s.overrides);
  add_learning(render, s);
  render->add_flag("--quiet", quiet, "no progress and no notes");
  return render;
}

CLI::App* add_fit(CLI::App& app, FitSettings& s) {
  CLI::App* fit = app.add_subcommand("fit", "Learn one row and show it beside its reference");
  const std::map<std::string, fiber::Lobe> lobes{
      {"R", fiber::Lobe::r}, {"TT", fiber::Lobe::tt}, {"TRT", fiber::Lobe::trt}, {"TRRT", fiber::Lobe::trrt}};
  add_choice(
      fit, "--lobe", {"TT", "TRT", "TRRT", "R"}, [&s, lobes](const std::string& name) { s.lobe = lobes.at(name); },
      "lobe")
      ->required();
  add_number(fit, "--e", {0.5, 1}, [&s](double x) { s.eccentricity = x; }, "minor over major semi-axis, .5 to 1");
  add_number(fit, "--theta-d", {-89.9, 89.9}, [&s](double x) { s.theta_d = x; }, "difference angle, degrees");
  add_number(
      fit, "--phi", {-36000, 36000}, [&s](double x) { s.phi = x; },
      "azimuth of the known direction from the major axis, degrees");
  add_number(fit, "--sigma", {0.5, 45}, [&s](double x) { s.sigma = x; }, "blur of the exit azimuth, degrees");
  add_number(fit, "--eta", {1.05, 3}, [&s](double x) { s.eta = x; }, "index of refraction, default 1.55");
  add_number(fit, "--sigma-a", {0, 1000}, [&s](double x) { s.sigma_a = x; }, "absorption per major semi-axis");
  add_number(fit, "--epsilon", {0, 1, true}, [&s](double x) { s.epsilon = x; }, "default .01");
  add_integer(fit, "--samples", 1, 1 << 20, [&s](int n) { s.samples = n; }, "azimuths printed, default 360");
  auto* json = fit->add_flag("--json", s.json, "print the curves as JSON");
  fit->add_option_function<std::string>(
         "-o,--output",
         [&s](const std::string& file) {
           if (std::filesystem::path(file).extension() != ".png") refuse("-o", "a name that ends in .png", file);
           s.plot = file;
         },
         "draw the curves")
      ->type_name("plot.png")
      ->excludes(json);
  return fit;
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

/// Options that other renderers or later versions have, and what does nearly that here.
const std::map<std::string, std::string>& known_elsewhere() {
  static const std::map<std::string, std::string> known{
      {"--time", "--spp"},          {"--noise", "--spp"},   {"--crop", "--resolution"}, {"--frame", "--up"},
      {"--heatmap", "--telemetry"}, {"--samples", "--spp"}, {"--cache", "--warm-cache"}};
  return known;
}

bool is_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && (std::isalpha(static_cast<unsigned char>(word[1])) || word[1] == '-') &&
         !parse_number(word) && word != "-nan" && word != "-inf";
}

/// The first word that no command or option answers to, as a message; empty if there is none. CLI11 would only say
/// that it did not expect it.
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

/// What the parser cannot see: options that contradict each other, and files that would overwrite each other.
std::string contradiction(const CLI::App& render, const RenderSettings& s) {
  const auto given = [&](const char* name) { return render.get_option(name)->as<std::string>(); };
  if (render.count("--model") && given("--model") == "exact" && render.count("--estimator") &&
      given("--estimator") != "exact") {
    return "--estimator: expected exact with --model exact, found " + given("--estimator");
  }
  std::filesystem::path preview = s.output;
  std::vector<std::filesystem::path> files{s.scene, s.output, preview.replace_extension(".png")};
  if (s.warm_cache) files.push_back(*s.warm_cache);
  if (s.telemetry) files.push_back(*s.telemetry);
  std::set<std::filesystem::path> seen;
  for (const std::filesystem::path& file : files) {
    std::error_code error;
    const std::filesystem::path whole = std::filesystem::weakly_canonical(file, error);
    if (!error && !seen.insert(whole).second) {
      return fmt::format("{}: expected different files for scene, picture, preview, cache and telemetry",
                         file.string());
    }
  }
  return {};
}

int wrong_usage(const std::string& message) {
  fail(message);
  std::fputs("usage: tress render|fit|diff|cache ...; --help tells more\n", stderr);
  return 2;
}

int run_checked(int argc, char** argv) {
  CLI::App app("Renders hair whose fibers have elliptical cross-sections, learning its scattering tables on the way",
               "tress");
  app.require_subcommand(1);
  app.set_version_flag("--version", "tress 0.1.0");
  RenderSettings render_settings;
  bool quiet = false;
  CLI::App* render = add_render(app, render_settings, quiet);
  FitSettings fit_settings;
  CLI::App* fit = add_fit(app, fit_settings);

  DiffSettings diff_settings;
  CLI::App* diff = app.add_subcommand("diff", "Compare two pictures");
  diff->add_option("A", diff_settings.a, "picture")->required()->type_name("A.exr");
  diff->add_option("B", diff_settings.b, "picture held against A")->required()->type_name("B.exr");
  diff->add_flag("--json", diff_settings.json, "print JSON");

  CacheSettings cache_settings;
  CLI::App* cache = app.add_subcommand("cache", "Look into a warm cache");
  cache->require_subcommand(1);
  CLI::App* info = cache->add_subcommand("info", "Print model, format, pages and hash");
  CLI::App* verify = cache->add_subcommand("verify", "Exit 0 if the file is whole, 1 if it is refused");
  for (CLI::App* command : {info, verify}) {
    command->add_option("FILE", cache_settings.file, "warm cache")->required()->type_name("FILE");
    command->add_flag("--json", cache_settings.json, "print JSON");
  }

  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (const std::string message = unknown_word(app, words); !message.empty()) return wrong_usage(message);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version: standard output
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
      const CLI::App& asked = cache->parsed() ? *cache : app;
      if (asked.get_subcommands().empty()) {
        return wrong_usage("expected a command: " + joined(command_names(asked), "|"));
      }
    }
    return wrong_usage(error.what());
  }
  open_console(quiet);
  if (render->parsed()) {
    if (const std::string message = contradiction(*render, render_settings); !message.empty()) {
      return wrong_usage(message);
    }
    return run_render(render_settings);
  }
  if (fit->parsed()) return run_fit(fit_settings);
  if (diff->parsed()) return run_diff(diff_settings);
  if (info->parsed()) return run_cache_info(cache_settings);
  return run_cache_verify(cache_settings);
}

}  // namespace

int run(int argc, char** argv) {
  try {
    return run_checked(argc, argv);
  } catch (const std::exception& error) {
    fail(error.what());
    return 1;
  }
}

}  // namespace tress::cli
