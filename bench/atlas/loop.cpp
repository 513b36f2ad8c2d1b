// What a render does pass by pass: the mean of the picture that each pass brought, CPU time, memory, share of g; or, of
// a saved table, how far its converged rows are from their target.
//
//   bench_atlas_loop SCENE [--size WxH] [--spp N] [--seeds N] [--first-seed N] [--epsilon E]
//                    [--estimator fitted|corrected|nodes|exact]
//   bench_atlas_loop --table FILE [--epsilon E]
//
// `nodes` is `fitted` with a table that never learns: every answer is g at the node, so that the grid is the same and
// there is no fit. The background is black. Prints JSON: by seed the mean radiance of each sample (the first four
// passes are one sample), of the first seed the passes, and the errors of its rows: relative squared L2 of every
// converged row against a fresh trace, by the midpoints of 4096 azimuths, and how many are beyond their epsilon.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "geometry/fiber_scene.h"
#include "integrate/film.h"
#include "integrate/pass_order.h"
#include "integrate/renderer.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/fiber/elliptical_model.h"

namespace tress {
namespace {

using Json = nlohmann::ordered_json;

struct Settings {
  std::string scene, table, size = "48x64", estimator = "fitted";
  int samples = 200, seeds = 1;
  std::uint64_t first_seed = 1;
  double epsilon = 0.01;
};

/// Fails with a message: a bench has no one to hand an error to.
[[noreturn]] void stop_with(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::exit(1);
}

std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t size = 0, resident = 0;
  file >> size >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

double error_of(const adaptive::CachedRow& row, const adaptive::TracedNodes& nodes) {
  constexpr int points = 4096;
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const auto x = static_cast<float>(((i + 0.5) / points * 2 - 1) * std::numbers::pi);
    const float f = row.density()->fit.density(x);
    const double off = static_cast<double>(nodes.density(x)) - static_cast<double>(f);
    sum += off * off;
  }
  return sum * 2 * std::numbers::pi / points / static_cast<double>(nodes.variation());
}

Json errors_of(const adaptive::TableSnapshot& image, const adaptive::Target& target, double epsilon) {
  std::vector<double> errors;
  std::uint64_t open = 0, false_bounds = 0;
  for (const adaptive::CachedSlice& slice : image.slices) {
    const adaptive::SliceDescription& d = slice.description;
    for (const adaptive::CachedRow& row : slice.rows) {
      if (row.state != adaptive::RowState::converged) {
        ++open;
        continue;
      }
      std::vector<adaptive::TracedRay> rays;
      target.trace(d, d.axis_a[row.node / d.axis_b.size()], d.axis_b[row.node % d.axis_b.size()], rays);
      errors.push_back(error_of(row, adaptive::TracedNodes(rays, d.blur_rad)));
      false_bounds += errors.back() > epsilon ? 1 : 0;
    }
  }
  std::ranges::sort(errors);
  const auto at = [&](double share) {
    return errors.empty() ? 0.0 : errors[static_cast<std::size_t>(share * static_cast<double>(errors.size() - 1))];
  };
  return {{"pages", image.slices.size()},
          {"converged", errors.size()},
          {"open", open},
          {"beyond_epsilon", false_bounds},
          {"median", at(0.5)},
          {"p99", at(0.99)},
          {"worst", at(1)}};
}

/// Mean over the pixels and channels of what all paths so far have brought, times the samples of a pixel.
double light_of(const integrate::Film& film) {
  double sum = 0;
  for (int y = 0; y < film.window().height; ++y) {
    for (int x = 0; x < film.window().width; ++x) {
      const glm::dvec3 beauty = film.pixel(x, y).beauty();
      sum += (beauty.x + beauty.y + beauty.z) / 3;
    }
  }
  return sum / (film.window().width * film.window().height);
}

Json pass_json(const integrate::PassProgress& pass) {
  const adaptive::PassReport& t = pass.table;
  const double asked = static_cast<double>(std::max<std::uint64_t>(t.queries, 1));
  return {{"cpu", pass.cpu_seconds},
          {"learning_cpu", t.learning_cpu_seconds},
          {"g_share", 1 - static_cast<double>(t.converged_queries) / asked},
          {"g_evaluations", t.g_evaluations},
          {"refits", t.refits},
          {"rows", {t.rows_open, t.rows_converged, t.rows_refused, t.rows_reopened}},
          {"bytes", t.bytes},
          {"rss", resident_bytes()},
          {"bias_bound", t.bias_bound}};
}

int run(const Settings& settings) {
  const auto target = fiber::make_elliptical_target();
  if (!settings.table.empty()) {
    const Result<adaptive::TableSnapshot> image = adaptive::load_cache(settings.table, target->model_name());
    if (!image) stop_with(image.error().message());
    std::printf("%s\n", errors_of(*image, *target, settings.epsilon).dump().c_str());
    return 0;
  }
  scene::Overrides overrides;
  int width = 0, height = 0;
  if (std::sscanf(settings.size.c_str(), "%dx%d", &width, &height) != 2) stop_with("--size: expected WxH");
  overrides.width = width;
  overrides.height = height;
  const Result<scene::Scene> loaded = scene::load_scene(settings.scene, overrides);
  if (!loaded) stop_with(loaded.error().message());
  scene::Scene scene = *loaded;
  scene.environment_visible = false;
  const geometry::FiberScene fibers(scene);
  const std::atomic<bool> never{false};
  Json means = Json::array(), passes = Json::array(), rows;
  for (int s = 0; s < settings.seeds; ++s) {
    integrate::RenderOptions options;
    options.samples = settings.samples;
    options.seed = settings.first_seed + static_cast<std::uint64_t>(s);
    adaptive::Options learn;
    learn.epsilon = settings.epsilon;
    learn.seed = options.seed;
    std::optional<adaptive::Service> service;
    if (settings.estimator != "exact") service.emplace(learn, *target);
    if (settings.estimator == "nodes") service->set_learning(false);
    const auto estimator = settings.estimator == "exact"       ? fiber::Estimator::exact
                           : settings.estimator == "corrected" ? fiber::Estimator::corrected
                                                               : fiber::Estimator::fitted;
    const auto model = *fiber::make_elliptical_model(estimator, service ? &*service : nullptr);
    std::vector<fiber::FiberId> ids;
    for (const fiber::FiberParameters& one : scene.fibers) ids.push_back(model->add_fiber(one));
    Json by_sample = Json::array();
    double before = 0;
    integrate::render(scene, fibers, *model, ids, service ? &*service : nullptr, options, never,
                      [&](const integrate::PassProgress& pass) {
                        if (s == 0) passes.push_back(pass_json(pass));
                        if (pass.pass + 1 < integrate::initial_passes) return true;
                        const double light = light_of(*pass.film);
                        by_sample.push_back(light - before);
                        before = light;
                        return true;
                      });
    means.push_back(std::move(by_sample));
    if (s == 0 && service) rows = errors_of(service->snapshot(), *target, settings.epsilon);
  }
  std::printf("%s\n", Json{{"means", means}, {"passes", passes}, {"rows", rows}}.dump().c_str());
  return 0;
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Settings settings;
  CLI::App app("What a render does pass by pass");
  app.add_option("scene", settings.scene);
  app.add_option("--table", settings.table)->excludes("scene");
  app.add_option("--size", settings.size);
  app.add_option("--spp", settings.samples)->check(CLI::Range(1, 100000));
  app.add_option("--seeds", settings.seeds)->check(CLI::Range(1, 1000));
  app.add_option("--first-seed", settings.first_seed);
  app.add_option("--epsilon", settings.epsilon)->check(CLI::Range(1e-9, 1.0));
  app.add_option("--estimator", settings.estimator)->check(CLI::IsMember({"fitted", "corrected", "nodes", "exact"}));
  CLI11_PARSE(app, argc, argv);
  if (settings.scene.empty() && settings.table.empty()) {
    std::fprintf(stderr, "%s", app.help().c_str());
    return 2;
  }
  return tress::run(settings);
}
