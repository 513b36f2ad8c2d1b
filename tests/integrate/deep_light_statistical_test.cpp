// Learned light in place of deep paths: how far it is off is reported, and correctly; threads and breaks change
// nothing.
//
// Seeds are fixed; limits are z_limit standard errors (picture_mean.h), a false alarm in 1.6 million comparisons.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "base/color.h"
#include "base/denormals.h"
#include "image/picture.h"
#include "integrate/deeper_light.h"
#include "integrate/path_tracer.h"
#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

constexpr int side = 32;

/// Hair in the dark, lit by one colored lamp at x = `at`.
scene::Scene lit_from(float at) {
  scene::Scene scene = tangle(400, side, side);
  scene.camera.vertical_fov_deg = 12;
  scene.environment = scene::Environment(glm::vec3(0.02f));
  scene.environment_visible = false;
  scene.lights.resize(1);
  scene.lights[0].kind = scene::Light::Kind::sphere;
  scene.lights[0].center = {at, 0, 1};
  scene.lights[0].radius_cm = 0.3f;
  scene.lights[0].radiance = glm::vec3(40.0f, 30.0f, 20.0f);
  return scene;
}

/// Mean luminance over the samples of all pixels, the reported excess of answers in it, and their errors.
struct Measured {
  Mean light, reported, rest;  ///< rest: light without the reported excess, path by path
  double hits = 0;
};

Measured measure(const scene::Scene& scene, const fiber::FiberModel& model, const std::vector<fiber::FiberId>& fibers,
                 const RenderOptions& options, const DeeperLight* deeper) {
  const FlushDenormals flush;
  const geometry::FiberScene intersector(scene);
  const PathTracer tracer(scene, intersector, model, fibers, options, deeper);
  double n = 0, hits = 0;
  std::array<double, 3> sums{}, squares{};
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      for (int sample = 0; sample < options.samples; ++sample) {
        const PathSums path = tracer.trace(x, y, static_cast<std::uint32_t>(sample));
        const double light = luminance(glm::dvec3(path.beauty())), excess = path.deep_light_excess;
        const std::array<double, 3> values{light, excess, light - excess};
        for (std::size_t i = 0; i < 3; ++i) {
          sums[i] += values[i];
          squares[i] += values[i] * values[i];
        }
        hits += path.vertices;
        ++n;
      }
    }
  }
  const auto mean = [&](std::size_t i) {
    return Mean{sums[i] / n, std::sqrt((squares[i] / n - sums[i] / n * (sums[i] / n)) / n)};
  };
  return {mean(0), mean(1), mean(2), hits / n};
}

class DeepLightOfALamp : public testing::Test {
 protected:
  DeepLightOfALamp() {
    fiber::LobeColors shares{};
    shares[0] = {0.9f, 0.8f, 0.6f};
    fibers_ = {model_.add_fiber(shares)};
    options_ = long_paths(64, 41);
    options_.deep_light = DeepLight::learned;
  }

  /// By samples of every pixel, updates as a render makes them.
  void teach(DeeperLight& deeper, const scene::Scene& scene) const {
    const DeeperLight::PictureSoFar picture{0.1, 0.05, 6};
    RenderOptions options = options_;
    deeper.update(picture, 1);
    for (std::uint64_t pass = 2; pass < 10; ++pass) {
      options.samples = 8;  // enough to answer by, however few are traced in a quick run
      options.seed += 1;
      measure(scene, model_, fibers_, options, &deeper);
      deeper.update(picture, pass);
    }
  }

  WhiteFiber model_;
  std::vector<fiber::FiberId> fibers_;
  RenderOptions options_;
};

// Taught by the lamp that is there, and by one on the other side: the reported error is what the picture is off by.
TEST_F(DeepLightOfALamp, ReportsWhatItIsOffBy) {
  const scene::Scene scene = lit_from(2);
  RenderOptions plain = options_;
  plain.deep_light = DeepLight::traced;
  plain.seed += 1000;
  plain.roulette_depth = plain.max_depth + 1;
  plain.samples *= 2;
  const Measured truth = measure(scene, model_, fibers_, plain, nullptr);
  for (const float taught_at : {-2.0f, 2.0f}) {
    for (const int depth : {2, 3}) {
      options_.deep_light_depth = depth;
      DeeperLight deeper(scene, true);
      teach(deeper, lit_from(taught_at));
      ASSERT_TRUE(deeper.can_answer());
      const Measured learned = measure(scene, model_, fibers_, options_, &deeper);
      EXPECT_LT(std::abs(learned.rest.value - truth.light.value),
                z_limit * std::hypot(learned.rest.error, truth.light.error))
          << taught_at << ' ' << depth;
      // Else the comparison says little; 0.01 to 0.02 were measured.
      if (options_.samples >= 64) {
        EXPECT_LT(learned.rest.error, 0.03 * truth.light.value);
      }
      EXPECT_LT(learned.hits, truth.hits);
      // A lamp on the other side is seen in the reported error, else nothing was tested.
      if (taught_at < 0 && depth == 2 && options_.samples >= 64) {
        EXPECT_GT(std::abs(learned.reported.value), 3 * learned.reported.error);
      }
    }
  }
}

/// Lossless fibers in a white surround show 1, whatever is learned there, but for the noise of the paths that taught
/// it, which all pixels share: 0.02 is some seven standard errors of the reported value.
TEST(DeepLight, FurnaceIsNearOneAndReportsHowNear) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  scene::Scene scene = tangle(400, 48, 48);
  scene.camera.vertical_fov_deg = 8;
  RenderOptions options = long_paths(96, 51);
  options.deep_light = DeepLight::learned;
  options.shadow_roulette = false;
  const RenderResult result = render_with(scene, model, fibers, options, 2);
  ASSERT_TRUE(result.deep_light);
  const DeepLightBias& reported = *result.deep_light;
  std::printf("reported %+.4f +- %.4f, found %+.4f\n", reported.value, reported.error, mean_of(result, "G").value - 1);
  EXPECT_GT(reported.paths, 100u);
  for (const char* color : {"R", "G", "B"}) {
    const Mean mean = mean_of(result, color);
    EXPECT_LT(std::abs(mean.value - 1), 0.02 + z_limit * mean.error) << color;
    EXPECT_LT(std::abs(mean.value - 1 - reported.value), z_limit * std::hypot(mean.error, reported.error)) << color;
  }
}

class DeepLightPicture : public testing::Test {
 protected:
  DeepLightPicture() {
    fiber::LobeColors shares{};
    shares[0] = {0.6f, 0.4f, 0.3f};
    shares[1] = {0.3f, 0.3f, 0.3f};
    fibers_ = {model_.add_fiber(shares)};
    options_.samples = 10;
    options_.seed = 4;
    options_.deep_light = DeepLight::learned;
  }
  static bool same(const RenderResult& a, const RenderResult& b) {
    const auto difference = image::compare(a.picture, b.picture, "a", "b");
    return difference && difference->identical && a.deep_light.has_value() == b.deep_light.has_value() &&
           (!a.deep_light ||
            (a.deep_light->value == b.deep_light->value && a.deep_light->paths == b.deep_light->paths));
  }

  WhiteFiber model_;
  std::vector<fiber::FiberId> fibers_;
  scene::Scene scene_ = tangle(300, 48, 48);
  RenderOptions options_;
};

TEST_F(DeepLightPicture, HasTheSameBitsForAnyNumberOfThreadsAndLayersThatAddUp) {
  const RenderResult one = render_with(scene_, model_, fibers_, options_, 1);
  for (const int threads : {2, 5}) EXPECT_TRUE(same(one, render_with(scene_, model_, fibers_, options_, threads)));
  const auto layer = [&](const std::string& name) -> const std::vector<float>& {
    return one.picture.find(name)->pixels;
  };
  for (std::size_t i = 0; i < layer("R").size(); ++i) {
    float sum = 0;
    for (const char* name : {"R.R", "TT.R", "TRT.R", "TRRT.R", "residual.R", "surface.R", "background.R"})
      sum += layer(name)[i];
    ASSERT_EQ(sum, layer("R")[i]) << i;
  }
  RenderOptions other = options_;
  other.deep_light = DeepLight::traced;
  const RenderResult traced = render_with(scene_, model_, fibers_, other, 2);
  EXPECT_FALSE(traced.deep_light);
  EXPECT_FALSE(same(one, traced));  // else nothing was tested
  other.deep_light_depth = 9;
  EXPECT_TRUE(same(traced, render_with(scene_, model_, fibers_, other, 2)));
}

TEST_F(DeepLightPicture, GoesOnFromWhereItWasSaved) {
  const RenderResult whole = render_with(scene_, model_, fibers_, options_, 2);
  for (const int last : {1, 5, 9}) {
    RenderState state;
    render_with(scene_, model_, fibers_, options_, 2, never_stop, [&](const PassProgress& pass) {
      if (pass.pass < last) return true;
      state.passes = pass.pass + 1;
      state.paths = pass.paths_so_far;
      for (const auto& [name, bytes] : pass.sections()) state.sections[name] = std::string(bytes);
      return false;
    });
    RenderOptions on = options_;
    on.resume = &state;
    EXPECT_TRUE(same(whole, render_with(scene_, model_, fibers_, on, 2))) << last;
    state.sections.erase("film.deep_light");
    EXPECT_TRUE(render_with(scene_, model_, fibers_, on, 2).unusable);
  }
}

}  // namespace
}  // namespace tress::integrate
