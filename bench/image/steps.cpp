// What each step towards less noise in the same time is worth on a scene: variance times CPU time, against none of
// them.
//
//   bench_steps SCENE [--size WxH] [--spp N] [--seeds N] [--melanin E,P] [--environment FILE] [--up y|z]
//
// A table is taught first and learns nothing after. Then each step renders the same picture, in turns, on one thread,
// under as many seeds. Prints JSON: of each step the CPU seconds, the variance of a pixel across seeds and what the
// renders reported of it, both relative to the mean squared where anything is covered, the mean itself, and variance
// times time relative to the first, with its standard error (jackknife over seeds). Steps add up in their order, but
// for those that stand alone.

#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/cpu_clock.h"
#include "geometry/fiber_scene.h"
#include "image/picture.h"
#include "integrate/renderer.h"
#include "models/registry.h"
#include "references/registry.h"
#include "scene/read/load_scene.h"

namespace tress {
namespace {

using Draw = scene::Environment::Draw;

struct Step {
  const char* name;
  Draw draw;
  bool shadow_roulette;
  int light_samples;
  bool adaptive = false;
};

constexpr Step steps[] = {
    {"before", Draw::light, false, 1},
    {"environment by contrast", Draw::contrast, false, 1},
    {"shadow rays by roulette too", Draw::contrast, true, 1},
    {"2 light samples too", Draw::contrast, true, 2},
    {"samples where the noise is too", Draw::contrast, true, 2, true},
    {"roulette alone", Draw::light, true, 1},
    {"2 light samples alone", Draw::light, false, 2},
};
constexpr std::size_t step_count = std::size(steps);

struct Settings {
  std::string scene, size = "64x80";
  scene::Overrides overrides;
  int samples = 16, seeds = 8, taught = 16;
};

/// Of one step and seed.
struct Rendered {
  double cpu_seconds = 0, reported = 0;  ///< reported: variance of a pixel over the mean squared
  double covered = 0;                    ///< pixels
  std::vector<double> values;            ///< R, G, B of all pixels
};

Rendered rendered(const scene::Scene& scene, const geometry::FiberScene& fibers, fiber::FiberModel& model,
                  const std::vector<fiber::FiberId>& ids, adaptive::Service* service,
                  const integrate::RenderOptions& options) {
  const std::atomic<bool> never{false};
  Rendered out;
  const double start = thread_cpu_seconds();
  const integrate::RenderResult result =
      integrate::render(scene, fibers, model, ids, service, options, never, [&](const integrate::PassProgress& pass) {
        out.reported = pass.noise * pass.noise;
        return true;
      });
  out.cpu_seconds = thread_cpu_seconds() - start;
  for (const float coverage : result.picture.find("coverage")->pixels) out.covered += coverage > 0 ? 1 : 0;
  for (const char* channel : {"R", "G", "B"})
    for (const float value : result.picture.find(channel)->pixels) out.values.push_back(static_cast<double>(value));
  return out;
}

/// Variance of a covered pixel across seeds over the mean squared (Film::relative_noise, squared), without seed
/// `left_out` (-1: with all).
double relative_variance(const std::vector<Rendered>& seeds, int left_out, double* mean_out = nullptr) {
  double variance = 0, brightness = 0, covered = 0, n = 0;
  for (std::size_t seed = 0; seed < seeds.size(); ++seed) {
    if (static_cast<int>(seed) == left_out) continue;
    covered += seeds[seed].covered;
    n += 1;
  }
  for (std::size_t i = 0; i < seeds.front().values.size(); ++i) {
    double sum = 0, squares = 0, count = 0;
    for (std::size_t seed = 0; seed < seeds.size(); ++seed) {
      if (static_cast<int>(seed) == left_out) continue;
      const double value = seeds[seed].values[i], before = count > 0 ? sum / count : 0;
      sum += value;
      count += 1;
      if (count > 1) squares += (value - before) * (value - sum / count);
    }
    variance += squares / (n - 1);
    brightness += sum / n;
  }
  const double channels = 3 * covered / n, mean = brightness / channels;
  if (mean_out != nullptr) *mean_out = mean;
  return variance / channels / (mean * mean);
}

double cost(const std::vector<Rendered>& seeds, int left_out) {
  double seconds = 0;
  for (std::size_t seed = 0; seed < seeds.size(); ++seed)
    if (static_cast<int>(seed) != left_out) seconds += seeds[seed].cpu_seconds;
  return relative_variance(seeds, left_out) * seconds;
}

nlohmann::ordered_json to_json(const std::vector<std::vector<Rendered>>& all) {
  nlohmann::ordered_json out;
  const int n = static_cast<int>(all.front().size());
  for (std::size_t step = 0; step < step_count; ++step) {
    double mean = 0, reported = 0, seconds = 0;
    const double variance = relative_variance(all[step], -1, &mean);
    for (const Rendered& one : all[step]) {
      reported += one.reported / n;
      seconds += one.cpu_seconds / n;
    }
    const double ratio = cost(all[step], -1) / cost(all[0], -1);
    double spread = 0;
    for (int seed = 0; seed < n; ++seed) {
      const double without = cost(all[step], seed) / cost(all[0], seed);
      spread += (without - ratio) * (without - ratio) * (n - 1) / n;
    }
    out.push_back({{"step", steps[step].name},
                   {"cpu_seconds", seconds},
                   {"variance", variance},
                   {"told_over_true_variance", reported / variance},
                   {"mean", mean},
                   {"variance_times_time", ratio},
                   {"standard_error", std::sqrt(spread)}});
  }
  return out;
}

int run(const Settings& settings) {
  const Result<scene::Scene> loaded = scene::load_scene(settings.scene, settings.overrides);
  if (!loaded) {
    std::fprintf(stderr, "%s\n", loaded.error().message().c_str());
    return 1;
  }
  scene::Scene by_contrast = *loaded;
  by_contrast.environment_visible = false;
  scene::Scene by_light = by_contrast;
  by_light.environment = by_contrast.environment.drawn_by(Draw::light);
  const geometry::FiberScene fibers(by_contrast);
  const fiber::ModelInfo& info = fiber::elliptical_info;
  fiber::ModelService learned = fiber::make_service(info, {});
  const auto model = info.make({fiber::Estimator::fitted, learned.service.get(), 0});
  std::vector<fiber::FiberId> ids;
  for (const fiber::FiberParameters& one : by_contrast.fibers) ids.push_back(model->add_fiber(one));
  const auto render = [&](const Step& step, int samples, std::uint64_t seed) {
    integrate::RenderOptions options;
    options.samples = samples;
    options.seed = seed;
    options.light_samples = step.light_samples;
    options.adaptive = step.adaptive;
    options.shadow_roulette = step.shadow_roulette;
    return rendered(step.draw == Draw::light ? by_light : by_contrast, fibers, *model, ids, learned.service.get(),
                    options);
  };
  render(steps[0], settings.taught, 999);
  learned.service->set_learning(false);
  std::vector<std::vector<Rendered>> all(step_count);
  for (int seed = 0; seed < settings.seeds; ++seed)
    for (std::size_t i = 0; i < step_count; ++i) {
      const std::size_t step = (i + static_cast<std::size_t>(seed)) % step_count;  // turns
      all[step].push_back(render(steps[step], settings.samples, static_cast<std::uint64_t>(seed)));
    }
  nlohmann::ordered_json out = {
      {"scene", settings.scene},     {"width", by_contrast.image.width}, {"height", by_contrast.image.height},
      {"samples", settings.samples}, {"seeds", settings.seeds},          {"steps", to_json(all)}};
  std::printf("%s\n", out.dump(1).c_str());
  return 0;
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Settings settings;
  std::vector<float> melanin;
  std::string up, environment;
  CLI::App app{"variance times time of each step"};
  app.add_option("scene", settings.scene)->required();
  app.add_option("--size", settings.size)->capture_default_str();
  app.add_option("--spp", settings.samples)->check(CLI::Range(2, 65536))->capture_default_str();
  app.add_option("--seeds", settings.seeds)->check(CLI::Range(2, 1000))->capture_default_str();
  app.add_option("--melanin", melanin)->delimiter(',')->expected(2);
  app.add_option("--environment", environment);
  app.add_option("--up", up)->check(CLI::IsMember({"y", "z"}));
  CLI11_PARSE(app, argc, argv);
  int width = 0, height = 0;
  if (std::sscanf(settings.size.c_str(), "%dx%d", &width, &height) != 2 || width < 1 || height < 1) {
    std::fprintf(stderr, "--size: expected WxH, found %s\n", settings.size.c_str());
    return 2;
  }
  settings.overrides.width = width;
  settings.overrides.height = height;
  if (!melanin.empty()) settings.overrides.melanin = {melanin[0], melanin[1]};
  if (!environment.empty()) settings.overrides.environment_file = environment;
  if (!up.empty()) settings.overrides.y_up = up == "y";
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  return tress::run(settings);
}
