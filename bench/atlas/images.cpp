// One render sample by sample: what the mean of a pixel hides. Study 5 of the atlas (05_images.py) runs it.
//
//   bench_atlas_images SCENE -o OUT.exr [--model NAME] [--estimator NAME] [--epsilon E] [--spp N] [--seed N]
//                      [--resolution WxH] [--max-depth N] [--roulette-depth N] [--light-samples N] [--quadrature-points
//                      N]
//
// The passes, paths and table of a render on one thread; the picture is that of `tress render` under the same seed.
// Beside it in OUT.exr: `largest`, of each pixel the largest luminance of a sample. On stdout JSON; `sample` is the
// luminance of a path, negative ones (of `corrected`) as they are.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/color.h"
#include "base/cpu_clock.h"
#include "base/denormals.h"
#include "fiber/energy_table.h"
#include "image/picture.h"
#include "integrate/film.h"
#include "integrate/pass_order.h"
#include "integrate/path_tracer.h"
#include "references/registry.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/service.h"

namespace tress::bench {
namespace {

struct Setting {
  std::string scene, output, model = "elliptical", estimator = "fitted", resolution;
  int quadrature_points = 0;
  adaptive::Options table;
  integrate::RenderOptions render;
};

bool is_finite(const glm::vec3& x) { return std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z); }

/// Everything that is known of the samples, whichever pixel they are of.
struct Samples {
  std::vector<float> luminance;  ///< of each
  std::uint64_t not_finite = 0, vertices = 0;
  std::uint32_t longest = 0;  ///< path, in hits

  void add(const integrate::PathSums& path, float value) {
    vertices += path.vertices;
    longest = std::max(longest, path.vertices);
    if (std::isfinite(value)) {
      luminance.push_back(value);
    } else {
      ++not_finite;
    }
  }
};

class Job {
 public:
  Job(const Setting& setting, const scene::Scene& scene)
      : scene_(scene), film_({0, 0, scene.image.width, scene.image.height}, false) {
    const fiber::ModelInfo& info = *references::find_model(setting.model);
    const fiber::Estimator estimator = setting.estimator == "exact"       ? fiber::Estimator::exact
                                       : setting.estimator == "corrected" ? fiber::Estimator::corrected
                                                                          : fiber::Estimator::fitted;
    if (info.has_rows() && estimator != fiber::Estimator::exact) {
      adaptive::Options table = setting.table;
      table.seed = setting.render.seed;
      learned_ = fiber::make_service(info, table);
      service_ = learned_.service.get();
    }
    model_ = info.make({estimator, service_, setting.quadrature_points});
    for (const fiber::FiberParameters& fiber : scene.fibers) fiber_ids_.push_back(model_->add_fiber(fiber));
    render_ = setting.render;
    if (!model_->evaluates() && !model_->estimates()) render_.light_samples = 0;
    largest_.assign(static_cast<std::size_t>(scene.image.width) * static_cast<std::size_t>(scene.image.height), 0.0f);
  }

  nlohmann::ordered_json run() {
    const geometry::FiberScene fibers(scene_);
    const integrate::PathTracer tracer(scene_, fibers, *model_, fiber_ids_, render_);
    const double start = thread_cpu_seconds();
    for (int pass = 0; pass < integrate::pass_count(render_.samples); ++pass) {
      const std::uint64_t covered = trace_pass(tracer, pass);
      if (service_) {
        service_->publish(covered);
      }
    }
    nlohmann::ordered_json fields = statistics();
    fields["cpu_seconds"] = thread_cpu_seconds() - start;
    return fields;
  }

  image::Picture picture() const {
    image::Picture picture = film_.picture();
    picture.channels.push_back({"largest", largest_});
    return picture;
  }

 private:
  std::uint64_t trace_pass(const integrate::PathTracer& tracer, int pass) {
    const FlushDenormals flush;
    std::uint64_t covered = 0;
    for (int y = 0; y < scene_.image.height; ++y) {
      for (int x = 0; x < scene_.image.width; ++x) {
        if (!integrate::in_pass(pass, x, y)) continue;
        const integrate::PathSums path = tracer.trace(x, y, integrate::sample_of_pass(pass));
        const glm::vec3 beauty = path.beauty();
        const float value = is_finite(beauty) ? luminance(beauty) : NAN;
        samples_.add(path, value);
        covered += path.coverage > 0 ? 1 : 0;
        if (!std::isfinite(value)) continue;
        film_.pixel(x, y).add(path);
        float& largest = largest_[static_cast<std::size_t>(y) * static_cast<std::size_t>(scene_.image.width) +
                                  static_cast<std::size_t>(x)];
        largest = std::max(largest, value);
      }
    }
    return covered;
  }

  nlohmann::ordered_json statistics() {
    std::vector<float>& all = samples_.luminance;
    std::sort(all.begin(), all.end());
    double sum = 0, squares = 0, negative = 0, top = 0;
    const std::size_t few = std::max<std::size_t>(1, all.size() / 10000);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double value = all[i];
      sum += value;
      squares += value * value;
      negative += value < 0 ? 1 : 0;
      if (i + few >= all.size()) top += value;
    }
    const double n = std::max<double>(1, static_cast<double>(all.size())), mean = sum / n;
    nlohmann::ordered_json fields;
    fields["samples"] = all.size();
    fields["not_finite"] = samples_.not_finite;
    fields["mean"] = mean;
    fields["largest"] = all.empty() ? 0.0 : static_cast<double>(all.back());
    fields["least"] = all.empty() ? 0.0 : static_cast<double>(all.front());
    fields["deviation"] = std::sqrt(std::max(0.0, squares / n - mean * mean));
    fields["negative_share"] = negative / n;
    fields["share_of_top_1e-4"] = sum > 0 ? top / sum : 0.0;
    fields["hits_per_path"] = static_cast<double>(samples_.vertices) / n;
    fields["most_hits"] = samples_.longest;
    const std::uint64_t queries = film_.queries();
    fields["exact_share"] =
        queries > 0 ? static_cast<double>(film_.exact_queries()) / static_cast<double>(queries) : 0.0;
    return fields;
  }

  const scene::Scene& scene_;
  fiber::ModelService learned_;
  adaptive::Service* service_ = nullptr;  ///< of learned_
  std::unique_ptr<fiber::FiberModel> model_;
  std::vector<fiber::FiberId> fiber_ids_;
  integrate::RenderOptions render_;
  integrate::Film film_;
  std::vector<float> largest_;
  Samples samples_;
};

int run(const Setting& setting) {
  scene::Overrides overrides;
  if (!setting.resolution.empty()) {
    const std::size_t x = setting.resolution.find('x');
    overrides.width = std::atoi(setting.resolution.substr(0, x).c_str());
    overrides.height = x == std::string::npos ? 0 : std::atoi(setting.resolution.substr(x + 1).c_str());
  }
  const Result<scene::Scene> scene = scene::load_scene(setting.scene, overrides);
  if (!scene) {
    fmt::print(stderr, "{}\n", scene.error().message());
    return 1;
  }
  for (const std::string& text : scene->warnings) fmt::print(stderr, "{}\n", text);
  Job job(setting, *scene);
  const nlohmann::ordered_json fields = job.run();
  if (const auto error = image::write_exr(setting.output, job.picture())) {
    fmt::print(stderr, "{}\n", error->message());
    return 1;
  }
  fmt::print("{}\n", fields.dump(1));
  return 0;
}

}  // namespace
}  // namespace tress::bench

int main(int count, char** words) {
  tress::bench::Setting setting;
  setting.render.max_depth = 64;  // as the cases were measured; tress itself allows more
  CLI::App app{"One render sample by sample."};
  std::vector<std::string> names;
  for (const tress::fiber::ModelInfo& info : tress::references::models()) names.emplace_back(info.name);
  app.add_option("scene", setting.scene, "scene JSON or .hair file")->required();
  app.add_option("-o,--output", setting.output, "EXR")->required();
  app.add_option("--model", setting.model)->check(CLI::IsMember(names))->capture_default_str();
  app.add_option("--estimator", setting.estimator)
      ->check(CLI::IsMember({"fitted", "corrected", "exact"}))
      ->capture_default_str();
  app.add_option("--epsilon", setting.table.epsilon)->check(CLI::Range(1e-6, 1.0))->capture_default_str();
  app.add_option("--quadrature-points", setting.quadrature_points)->check(CLI::Range(1, 4096));
  app.add_option("--spp", setting.render.samples)->check(CLI::Range(1, 1000000))->capture_default_str();
  app.add_option("--seed", setting.render.seed)->capture_default_str();
  app.add_option("--resolution", setting.resolution, "WxH");
  app.add_option("--max-depth", setting.render.max_depth)->check(CLI::Range(1, 100000))->capture_default_str();
  app.add_option("--roulette-depth", setting.render.roulette_depth)->capture_default_str();
  app.add_option("--light-samples", setting.render.light_samples)->check(CLI::Range(0, 1000))->capture_default_str();
  CLI11_PARSE(app, count, words);
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 1);
  return tress::bench::run(setting);
}
