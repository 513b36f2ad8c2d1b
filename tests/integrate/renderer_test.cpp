// What must hold of a picture whatever the numbers drawn: same bits, layers, interruption, passes.
#include "integrate/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "integrate/film.h"
#include "integrate/pass_order.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

RenderOptions few_samples(int samples) {
  RenderOptions options;
  options.samples = samples;
  options.max_depth = 20;
  options.seed = 3;
  return options;
}

const std::vector<float>& channel(const RenderResult& result, const std::string& name) {
  const image::Channel* found = result.picture.find(name);
  EXPECT_TRUE(found) << name;
  return found->pixels;
}

TEST(PassOrder, first_passes_are_disjoint_and_cover_the_picture) {
  int pixels[initial_passes] = {};
  std::set<int> ranks;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      int passes = 0;
      for (int pass = 0; pass < initial_passes; ++pass) {
        if (!in_pass(pass, x, y)) continue;
        ++passes;
        ++pixels[pass];
        EXPECT_EQ(sample_of_pass(pass), 0u);
      }
      EXPECT_EQ(passes, 1);
      EXPECT_TRUE(in_pass(initial_passes, x, y));
      if (x < 8 && y < 8) ranks.insert(rank_in_tile(x, y));
    }
  }
  EXPECT_EQ(ranks.size(), 64u);
  EXPECT_EQ(pixels[0], 64 * 64 / 64);
  EXPECT_EQ(pixels[1], 64 * 64 / 16);
  EXPECT_EQ(pixels[2], 64 * 64 / 4);
  EXPECT_EQ(pixels[3], 64 * 64 * 43 / 64);
  EXPECT_EQ(sample_of_pass(pass_count(17) - 1), 16u);
}

TEST(Renderer, tells_of_every_pass_and_ends_with_the_samples_asked_for) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  std::vector<PassProgress> told;
  const RenderResult result =
      render_with(tangle(50, 37, 21), model, fibers, few_samples(3), 2, never_stop, [&](const PassProgress& progress) {
        told.push_back(progress);
        return true;
      });
  ASSERT_EQ(told.size(), 6u);
  std::uint64_t paths = 0;
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_EQ(told[i].pass, static_cast<int>(i));
    EXPECT_EQ(told[i].pass_count, 6);
    paths += told[i].pixels;
    EXPECT_EQ(told[i].paths_so_far, paths);
    EXPECT_EQ(told[i].paths_total, 37u * 21u * 3u);
    EXPECT_GE(told[i].cpu_seconds, 0);
  }
  EXPECT_EQ(paths, 37u * 21u * 3u);
  EXPECT_EQ(result.passes, 6);
  EXPECT_EQ(result.samples_per_pixel, 3);
  EXPECT_FALSE(result.interrupted);
  EXPECT_GT(result.queries, 0u);
  EXPECT_EQ(result.exact_queries * 2, result.queries);
}

TEST(Renderer, gives_the_same_bits_for_any_number_of_threads) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  const scene::Scene scene = tangle(150, 67, 41);
  RenderOptions options = few_samples(4);
  options.light_samples = 2;
  options.bcsdf_samples = 2;
  const RenderResult one = render_with(scene, model, fibers, options, 1);
  for (const int threads : {2, 8}) {
    const RenderResult many = render_with(scene, model, fibers, options, threads);
    ASSERT_EQ(one.picture.channels.size(), many.picture.channels.size());
    for (std::size_t i = 0; i < one.picture.channels.size(); ++i) {
      EXPECT_EQ(one.picture.channels[i].pixels, many.picture.channels[i].pixels) << one.picture.channels[i].name;
    }
    EXPECT_EQ(one.queries, many.queries);
  }
  options.seed = 4;
  EXPECT_NE(render_with(scene, model, fibers, options, 1).picture.channels[0].pixels, one.picture.channels[0].pixels);
}

TEST(Renderer, layers_sum_to_beauty) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  const RenderResult result = render_with(tangle(100, 40, 40), model, fibers, few_samples(4));
  for (const std::string color : {"R", "G", "B"}) {
    const std::vector<float>& beauty = channel(result, color);
    for (std::size_t i = 0; i < beauty.size(); ++i) {
      float sum = 0;
      for (const char* layer : {"R", "TT", "TRT", "TRRT", "residual", "background"}) {
        sum += channel(result, std::string(layer) + "." + color)[i];
      }
      // Six float additions of values about 1.
      EXPECT_NEAR(sum, beauty[i], 6 * 6e-8 * std::max(1.0f, beauty[i]));
    }
  }
  for (const float share : channel(result, "ais.exact")) EXPECT_TRUE(share == 0.0f || share == 0.5f);
}

TEST(Renderer, layer_is_the_lobe_of_the_first_hit) {
  WhiteFiber model;
  fiber::LobeColors only_r{}, only_tt{};
  only_r[0] = glm::vec3(0.5f);
  only_tt[1] = glm::vec3(0.5f);
  // A fence of R fibers before a wall of TT fibers: light bounces between them.
  scene::Scene scene;
  scene.camera.eye = {0, -6, 0};
  scene.image.width = scene.image.height = 32;
  scene.environment_visible = false;
  scene.materials.resize(2);
  scene.grooms.resize(2);
  for (std::uint32_t which = 0; which < 2; ++which) {
    scene::Groom& groom = scene.grooms[which];
    groom.material = which;
    groom.first_point = {0};
    for (int i = -20; i <= 20; ++i) {
      const float x = 0.1f * static_cast<float>(i), y = which == 0 ? 0.0f : 0.3f;
      groom.points.insert(groom.points.end(), {{x, y, -3}, {x, y, 3}});
      groom.radius_cm.insert(groom.radius_cm.end(), 2, which == 0 ? 0.06f : 0.02f);
      groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
    }
  }
  scene::assign_fibers(&scene);
  const std::vector<fiber::FiberId> fibers{model.add_fiber(only_r), model.add_fiber(only_tt)};
  // The fence covers all: no camera ray sees the wall.
  const RenderResult fenced = render_with(scene, model, fibers, few_samples(4));
  double r = 0;
  for (const float value : channel(fenced, "R.R")) r += value;
  EXPECT_GT(r, 0);
  for (const char* layer : {"TT.R", "TRT.G", "residual.B", "background.R"}) {
    for (const float value : channel(fenced, layer)) EXPECT_EQ(value, 0);
  }
  for (const float value : channel(fenced, "A")) EXPECT_EQ(value, 1);
  scene.grooms[0].radius_cm.assign(scene.grooms[0].radius_cm.size(), 0.02f);
  double tt = 0;
  const RenderResult open = render_with(scene, model, fibers, few_samples(4));
  for (const float value : channel(open, "TT.R")) tt += value;
  EXPECT_GT(tt, 0);
}

TEST(Renderer, shows_the_environment_behind_only_if_told) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  scene::Scene scene = tangle(1, 16, 16);
  scene.camera.look_at = {0, -12, 0};  // away from the hair
  for (const bool visible : {false, true}) {
    scene.environment_visible = visible;
    const RenderResult result = render_with(scene, model, fibers, few_samples(2));
    for (const char* name : {"R", "background.G"}) {
      for (const float value : channel(result, name)) EXPECT_EQ(value, visible ? 1.0f : 0.0f);
    }
    for (const float value : channel(result, "A")) EXPECT_EQ(value, 0);
    for (const float value : channel(result, "ais.exact")) EXPECT_EQ(value, 0);
  }
}

TEST(Renderer, interrupted_anywhere_returns_a_finite_picture) {
  for (const int events : {0, 1, 40, 400, 3000}) {
    WhiteFiber model;
    const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
    std::atomic<bool> stop{events == 0};
    std::atomic<int> count{0};
    model.on_begin = [&] {
      if (++count == events) stop = true;
    };
    const RenderResult result = render_with(tangle(80, 64, 64), model, fibers, few_samples(8), 2, stop);
    EXPECT_TRUE(result.interrupted);
    EXPECT_LT(result.samples_per_pixel, 8);
    for (const image::Channel& layer : result.picture.channels) {
      ASSERT_EQ(layer.pixels.size(), 64u * 64u);
      for (const float value : layer.pixels) ASSERT_TRUE(std::isfinite(value)) << layer.name;
    }
    for (const float coverage : channel(result, "A")) {
      EXPECT_GE(coverage, 0);
      EXPECT_LE(coverage, 1);
    }
  }
}

TEST(Renderer, stops_after_a_pass_when_told) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  const RenderResult result = render_with(tangle(20, 16, 16), model, fibers, few_samples(8), 1, never_stop,
                                          [](const PassProgress& progress) { return progress.pass < 4; });
  EXPECT_EQ(result.passes, 5);
  EXPECT_EQ(result.samples_per_pixel, 2);
  EXPECT_FALSE(result.interrupted);
}

TEST(Film, unsampled_pixels_show_the_nearest_sampled_one) {
  Film film(5, 1);
  EXPECT_EQ(film.picture().find("R")->pixels, std::vector<float>(5, 0.0f));
  PathSums near, far;
  near.samples = far.samples = 2;
  near.background = glm::vec3(2.0f);
  far.background = glm::vec3(6.0f);
  far.coverage = 1;
  film.pixel(0, 0) += near;
  film.pixel(3, 0) += far;
  const image::Picture picture = film.picture();
  EXPECT_EQ(picture.find("R")->pixels, (std::vector<float>{1, 1, 3, 3, 3}));
  EXPECT_EQ(picture.find("A")->pixels, (std::vector<float>{0, 0, 0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(film.samples_per_pixel(), 0.8);
}

}  // namespace
}  // namespace tress::integrate
