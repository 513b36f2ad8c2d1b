// Roulette by what lies deeper against roulette by the throughput: variance times CPU time, in turns. With --deep-light
// learned: learned light in place of deep paths against traced, the backdrop being black so that brightness is of hair.
//
//   bench_deeper SCENE [--up y] [--environment FILE] [--melanin EU,PHEO] [--white] [--size N] [--spp N] [--pairs N]
//                [--teach SAMPLES] [--deep-light learned] [--deep-light-depth N] [--json FILE]
//
// Rows are taught by SAMPLES a pixel and frozen, so that what is learned in the renders is the light alone, which
// starts from nothing in each. Each pair renders once by each rule under seeds of its own. Variance is that of a pixel
// across the renders, mean over pixels and channels; its ratio has an error, by leaving out one pair after another
// (jackknife). CPU time of the process, one thread.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "integrate/renderer.h"
#include "references/registry.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/service.h"

namespace tress::bench {
namespace {

struct Setting {
  std::string scene, json;
  scene::Overrides overrides;
  integrate::DeepLight deep_light = integrate::DeepLight::traced;  ///< other: against traced
  int deep_light_depth = integrate::RenderOptions().deep_light_depth;
  int size = 64, samples = 32, pairs = 10, teach = 16;
  std::uint64_t seed = 1000;
};

double process_seconds() {
  std::timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// All renders by one rule.
struct Renders {
  std::vector<std::vector<float>> pictures;
  std::vector<double> seconds;
  double learning_seconds = 0;
  integrate::DeeperProgress deeper;
  std::vector<integrate::Brightening> reported;

  /// Mean over the values of the variance across all renders but `left_out`, and their mean CPU time.
  double variance(std::size_t left_out) const {
    double sum = 0;
    for (std::size_t at = 0; at < pictures[0].size(); ++at) {
      double mean = 0, squares = 0, count = 0;
      for (std::size_t i = 0; i < pictures.size(); ++i) {
        if (i == left_out) continue;
        const double value = static_cast<double>(pictures[i][at]), step = value - mean;
        mean += step / ++count;
        squares += step * (value - mean);
      }
      sum += squares / (count - 1);
    }
    return sum / static_cast<double>(pictures[0].size());
  }
  double time(std::size_t left_out) const {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < seconds.size(); ++i) {
      if (i == left_out) continue;
      sum += seconds[i];
      ++count;
    }
    return sum / count;
  }
  double mean(std::size_t left_out) const {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      if (i == left_out) continue;
      for (const float value : pictures[i]) sum += static_cast<double>(value);
      ++count;
    }
    return sum / (count * static_cast<double>(pictures[0].size()));
  }
  double mean() const { return mean(pictures.size()); }
};

struct Ratio {
  double value = 0, error = 0;
};

/// Of a quantity of two sets of renders, with the jackknife's error.
template <class Quantity>
Ratio ratio_of(const Renders& above, const Renders& below, Quantity&& quantity) {
  const std::size_t pairs = above.pictures.size();
  const auto without = [&](std::size_t left_out) { return quantity(above, left_out) / quantity(below, left_out); };
  Ratio ratio{without(pairs), 0};
  double mean = 0, squares = 0;
  std::vector<double> parts;
  for (std::size_t i = 0; i < pairs; ++i) parts.push_back(without(i));
  for (const double part : parts) mean += part / static_cast<double>(pairs);
  for (const double part : parts) squares += (part - mean) * (part - mean);
  ratio.error = std::sqrt(squares * static_cast<double>(pairs - 1) / static_cast<double>(pairs));
  return ratio;
}

/// Root mean square difference of the means of blocks of 8 x 8 pixels, what is noise taken off, over the mean.
double block_bias(const Renders& before, const Renders& after, int size) {
  constexpr std::size_t block = 8;
  const auto side = static_cast<std::size_t>(size);
  const auto of_block = [&](const Renders& renders, std::size_t plane, std::size_t left, std::size_t top) {
    std::vector<double> means;
    for (const std::vector<float>& picture : renders.pictures) {
      double sum = 0;
      for (std::size_t y = top; y < top + block; ++y)
        for (std::size_t x = left; x < left + block; ++x)
          sum += static_cast<double>(picture[(plane * side + y) * side + x]);
      means.push_back(sum / (block * block));
    }
    const auto n = static_cast<double>(means.size());
    double mean = 0, squares = 0;
    for (const double one : means) mean += one / n;
    for (const double one : means) squares += (one - mean) * (one - mean);
    return std::array{mean, squares / (n * (n - 1))};
  };
  double squares = 0, count = 0;
  for (std::size_t plane = 0; plane < 3; ++plane) {
    for (std::size_t top = 0; top + block <= side; top += block) {
      for (std::size_t left = 0; left + block <= side; left += block) {
        const auto [a, variance_a] = of_block(before, plane, left, top);
        const auto [b, variance_b] = of_block(after, plane, left, top);
        squares += (a - b) * (a - b) - variance_a - variance_b;
        ++count;
      }
    }
  }
  return std::sqrt(std::max(0.0, squares / std::max(count, 1.0))) / before.mean();
}

int run(Setting setting) {
  setting.overrides.width = setting.overrides.height = setting.size;
  Result<scene::Scene> scene = scene::load_scene(setting.scene, setting.overrides);
  if (!scene) {
    fmt::print(stderr, "{}\n", scene.error().message());
    return 1;
  }
  // So that brightness is that of the hair, as the bias that is reported.
  if (setting.deep_light != integrate::DeepLight::traced) scene->environment_visible = false;
  const fiber::ModelInfo& info = *references::find_model("elliptical");
  const fiber::ModelService learned = fiber::make_service(info, {});
  const auto model = info.make({fiber::Estimator::fitted, learned.service.get(), 0});
  std::vector<fiber::FiberId> ids;
  for (const fiber::FiberParameters& fiber : scene->fibers) ids.push_back(model->add_fiber(fiber));
  const geometry::FiberScene fibers(*scene);
  const std::atomic<bool> stop{false};
  integrate::RenderOptions options;
  options.samples = setting.teach;
  options.seed = setting.seed;
  integrate::render(*scene, fibers, *model, ids, learned.service.get(), options, stop, {});
  learned.service->set_learning(false);

  options.samples = setting.samples;
  std::array<Renders, 2> by_rule;
  for (int pair = 0; pair < setting.pairs; ++pair) {
    for (const std::size_t rule : {0u, 1u}) {
      Renders& renders = by_rule[rule];
      const bool as_before = rule == 0;
      if (setting.deep_light == integrate::DeepLight::traced) {
        options.roulette = as_before ? integrate::Roulette::throughput : integrate::Roulette::learned;
      } else {
        options.roulette = integrate::Roulette::learned;
        options.deep_light = as_before ? integrate::DeepLight::traced : setting.deep_light;
        options.deep_light_depth = setting.deep_light_depth;
      }
      ++options.seed;
      const double start = process_seconds();
      const integrate::RenderResult result = integrate::render(*scene, fibers, *model, ids, learned.service.get(),
                                                               options, stop, [&](const integrate::PassProgress& pass) {
                                                                 renders.learning_seconds += pass.deeper.cpu_seconds;
                                                                 renders.deeper = pass.deeper;
                                                                 return true;
                                                               });
      renders.seconds.push_back(process_seconds() - start);
      renders.reported.push_back(result.deep_light.value_or(integrate::DeepLightBias{}));
      std::vector<float>& all = renders.pictures.emplace_back();
      for (const char* channel : {"R", "G", "B"}) {
        const std::vector<float>& pixels = result.picture.find(channel)->pixels;
        all.insert(all.end(), pixels.begin(), pixels.end());
      }
    }
  }
  const Renders &before = by_rule[0], &after = by_rule[1];
  const auto variance = [](const Renders& of, std::size_t out) { return of.variance(out); };
  const auto time = [](const Renders& of, std::size_t out) { return of.time(out); };
  const auto product = [](const Renders& of, std::size_t out) { return of.variance(out) * of.time(out); };
  nlohmann::ordered_json fields{{"scene", setting.scene}, {"size", setting.size},   {"samples", setting.samples},
                                {"pairs", setting.pairs}, {"teach", setting.teach}, {"seed", setting.seed}};
  const auto add = [&](const char* name, const Ratio& ratio) {
    fields[name] = {{"value", ratio.value}, {"error", ratio.error}};
    fmt::print("{:16} {:.3f} +- {:.3f}\n", name, ratio.value, ratio.error);
  };
  add("variance", ratio_of(after, before, variance));
  add("time", ratio_of(after, before, time));
  add("variance_x_time", ratio_of(after, before, product));
  const std::size_t all = before.pictures.size();
  fields["noise_before"] = std::sqrt(before.variance(all)) / before.mean();
  fields["noise_after"] = std::sqrt(after.variance(all)) / after.mean();
  fields["seconds_before"] = before.time(all);
  fields["mean_ratio"] = after.mean() / before.mean();
  const auto brightness = [](const Renders& of, std::size_t out) { return of.mean(out); };
  add("brightness", ratio_of(after, before, brightness));
  if (setting.deep_light == integrate::DeepLight::learned) {
    double value = 0, squares = 0;
    const auto pairs = static_cast<double>(setting.pairs);
    for (const integrate::Brightening& one : after.reported) {
      value += one.value / pairs;
      squares += one.error * one.error;
    }
    add("told_bias", {value, std::sqrt(squares) / pairs});
    add("told_bias_of_one", {after.reported.front().value, after.reported.front().error});
    fields["block_bias"] = block_bias(before, after, setting.size);
    fmt::print("{:16} {:.3f}\n", "block_bias", fields["block_bias"].get<double>());
  }
  fields["learning_share"] = after.learning_seconds / (after.time(all) * static_cast<double>(all));
  fields["places"] = after.deeper.places;
  fields["copies"] = after.deeper.copies;
  fields["bytes"] = after.deeper.bytes;
  fmt::print("{}\n", fields.dump());
  if (!setting.json.empty()) std::ofstream(setting.json) << fields.dump(1) << "\n";
  return 0;
}

}  // namespace
}  // namespace tress::bench

int main(int count, char** words) {
  tress::bench::Setting setting;
  CLI::App app{"Roulette by what lies deeper against roulette by the throughput."};
  std::string up, environment;
  std::vector<float> melanin;
  bool white = false;
  app.add_option("scene", setting.scene, "scene JSON or .hair file")->required();
  app.add_option("--up", up)->check(CLI::IsMember({"y", "z"}));
  app.add_option("--environment", environment);
  app.add_option("--melanin", melanin)->delimiter(',')->expected(1, 2);
  app.add_flag("--white", white, "nothing is absorbed");
  app.add_option("--size", setting.size)->check(CLI::Range(1, 4096))->capture_default_str();
  app.add_option("--spp", setting.samples)->check(CLI::Range(1, 1000000))->capture_default_str();
  app.add_option("--pairs", setting.pairs)->check(CLI::Range(3, 100000))->capture_default_str();
  app.add_option("--teach", setting.teach)->check(CLI::Range(1, 1000000))->capture_default_str();
  app.add_option("--seed", setting.seed)->capture_default_str();
  app.add_option("--json", setting.json);
  std::string deep_light = "traced";
  app.add_option("--deep-light", deep_light)->check(CLI::IsMember({"traced", "learned"}));
  app.add_option("--deep-light-depth", setting.deep_light_depth);
  CLI11_PARSE(app, count, words);
  if (deep_light == "learned") setting.deep_light = tress::integrate::DeepLight::learned;
  if (!up.empty()) setting.overrides.y_up = up == "y";
  if (!environment.empty()) setting.overrides.environment_file = environment;
  if (!melanin.empty()) setting.overrides.melanin = {melanin[0], melanin.size() > 1 ? melanin[1] : 0.0f};
  if (white) setting.overrides.sigma_a = glm::vec3(0.0f);
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 1);
  return tress::bench::run(setting);
}
