// tress render: renders a scene to a picture.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/nearest_word.h"
#include "cli/appearance_options.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/frame_list.h"
#include "cli/model_choice.h"
#include "cli/options.h"
#include "cli/render_frames.h"
#include "integrate/path_sums.h"
#include "models/catalog.h"
#include "scene/model/parameters.h"

namespace tress::cli {
namespace {

std::vector<std::string> model_words() {
  std::vector<std::string> words;
  for (const fiber::ModelInfo& model : fiber::models()) words.emplace_back(model.name);
  words.emplace_back("exact");
  return words;
}

void add_learning(CLI::App* app, RenderSettings& s) {
  add_choice(
      app, "--model", model_words(),
      [&s](const std::string& name) {
        if (name == "exact") {
          s.model = fiber::elliptical_info.name;
          s.estimator = fiber::Estimator::exact;
        } else {
          s.model = name;
        }
      },
      "fiber model; exact is elliptical with --estimator exact. Default: by the scene's materials alone: chiang2016 "
      "where all hair is given by its lobes (principled); else elliptical where a material shapes lobes; else rough",
      fiber::laboratory_models());
  CLI::Option* points = add_whole(app, "--quadrature-points", [&s](std::uint64_t n) { s.quadrature_points = int(n); });
  if (std::ranges::none_of(fiber::models(), &fiber::ModelInfo::has_quadrature)) points->group(hidden_group);
  add_choice(
      app, "--estimator", {"fitted", "corrected", "exact"},
      [&s](const std::string& name) {
        for (const auto e : {fiber::Estimator::fitted, fiber::Estimator::corrected, fiber::Estimator::exact}) {
          if (name == fiber::estimator_name(e)) s.estimator = e;
        }
      },
      "fitted: converged rows answer; corrected: they do, and one vertex in 16 is traced to mend the bias; exact: "
      "traced at "
      "every vertex");
  add_learner(app, s.table);
  add_number(app, "--picture-error", [&s](double x) {
    s.table.picture_error = x;
    s.stop.picture_error = x;
  })->excludes(app->get_option("--epsilon"));
  add_number(app, "--measure-bias", [&s](double x) { s.audited_share = float(x); });
  auto* cache = add_file(
      app, "--warm-cache", [&s](const std::string& file) { s.warm_cache = file; },
      "table to start from and to save; the word default: the folder $XDG_CACHE_HOME/tress, else ~/.cache/tress, with "
      "a file for each kind of fiber");
  add_number(app, "--cache-limit", [&s](double x) {
    s.cache_limit = std::uint64_t(x * double(1 << 20));
  })->needs(cache);
  const std::map<std::string, CacheMode> modes{{"append", CacheMode::append},
                                               {"frozen", CacheMode::frozen},
                                               {"scratch", CacheMode::scratch},
                                               {"require", CacheMode::require}};
  add_choice(
      app, "--cache-mode", {"append", "frozen", "scratch", "require"},
      [&s, modes](const std::string& name) { s.cache_mode = modes.at(name); },
      "append (default): load, refine, save merged; frozen: use it as it is, never save; scratch: start cold and "
      "replace; "
      "require: append, but the file must be there and whole")
      ->needs(cache);
  auto* telemetry =
      add_file(app, "--telemetry", [&s](const std::string& file) { s.telemetry = file; }, "convergence as JSON Lines");
  add_choice(
      app, "--telemetry-level", {"pass", "rows"},
      [&s](const std::string& level) { s.telemetry_rows = level == "rows"; }, "rows: a line a changed row too")
      ->needs(telemetry);
}

void add_resolution(CLI::App* app, scene::Overrides& o) {
  const scene::Parameter& parameter = scene::option_parameter("--resolution");
  const auto is_good = [&parameter](const std::string& text) {
    const std::optional<Resolution> size = parse_resolution(text);
    return size && parameter.range.contains(size->width) && parameter.range.contains(size->height) &&
           std::int64_t{size->width} * size->height <= scene::most_image_pixels;
  };
  app->add_option_function<std::string>(
         "--resolution",
         [&o](const std::string& text) {
           const Resolution size = *parse_resolution(text);
           o.width = size.width;
           o.height = size.height;
         },
         fmt::format("{}; default: {}", parameter.sentence, parameter.usual))
      ->check(expecting("WxH, each " + scene::words(parameter) + ", 2^26 pixels in all", is_good))
      ->type_name("WxH");
}

/// The layers of every picture, in the order of their channels.
std::vector<std::string> layer_names() {
  std::vector<std::string> names;
  for (std::size_t layer = 0; layer < integrate::layer_count; ++layer) names.emplace_back(integrate::layer_name(layer));
  for (const char* name : {"coverage", "albedo", "N", "tangent", "Z", "variance", "samples", "ais"})
    names.emplace_back(name);
  for (const char* name : {"forward", "CryptoObject", "CryptoMaterial"}) names.emplace_back(name);
  return names;
}

std::vector<std::string> parted_by_commas(const std::string& text) {
  std::vector<std::string> words{""};
  for (const char c : text) {
    if (c == ',')
      words.emplace_back();
    else
      words.back() += c;
  }
  return words;
}

/// Sets the layers from --layers, after checking it.
void set_layers(const std::string& text, RenderSettings* s) {
  std::vector<std::string> words = parted_by_commas(text);
  s->keeps_halves = std::erase(words, half_pictures) > 0;
  s->render.data = {};
  for (const std::string& word : words) s->render.data.ask(word);
  s->layers.reset();
  if (std::ranges::find(words, "all") != words.end()) return;
  if (s->keeps_halves) words.insert(words.end(), integrate::half_layers.begin(), integrate::half_layers.end());
  s->layers = words;
}

void add_layers(CLI::App* app, RenderSettings& s) {
  std::vector<std::string> known = layer_names();
  for (const std::string_view name : {half_pictures, std::string_view("all"), std::string_view("beauty")})
    known.emplace_back(name);
  const std::vector<std::string> data_names(integrate::data_layer_names.begin(), integrate::data_layer_names.end());
  known.insert(known.end(), data_names.begin(), data_names.end());
  app->add_option_function<std::string>(
         "--layers", [&s](const std::string& text) { set_layers(text, &s); },
         fmt::format("layers of the EXR beside R, G, B, A: all (default), beauty for none, or some of {} and "
                     "light.GROUP; half besides, as in all,half: two independent half pictures for denoisers; {}: data "
                     "for compositors, which all has not",
                     joined(layer_names(), ","), joined(data_names, ",")))
      ->check(CLI::Validator(
          [known](std::string& text) {
            for (const std::string& word : parted_by_commas(text)) {
              const bool is_group = word.starts_with(light_layer) && word.size() > light_layer.size();
              if (!is_group && std::ranges::find(known, word) == known.end())
                return fmt::format("expected all, beauty or layers separated by commas, found {} (nearest: {})", word,
                                   nearest_word(word, known));
            }
            return std::string();
          },
          ""))
      ->type_name("NAME,...");
}

void add_shots(CLI::App* app, RenderSettings& s) {
  app->add_option_function<std::string>(
         "--frames", [&s](const std::string& text) { s.frames = *parse_frames(text); },
         "frames one after the other, 1-240,250,300-340x2; #### in names of files is their number; finished ones are "
         "skipped")
      ->check(expecting("frames and ranges, 1-240,250,300-340x2, each -1000000..1000000",
                        [](const std::string& text) { return parse_frames(text).has_value(); }))
      ->type_name("LIST")
      ->excludes(app->get_option("--frame"));
  add_flag(app, "--overwrite", [&s] { s.overwrite = true; })->needs(app->get_option("--frames"));
  auto* checkpoint = app->add_option_function<std::string>(
                            "--checkpoint", [&s](const std::string& file) { s.checkpoint = file == "" ? "" : file; },
                            "write how far it is from time to time, and go on from there; default: beside the output")
                         ->expected(0, 1)
                         ->default_str("")
                         ->type_name("FILE");
  add_number(app, "--checkpoint-interval", [&s](double x) { s.checkpoint_interval = x; })->needs(checkpoint);
  add_number(app, "--checkpoint-deadline", [&s](double x) { s.checkpoint_deadline = x; })->needs(checkpoint);
  for (const char* name : {"--samples-from", "--samples-to"}) {
    std::optional<int>& end = name == std::string_view("--samples-from") ? s.samples_from : s.samples_to;
    add_whole(app, name, [&end](std::uint64_t n) { end = int(n); })
        ->excludes(app->get_option("--time"))
        ->excludes(app->get_option("--noise"));
  }
  add_file(
      app, "--part", [&s](const std::string& file) { s.part = file; }, "the sums of the picture, for tress merge")
      ->excludes(app->get_option("--time"))
      ->excludes(app->get_option("--noise"));
}

void add_viewers(CLI::App* app, RenderSettings& s) {
  app->add_option_function<std::string>(
         "--display-server", [&s](const std::string& text) { s.display_server = text; },
         "show the picture as it comes in tev or HDRView, which listens there (tev: 127.0.0.1:14158)")
      ->type_name("HOST:PORT");
  auto* serve = app->add_option_function<std::string>(
                       "--serve", [&s](const std::string& text) { s.serve = text; },
                       "live page: the picture, convergence and the table; default: 127.0.0.1 and a free port")
                    ->expected(0, 1)
                    ->default_str("")
                    ->type_name("ADDRESS:PORT")
                    ->excludes(app->get_option("--frames"));
  add_file(app, "--serve-reference", [&s](const std::string& file) { s.serve_reference = file; },
           "picture that the live page can lay beside", {".exr"})
      ->needs(serve);
}

/// The options that change the picture, as they were given.
std::map<std::string, std::string> given_options(const CLI::App& render) {
  static const std::set<std::string> others{"SCENE",
                                            "--output",
                                            "--threads",
                                            "--telemetry",
                                            "--telemetry-level",
                                            "--cache-limit",
                                            "--quiet",
                                            "--frames",
                                            "--overwrite",
                                            "--checkpoint",
                                            "--checkpoint-interval",
                                            "--checkpoint-deadline",
                                            "--part",
                                            "--serve",
                                            "--serve-reference",
                                            "--display-server",
                                            "--set",
                                            "--spectral",
                                            "--progress",
                                            "--help"};
  std::map<std::string, std::string> given;
  for (const CLI::Option* option : render.get_options()) {
    const std::string name = option->get_name();
    const std::string plain = option->get_lnames().empty() ? name : "--" + option->get_lnames().front();
    // What sets a key of the scene is in the identity by that key.
    if (option->count() == 0 || others.contains(plain) || std::ranges::count(keyed_options, plain) > 0) continue;
    given[plain] = plain == "--heatmap" || plain == "--deep" ? "given" : joined(option->results(), ",");
  }
  return given;
}

/// The words in quotes where a shell needs them.
std::string as_shell_words(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    const bool plain = !word.empty() && std::ranges::all_of(word, [](unsigned char c) {
      return std::isalnum(c) || std::string_view("-_./,:=+@%").find(static_cast<char>(c)) != std::string_view::npos;
    });
    if (!text.empty()) text += ' ';
    if (plain) {
      text += word;
      continue;
    }
    text += '\'';
    for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    text += '\'';
  }
  return text;
}

/// A message about options that contradict each other or files that would overwrite each other, which the parser cannot
/// detect; empty if there are none.
std::string contradiction(const CLI::App& render, const RenderSettings& s) {
  const auto given = [&](const char* name) { return render.get_option(name)->as<std::string>(); };
  if (render.count("--model") && given("--model") == "exact" && render.count("--estimator") &&
      given("--estimator") != "exact") {
    return "--estimator: expected exact with --model exact, found " + given("--estimator");
  }
  if (const std::string message = s.model_of_scene ? refused_by_all(s.asked) : refused_option(s.asked, s.model, true);
      !message.empty()) {
    return message;
  }
  if (render.count("--cache-limit") && !is_default_cache(*s.warm_cache)) {
    return fmt::format("--cache-limit: expected --warm-cache default, found {}", s.warm_cache->string());
  }
  if (s.denoise && s.part) {
    return fmt::format(
        "--denoise: expected no --part: parts are filtered once they are together, by tress denoise, for which they "
        "are rendered with --layers all,half, found --part {}",
        s.part->string());
  }
  if (s.deep && s.part) {
    return fmt::format("--deep: expected no --part, whose sums have no depths, found --part {}", s.part->string());
  }
  if (!s.frames.empty() && !names_frames(s.output)) {
    return fmt::format("--output: expected a name with #### for the number of the frame with --frames, found {}",
                       s.output.string());
  }
  for (const auto& [option, file] : {std::pair{"--heatmap", &s.heatmap}, std::pair{"--deep", &s.deep},
                                     std::pair{"--checkpoint", &s.checkpoint}, std::pair{"--part", &s.part}}) {
    if (!s.frames.empty() && *file && !(*file)->empty() && !names_frames(**file)) {
      return fmt::format("{}: expected a name with #### for the number of the frame with --frames, found {}", option,
                         (*file)->string());
    }
  }
  std::filesystem::path preview = s.output;
  std::vector<std::filesystem::path> files{s.scene, s.output, preview.replace_extension(".png")};
  if (s.warm_cache && !is_default_cache(*s.warm_cache)) files.push_back(*s.warm_cache);
  if (s.telemetry) files.push_back(*s.telemetry);
  if (s.heatmap) files.push_back(*s.heatmap);
  if (s.deep) files.push_back(*s.deep);
  if (s.part) files.push_back(*s.part);
  if (s.checkpoint && !s.checkpoint->empty()) files.push_back(*s.checkpoint);
  std::set<std::filesystem::path> seen;
  for (const std::filesystem::path& file : files) {
    std::error_code error;
    const std::filesystem::path whole = std::filesystem::weakly_canonical(file, error);
    if (!error && !seen.insert(whole).second) {
      return fmt::format(
          "{}: expected different files for scene, picture, preview, heat map, deep picture, cache, telemetry, "
          "checkpoint and part",
          file.string());
    }
  }
  return {};
}

}  // namespace

Command add_render(CLI::App& tress, const std::vector<std::string>& command) {
  const auto settings = std::make_shared<RenderSettings>();
  RenderSettings& s = *settings;
  s.command = as_shell_words(command);
  CLI::App* render = tress.add_subcommand("render", "Render a scene, a bare file of strands, or a folder of parts");
  render
      ->add_option_function<std::string>(
          "SCENE", [&s](const std::string& file) { s.scene = file; },
          "scene JSON, strands (.hair, .abc, .usda, .usdc, .usdz, .pbrt, .ply, .data), or a folder of them")
      ->required();
  add_file(render, "-o,--output", [&s](const std::string& file) { s.output = file; },
           "picture; a .png is written beside it", {".exr"})
      ->required();
  auto* samples = add_whole(render, "--spp", [&s](std::uint64_t n) { s.overrides.samples = int(n); });
  auto* time = add_number(render, "--time", [&s](double x) { s.stop.seconds = x; });
  auto* noise = add_number(render, "--noise", [&s](double x) { s.stop.noise = x; });
  samples->excludes(time)->excludes(noise);
  time->excludes(noise);
  add_resolution(render, s.overrides);
  add_layers(render, s);
  add_flag(render, "--denoise", [&s] { s.denoise = true; });
  add_precision(render, s.precision);
  add_signed(render, "--frame", [&s](std::int64_t n) { s.overrides.frame = int(n); });
  render
      ->add_option_function<std::string>(
          "--crop", [&s](const std::string& text) { s.render.crop = parse_crop(text); },
          "render only these pixels, X1 and Y1 excluded, of the same picture")
      ->check(expecting("X0,Y0,X1,Y1 in whole pixels, X0 < X1 and Y0 < Y1",
                        [](const std::string& text) { return parse_crop(text).has_value(); }))
      ->type_name("X0,Y0,X1,Y1");
  add_threads(render, s.threads);
  add_shots(render, s);
  add_viewers(render, s);
  add_whole(render, "--seed", [&s](std::uint64_t seed) { s.render.seed = seed; });
  add_file(render, "--heatmap",
           [&s](const std::string& file) {
             s.heatmap = file;
             s.render.heatmap = true;
           },
           "what each pixel cost: CPU time, vertices, queries, traces", {".exr"});
  add_file(
      render, "--deep",
      [&s](const std::string& file) {
        s.deep = file;
        s.render.deep = true;
      },
      "deep picture for compositors: up to 8 samples of color, alpha and depth a pixel, which flatten to R, G, B, A",
      {".exr"});
  add_appearance(render, s.overrides);
  add_learning(render, s);
  // Hidden: `tress farm` writes it into job templates.
  add_choice(
      render, "--progress", {"openjd"}, [](const std::string&) { use_openjd_lines(); },
      "lines on standard output that Open Job Description reads: openjd_progress, openjd_status, openjd_fail")
      ->group(hidden_group);
  add_quiet(render);
  return {render, [render, settings] {
            log_replaced(*render);
            settings->model_of_scene = render->count("--model") == 0;
            settings->asked = model_options(*render, settings->estimator);
            if (const std::string message = contradiction(*render, *settings); !message.empty()) {
              throw WrongUsage(message);
            }
            settings->given_options = given_options(*render);
            settings->render.halves = settings->keeps_halves || settings->denoise;
            // Each frame has its own seed: noise that stays in place would look like a dirty pane before the hair.
            settings->seed_of_frame = !render->count("--seed");
            if (!render->count("--seed")) {
              settings->render.seed = static_cast<std::uint64_t>(settings->overrides.frame.value_or(0));
            }
            return run_render(*settings);
          }};
}

}  // namespace tress::cli
