// What the fits of a table do to a picture: the picture by them minus that by g, along the same paths.
//
//   bench_picture_bias SCENE TABLE [--size WxH] [--spp N] [--seeds N] [--against node|exact]
//
// Both pictures draw their directions from the table's rows, frozen, under the same random numbers; one takes the fits
// for the light that these scatter, the other g: at the nodes (the bias of the fits alone), or at every vertex (that of
// the grid too). Paths then part in roulette only, and what differs is the bias, at a hundredth of a picture's noise.
// Prints JSON: relative to the mean radiance where there is hair, the bias of the picture's mean with its standard
// error by the seeds, and the root mean square of the bias of 4 x 4 pixel means, noise taken out by squares. Not a
// render: the table's rows are taken as they are, whatever their bounds.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "geometry/fiber_scene.h"
#include "image/picture.h"
#include "integrate/renderer.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/cache.h"
#include "tress/fiber/elliptical_model.h"

namespace tress {
namespace {

constexpr int block = 4;  // pixels along a side

/// Directions of one model, values of another.
class DrawnByAnother final : public fiber::FiberModel {
 public:
  DrawnByAnother(fiber::FiberModel& sampler, fiber::FiberModel& values) : sampler_(sampler), values_(values) {}
  std::string name() const override { return values_.name(); }
  fiber::FiberId make_fiber(const fiber::FiberParameters& parameters) override {
    values_.add_fiber(parameters);
    return sampler_.add_fiber(parameters);
  }
  fiber::FiberEvent make_event(fiber::FiberId id, const fiber::FiberDirection& wr, float xi1, float xi2,
                               float h) const override {
    return sampler_.begin(id, wr, xi1, xi2, h);
  }
  fiber::FiberSample sample_event(const fiber::FiberEvent& event, const std::array<float, 4>& u) const override {
    fiber::FiberSample drawn = sampler_.sample(event, u);
    drawn.value = valued(event, drawn.wi, drawn.value.pdf);
    return drawn;
  }
  fiber::FiberValue evaluate_event(const fiber::FiberEvent& event, const fiber::FiberDirection& wi) const override {
    return valued(event, wi, sampler_.evaluate(event, wi).pdf);
  }

 private:
  fiber::FiberValue valued(const fiber::FiberEvent& event, const fiber::FiberDirection& wi, float pdf) const {
    fiber::FiberValue value = values_.evaluate(values_.begin(event.fiber, event.wr, event.xi1, event.xi2, 0), wi);
    value.pdf = pdf;
    return value;
  }
  fiber::FiberModel& sampler_;
  fiber::FiberModel& values_;
};

struct Settings {
  std::string scene, table, against = "node";
  int width = 48, height = 64, samples = 16, seeds = 4;
};

/// Fails with a message: a bench has no one to hand an error to.
[[noreturn]] void stop_with(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::exit(1);
}

/// Sums over blocks: of radiance (mean of the channels) where there is hair, and of pixels.
struct Blocks {
  std::vector<double> sums, pixels;
};

Blocks blocks_of(const image::Picture& picture) {
  const int across = (picture.width + block - 1) / block, down = (picture.height + block - 1) / block;
  Blocks blocks{std::vector<double>(static_cast<std::size_t>(across * down), 0.0),
                std::vector<double>(static_cast<std::size_t>(across * down), 0.0)};
  const std::vector<float>& cover = picture.find("coverage")->pixels;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const auto pixel = static_cast<std::size_t>(y * picture.width + x);
      if (!(cover[pixel] > 0.5f)) continue;
      const auto at = static_cast<std::size_t>(y / block * across + x / block);
      blocks.pixels[at] += 1;
      for (const char* channel : {"R", "G", "B"})
        blocks.sums[at] += static_cast<double>(picture.find(channel)->pixels[pixel]) / 3;
    }
  }
  return blocks;
}

int run(const Settings& settings) {
  scene::Overrides overrides;
  overrides.width = settings.width;
  overrides.height = settings.height;
  const Result<scene::Scene> loaded = scene::load_scene(settings.scene, overrides);
  if (!loaded) stop_with(loaded.error().message());
  scene::Scene scene = *loaded;
  scene.environment_visible = false;
  const geometry::FiberScene fibers(scene);
  const auto target = fiber::make_elliptical_target();

  adaptive::Options taken;
  taken.epsilon = 1;  // rows are taken as they are
  adaptive::Service rows(taken, *target), nodes(taken, *target);
  const auto sampler = *fiber::make_elliptical_model(fiber::Estimator::fitted, &rows);
  const auto values = settings.against == "exact" ? *fiber::make_elliptical_model(fiber::Estimator::exact, nullptr)
                                                  : *fiber::make_elliptical_model(fiber::Estimator::fitted, &nodes);
  DrawnByAnother truth(*sampler, *values);
  std::vector<fiber::FiberId> ids;
  for (const fiber::FiberParameters& one : scene.fibers) ids.push_back(truth.add_fiber(one));
  Result<adaptive::TableSnapshot> image = adaptive::load_cache(settings.table, target->model_name());
  if (!image) stop_with(image.error().message());
  if (const auto error = rows.load(std::move(*image))) stop_with(error->message());
  rows.set_learning(false);

  const std::atomic<bool> never{false};
  std::vector<double> bias;
  double mean = 0, covered = 0;
  std::vector<std::vector<double>> differences;
  for (int seed = 0; seed < settings.seeds; ++seed) {
    integrate::RenderOptions options;
    options.samples = settings.samples;
    options.seed = static_cast<std::uint64_t>(1000 + seed);
    options.roulette = integrate::Roulette::throughput;  // learned, paths would part where the pictures differ
    const Blocks fitted =
        blocks_of(integrate::render(scene, fibers, *sampler, ids, &rows, options, never, nullptr).picture);
    const Blocks exact =
        blocks_of(integrate::render(scene, fibers, truth, ids, &rows, options, never, nullptr).picture);
    double difference = 0, light = 0, pixels = 0;
    std::vector<double> by_block;
    for (std::size_t b = 0; b < exact.sums.size(); ++b) {
      difference += fitted.sums[b] - exact.sums[b];
      light += exact.sums[b];
      pixels += exact.pixels[b];
      if (exact.pixels[b] >= block * block / 2) by_block.push_back((fitted.sums[b] - exact.sums[b]) / exact.pixels[b]);
    }
    bias.push_back(difference / pixels);
    mean += light / pixels / settings.seeds;
    covered = pixels;
    differences.push_back(std::move(by_block));
  }
  const double n = settings.seeds;
  double middle = 0, spread = 0, block_squares = 0;
  for (const double one : bias) middle += one / n;
  for (const double one : bias) spread += (one - middle) * (one - middle) / (n * (n - 1));
  const std::size_t blocks = differences.front().size();
  for (std::size_t b = 0; b < blocks; ++b) {
    double sum = 0, noise = 0;
    for (const auto& one : differences) sum += one[b] / n;
    for (const auto& one : differences) noise += (one[b] - sum) * (one[b] - sum) / (n * (n - 1));
    block_squares += (sum * sum - noise) / static_cast<double>(blocks);
  }
  nlohmann::ordered_json out = {{"mean", mean},
                                {"bias", middle / mean},
                                {"bias_error", std::sqrt(spread) / mean},
                                {"block_rms", std::sqrt(std::max(0.0, block_squares)) / mean},
                                {"blocks", blocks},
                                {"pixels", covered}};
  std::printf("%s\n", out.dump(1).c_str());
  return 0;
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Settings settings;
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.rfind("--", 0) != 0) {
      words.push_back(word);
      continue;
    }
    const std::string value = i + 1 < argc ? argv[++i] : "";
    bool understood = true;
    if (word == "--size") {
      understood = std::sscanf(value.c_str(), "%dx%d", &settings.width, &settings.height) == 2;
    } else if (word == "--spp") {
      understood = (settings.samples = std::atoi(value.c_str())) > 0;
    } else if (word == "--seeds") {
      understood = (settings.seeds = std::atoi(value.c_str())) > 1;
    } else if (word == "--against") {
      settings.against = value;
      understood = value == "node" || value == "exact";
    } else {
      understood = false;
    }
    if (!understood) words.clear();
  }
  if (words.size() != 2) {
    std::fprintf(stderr,
                 "usage: bench_picture_bias SCENE TABLE [--size WxH] [--spp N] [--seeds N] [--against node|exact]\n");
    return 2;
  }
  settings.scene = words[0];
  settings.table = words[1];
  return tress::run(settings);
}
