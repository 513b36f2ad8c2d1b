// Where the time of a render goes: the renderer's own paths are recorded, then each of its parts is run alone on them.
//
//   bench_replay SCENE [--up y] [--environment FILE] [--melanin M] [--width N] [--height N] [--model NAME]
//                [--epsilon E] [--teach SAMPLES] [--repeat N] [--inside SECONDS] [--seed N] [--json FILE]
//
// A table is taught by a cold render of SAMPLES a pixel and frozen; the same render then shows what learning cost. One
// further sample a pixel is traced (`whole`), recorded, and its rays, shading events and draws of lights are replayed
// in their order on one thread. `limit` is the recorded rays and light samples in the order of the paths with no
// scattering: what a render with a free BCSDF would cost. `rest` is what the sum of the parts leaves of the whole:
// random numbers, the film, and what parts do to each other's caches; it may be negative. CPU time of the thread;
// the parts take turns, and shares are medians over the rounds with their quartiles.
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/denormals.h"
#include "integrate/film.h"
#include "integrate/path_tracer.h"
#include "integrate/renderer.h"
#include "program_counters.h"
#include "recorded_paths.h"
#include "references/registry.h"
#include "results_file.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/service.h"

namespace tress::bench {
namespace {

struct Setting {
  std::string scene, json, model = "elliptical";
  scene::Overrides overrides;
  adaptive::Options table;
  int teach = 16, repeat = 7;
  double inside = 1;  ///< seconds of every look at the program counter
  std::uint64_t seed = 1;
};

double process_seconds() {
  std::timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double timed(const std::function<void()>& work) {
  const double start = process_seconds();
  work();
  return process_seconds() - start;
}

volatile double sink;

/// Reads every answer, so that none is left out.
class Sum {
 public:
  void add(const std::optional<geometry::Hit>& hit) { total_ += hit ? static_cast<double>(hit->distance_cm) : 0; }
  void add(float value) { total_ += static_cast<double>(value); }
  ~Sum() { sink = total_; }

 private:
  double total_ = 0;
};

/// What a replay runs: parts named by the steps that they take from the recording.
struct Parts {
  bool rays = false, scattering = false, lights = false;
};

/// The scene and everything that renders it.
class Workbench {
 public:
  Workbench(const Setting& setting, scene::Scene scene) : setting_(setting), scene_(std::move(scene)) {
    const fiber::ModelInfo& info = *references::find_model(setting.model);
    if (info.has_rows()) {
      learned_ = fiber::make_service(info, setting.table);
      service_ = learned_.service.get();
    }
    model_ = info.make({fiber::Estimator::fitted, service_, 0});
    result_["fiber_seconds"] = timed([&] {
      for (const fiber::FiberParameters& fiber : scene_.fibers) fiber_ids_.push_back(model_->add_fiber(fiber));
    });
    result_["build_seconds"] = timed([&] { fibers_ = std::make_unique<geometry::FiberScene>(scene_); });
    result_["embree_bytes"] = fibers_->bytes();
    options_.samples = setting.teach;
    options_.seed = setting.seed;
    if (!model_->evaluates() && !model_->estimates()) options_.light_samples = 0;
    lights_ = std::make_unique<integrate::LightSampler>(scene_);
    scattering_ = std::make_unique<integrate::Scattering>(scene_, *model_, fiber_ids_);
  }

  nlohmann::ordered_json measure() {
    teach();
    options_.seed = setting_.seed + 1;  // paths that the table was not taught by
    tracer_ = std::make_unique<integrate::PathTracer>(scene_, *fibers_, *model_, fiber_ids_, options_);
    record();
    time_parts();
    look_inside();
    return std::move(result_);
  }

 private:
  void teach() {
    std::uint64_t queries = 0, converged = 0;
    double publishing = 0;
    const auto render = [&] {
      const std::atomic<bool> stop{false};
      queries = converged = 0;
      return timed([&] {
        integrate::render(scene_, *fibers_, *model_, fiber_ids_, service_, options_, stop,
                          [&](const integrate::PassProgress& pass) {
                            publishing += pass.table.learning_cpu_seconds;
                            queries += pass.table.queries;
                            converged += pass.table.converged_queries;
                            rows_ = pass.table;
                            return true;
                          });
      });
    };
    nlohmann::ordered_json learning;
    learning["samples"] = options_.samples;
    learning["cold_cpu_seconds"] = render();
    learning["publish_cpu_seconds"] = publishing;
    if (service_) service_->set_learning(false);
    learning["warm_cpu_seconds"] = render();
    learning["converged_query_share"] =
        queries > 0 ? static_cast<double>(converged) / static_cast<double>(queries) : 1.0;
    learning["rows_converged"] = rows_.rows_converged;
    learning["table_bytes"] = rows_.bytes;
    result_["learning"] = learning;
  }

  /// In the order of a render's blocks on one thread.
  void trace_all(const std::function<void(int, int)>& pixel) const {
    const FlushDenormals flush;
    constexpr int block = 16;
    for (int top = 0; top < scene_.image.height; top += block) {
      for (int left = 0; left < scene_.image.width; left += block) {
        for (int y = top; y < std::min(top + block, scene_.image.height); ++y) {
          for (int x = left; x < std::min(left + block, scene_.image.width); ++x) pixel(x, y);
        }
      }
    }
  }

  void whole() {
    integrate::Film film({0, 0, scene_.image.width, scene_.image.height}, false);
    trace_all([&](int x, int y) { film.pixel(x, y).add(tracer_->trace(x, y, 0)); });
    sink = film.relative_noise();
  }

  void record() {
    recording = &paths_;
    trace_all([&](int x, int y) {
      paths_.is_first_ray = true;
      tracer_->trace(x, y, 0);
    });
    recording = nullptr;
    path_count_ = static_cast<double>(scene_.image.width) * scene_.image.height;
    nlohmann::ordered_json counts;
    counts["paths"] = path_count_;
    counts["camera_rays"] = paths_.camera_rays.size();
    counts["continuation_rays"] = paths_.ways.size();
    counts["shadow_rays"] = paths_.shadow_rays.size();
    counts["vertices"] = paths_.begins.size();
    counts["light_evaluations"] = paths_.evaluations.size();
    result_["counts"] = counts;
  }

  void camera_rays() {
    Sum sum;
    for (const geometry::Ray& ray : paths_.camera_rays) sum.add(fibers_->intersect(ray));
  }
  void continuation_rays() {
    Sum sum;
    for (const Way& way : paths_.ways) sum.add(fibers_->intersect(way.ray));
  }
  void shadow_rays() {
    Sum sum;
    for (const ShadowRay& shadow : paths_.shadow_rays)
      sum.add(fibers_->occluded(shadow.ray, shadow.distance_cm) ? 1.0f : 0.0f);
  }
  void draw_lights() {
    Sum sum;
    for (const LightDraw& draw : paths_.light_draws)
      sum.add(lights_->sample(draw.point, draw.time, draw.u_light, draw.u, draw.object).density);
  }
  void met_lights() {
    Sum sum;
    for (const Way& way : paths_.ways) met_light(way, sum);
  }
  void met_light(const Way& way, Sum& sum) const {
    lights_->along(way.ray.origin, way.ray.direction, way.ray.time, way.distance_cm, scene::no_object,
                   [&](const LightSampler::Arrival& light) { sum.add(light.density); });
  }

  /// Every recorded step of the parts wanted, in the order of the paths.
  void replay(const Parts& parts, bool evaluating = true, bool sampling = true) {
    const FlushDenormals flush;
    Sum sum;
    PathSums sums;
    Vertex vertex;
    std::size_t camera = 0, way = 0, shadow = 0, begun = 0, evaluated = 0, sampled = 0, drawn = 0;
    for (const Step step : paths_.steps) {
      switch (step) {
        case Step::camera_ray:
          if (parts.rays) sum.add(fibers_->intersect(paths_.camera_rays[camera++]));
          break;
        case Step::continuation_ray:
          if (parts.rays) sum.add(fibers_->intersect(paths_.ways[way].ray));
          if (parts.lights) met_light(paths_.ways[way], sum);
          ++way;
          break;
        case Step::shadow_ray: {
          const ShadowRay& ray = paths_.shadow_rays[shadow++];
          if (parts.rays) sum.add(fibers_->occluded(ray.ray, ray.distance_cm) ? 1.0f : 0.0f);
          break;
        }
        case Step::begin: {
          const Begin& event = paths_.begins[begun++];
          if (parts.scattering) vertex = scattering_->begin(event.hit, event.ray_direction, event.xi, 0);
          if (parts.scattering) sum.add(vertex.albedo.x);
          break;
        }
        case Step::evaluate: {
          const glm::vec3& direction = paths_.evaluations[evaluated++];
          if (parts.scattering && evaluating) sum.add(scattering_->evaluate(vertex, direction, sums).pdf);
          break;
        }
        case Step::sample: {
          const std::array<float, 4>& u = paths_.samples[sampled++];
          if (parts.scattering && sampling) sum.add(scattering_->sample(vertex, u, sums).value.pdf);
          break;
        }
        case Step::draw_light: {
          const LightDraw& draw = paths_.light_draws[drawn++];
          if (parts.lights) sum.add(lights_->sample(draw.point, draw.time, draw.u_light, draw.u, draw.object).density);
          break;
        }
      }
    }
  }

  void time_parts() {
    const std::vector<std::pair<std::string, std::function<void()>>> works = {
        {"whole", [&] { whole(); }},
        {"camera_rays", [&] { camera_rays(); }},
        {"continuation_rays", [&] { continuation_rays(); }},
        {"shadow_rays", [&] { shadow_rays(); }},
        {"light_draws", [&] { draw_lights(); }},
        {"lights_met", [&] { met_lights(); }},
        {"scattering", [&] { replay({.scattering = true}); }},
        {"scattering_begin", [&] { replay({.scattering = true}, false, false); }},
        {"scattering_begin_and_light", [&] { replay({.scattering = true}, true, false); }},
        {"steps", [&] { replay({}); }},
        {"limit", [&] { replay({.rays = true, .lights = true}); }},
        {"all_in_order", [&] { replay({.rays = true, .scattering = true, .lights = true}); }}};
    std::map<std::string, std::vector<double>> seconds;
    for (int round = 0; round < setting_.repeat; ++round) {
      for (const auto& [name, work] : works) seconds[name].push_back(timed(work));
      // The log itself is no part of a render.
      const double log = seconds["steps"].back();
      for (const char* name : {"scattering", "scattering_begin", "scattering_begin_and_light", "limit", "all_in_order"})
        seconds[name].back() -= log;
      double sum = 0;
      for (const char* name :
           {"camera_rays", "continuation_rays", "shadow_rays", "light_draws", "lights_met", "scattering"})
        sum += seconds[name].back();
      seconds["rest"].push_back(seconds["whole"].back() - sum);
    }
    nlohmann::ordered_json parts;
    for (const auto& [name, each] : seconds) {
      std::vector<double> shares;
      for (std::size_t i = 0; i < each.size(); ++i) shares.push_back(each[i] / seconds["whole"][i]);
      parts[name] = {{"ns_a_path", 1e9 * quantile(each, 0.5) / path_count_},
                     {"share", quantile(shares, 0.5)},
                     {"share_quartiles", {quantile(shares, 0.25), quantile(shares, 0.75)}}};
    }
    result_["parts"] = parts;
  }

  static double quantile(std::vector<double> values, double q) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
  }

  /// Of each kind of ray: how much of it is Embree's. The rest is ours: the silhouette filter, and frames of hits.
  void look_inside() {
    nlohmann::ordered_json inside;
    const auto look = [&](const char* name, const std::function<void()>& work) {
      const LibraryShare share = library_share("libembree", [&] {
        const double start = process_seconds();
        while (process_seconds() - start < setting_.inside) work();
      });
      if (share.samples > 0)
        inside[name] = {{"samples", share.samples},
                        {"embree_share", static_cast<double>(share.inside) / static_cast<double>(share.samples)}};
    };
    look("camera_rays", [&] { camera_rays(); });
    look("continuation_rays", [&] { continuation_rays(); });
    look("shadow_rays", [&] { shadow_rays(); });
    look("whole", [&] { whole(); });
    result_["inside"] = inside;
  }

  const Setting& setting_;
  scene::Scene scene_;
  fiber::ModelService learned_;
  adaptive::Service* service_ = nullptr;  ///< of learned_
  std::unique_ptr<fiber::FiberModel> model_;
  std::vector<fiber::FiberId> fiber_ids_;
  std::unique_ptr<geometry::FiberScene> fibers_;
  integrate::RenderOptions options_;
  std::unique_ptr<integrate::LightSampler> lights_;
  std::unique_ptr<integrate::Scattering> scattering_;
  std::unique_ptr<integrate::PathTracer> tracer_;
  RecordedPaths paths_;
  double path_count_ = 0;
  adaptive::PassReport rows_;
  nlohmann::ordered_json result_;
};

int usage() {
  fmt::print(stderr,
             "usage: bench_replay SCENE [--up y] [--environment FILE] [--melanin M] [--width N] [--height N]\n"
             "  [--model NAME] [--epsilon E] [--teach SAMPLES] [--repeat N] [--inside SECONDS] [--seed N]\n"
             "  [--json FILE]\n");
  return 2;
}

bool read(int argc, char** argv, Setting* setting) {
  if (argc < 2 || argc % 2 != 0) return false;
  setting->scene = argv[1];
  for (int i = 2; i < argc; i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    const double number = std::atof(value.c_str());
    if (name == "--up")
      setting->overrides.y_up = value == "y";
    else if (name == "--environment")
      setting->overrides.environment_file = value;
    else if (name == "--melanin")
      setting->overrides.melanin = {static_cast<float>(number), 0.0f};
    else if (name == "--width")
      setting->overrides.width = static_cast<int>(number);
    else if (name == "--height")
      setting->overrides.height = static_cast<int>(number);
    else if (name == "--model")
      setting->model = value;
    else if (name == "--epsilon")
      setting->table.epsilon = number;
    else if (name == "--teach")
      setting->teach = static_cast<int>(number);
    else if (name == "--repeat")
      setting->repeat = static_cast<int>(number);
    else if (name == "--inside")
      setting->inside = number;
    else if (name == "--seed")
      setting->seed = static_cast<std::uint64_t>(number);
    else if (name == "--json")
      setting->json = value;
    else
      return false;
  }
  return references::find_model(setting->model) != nullptr && setting->teach >= 1 && setting->repeat >= 1 &&
         setting->table.epsilon > 0 && setting->overrides.width.value_or(1) >= 1 &&
         setting->overrides.height.value_or(1) >= 1;
}

int run(const Setting& setting) {
  std::optional<Result<scene::Scene>> loaded;
  const double load_seconds = timed([&] { loaded = scene::load_scene(setting.scene, setting.overrides); });
  if (!*loaded) {
    fmt::print(stderr, "{}\n", loaded->error().message());
    return 1;
  }
  scene::Scene& scene = **loaded;
  nlohmann::ordered_json result;
  result["scene"] = setting.scene;
  result["model"] = setting.model;
  result["width"] = scene.image.width;
  result["height"] = scene.image.height;
  result["fibers"] = scene.fibers.size();
  result["seed"] = setting.seed;
  result["epsilon"] = setting.table.epsilon;
  result["rounds"] = setting.repeat;
  result["load_seconds"] = load_seconds;
  std::size_t strands = 0, points = 0;
  for (const scene::Groom& groom : scene.grooms) {
    strands += groom.strand_count();
    points += groom.points.size();
  }
  result["strands"] = strands;
  result["points"] = points;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  tbb::task_arena arena(1);
  result.update(arena.execute([&] { return Workbench(setting, std::move(scene)).measure(); }));
  const std::string text = result.dump(2) + "\n";
  if (setting.json.empty()) {
    fmt::print("{}", text);
    return 0;
  }
  return write_results(setting.json, text);
}

}  // namespace
}  // namespace tress::bench

int main(int argc, char** argv) {
  tress::bench::Setting setting;
  return tress::bench::read(argc, argv, &setting) ? tress::bench::run(setting) : tress::bench::usage();
}
