// tress render: from a scene to a picture.
#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <system_error>
#include <vector>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/options.h"
#include "cli/render_job.h"
#include "references/registry.h"

namespace tress::cli {
namespace {

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
  add_fiber_shape(app, o);
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

std::vector<std::string> model_words() {
  std::vector<std::string> words;
  for (const fiber::ModelInfo& model : references::models()) words.emplace_back(model.name);
  words.emplace_back("exact");
  return words;
}

void add_learning(CLI::App* app, RenderSettings& s) {
  add_choice(
      app, "--model", model_words(),
      [&s](const std::string& name) {
        if (name == "exact") {
          s.estimator = fiber::Estimator::exact;
        } else {
          s.model = name;
        }
      },
      "fiber model; exact is elliptical with --estimator exact");
  add_integer(
      app, "--quadrature-points", 1, 65536, [&s](int n) { s.quadrature_points = n; },
      "over the width of the fiber, for models that integrate at every vertex");
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
  add_number(
      app, "--picture-error", {0, 1, true}, [&s](double x) { s.table.picture_error = x; },
      "in place of --epsilon: the relative error that fits may make in the picture; each row is then learned as well "
      "as the light it carries asks for")
      ->excludes(app->get_option("--epsilon"));
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
      "append (default): load, refine, save merged; frozen: use it as it is, never save; scratch: start cold and "
      "replace; "
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

/// What the parser cannot see: options that contradict each other, and files that would overwrite each other. A
/// message, empty if there is nothing.
std::string contradiction(const CLI::App& render, const RenderSettings& s) {
  const auto given = [&](const char* name) { return render.get_option(name)->as<std::string>(); };
  if (render.count("--model") && given("--model") == "exact" && render.count("--estimator") &&
      given("--estimator") != "exact") {
    return "--estimator: expected exact with --model exact, found " + given("--estimator");
  }
  const fiber::ModelInfo& model = *references::find_model(s.model);
  if (model.make_target == nullptr) {
    for (const char* option : {"--estimator", "--learner", "--components", "--epsilon", "--picture-error",
                               "--table-memory", "--warm-cache"}) {
      if (render.count(option)) return fmt::format("{}: expected a model with rows, found --model {}", option, s.model);
    }
  }
  if (s.table.picture_error > 0 && s.table.learner == &adaptive::knot_learner) {
    return "--picture-error: expected a learner that fits mixtures, found --learner table";
  }
  if (s.quadrature_points && !model.has_quadrature) {
    return fmt::format("--quadrature-points: expected a model that integrates, found --model {}", s.model);
  }
  std::filesystem::path preview = s.output;
  std::vector<std::filesystem::path> files{s.scene, s.output, preview.replace_extension(".png")};
  if (s.warm_cache) files.push_back(*s.warm_cache);
  if (s.telemetry) files.push_back(*s.telemetry);
  if (s.heatmap) files.push_back(*s.heatmap);
  std::set<std::filesystem::path> seen;
  for (const std::filesystem::path& file : files) {
    std::error_code error;
    const std::filesystem::path whole = std::filesystem::weakly_canonical(file, error);
    if (!error && !seen.insert(whole).second) {
      return fmt::format("{}: expected different files for scene, picture, preview, heat map, cache and telemetry",
                         file.string());
    }
  }
  return {};
}

}  // namespace

Command add_render(CLI::App& tress) {
  const auto settings = std::make_shared<RenderSettings>();
  RenderSettings& s = *settings;
  CLI::App* render = tress.add_subcommand("render", "Render a scene, or a bare .hair file");
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
  auto* samples = add_integer(
      render, "--spp", 1, StopRule::most_samples, [&s](int n) { s.overrides.samples = n; }, "samples a pixel");
  auto* time = add_number(
      render, "--time", {0, 1e7, true}, [&s](double x) { s.stop.seconds = x; },
      "seconds: as many samples as fit, one at least; the picture then depends on the machine");
  auto* noise = add_number(
      render, "--noise", {0, 1, true}, [&s](double x) { s.stop.noise = x; },
      "samples until the noise relative to the brightness of what is covered is at most this, 16384 at most");
  samples->excludes(time)->excludes(noise);
  time->excludes(noise);
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
  add_integer(render, "--frame", 0, 1000000, [&s](int n) { s.overrides.frame = n; }, "frame of a moving camera");
  render
      ->add_option_function<std::string>(
          "--crop",
          [&s](const std::string& text) {
            const auto crop = parse_crop(text);
            if (!crop) refuse("--crop", "X0,Y0,X1,Y1 in whole pixels, X0 < X1 and Y0 < Y1", text);
            s.render.crop = crop;
          },
          "render only these pixels, X1 and Y1 excluded, of the same picture")
      ->type_name("X0,Y0,X1,Y1");
  add_threads(render, s.threads);
  add_unsigned(
      render, "--seed", [&s](std::uint64_t seed) { s.render.seed = seed; },
      "same seed, same picture, for any number of threads");
  add_integer(
      render, "--light-samples", 1, 4096, [&s](int n) { s.render.light_samples = n; }, "at the first hit, default 1");
  add_integer(
      render, "--bcsdf-samples", 1, 4096, [&s](int n) { s.render.bcsdf_samples = n; }, "at the first hit, default 1");
  add_integer(render, "--max-depth", 1, 4096, [&s](int n) { s.render.max_depth = n; }, "hits of a path, default 64");
  render
      ->add_option_function<std::string>(
          "--heatmap",
          [&s](const std::string& file) {
            if (std::filesystem::path(file).extension() != ".exr")
              refuse("--heatmap", "a name that ends in .exr", file);
            s.heatmap = file;
            s.render.heatmap = true;
          },
          "what each pixel cost: CPU time, vertices, queries, traces")
      ->type_name("FILE.exr");
  add_appearance(render, s.overrides);
  add_learning(render, s);
  add_quiet(render);
  return {render, [render, settings] {
            if (const std::string message = contradiction(*render, *settings); !message.empty()) {
              throw WrongUsage(message);
            }
            return run_render(*settings);
          }};
}

}  // namespace tress::cli
