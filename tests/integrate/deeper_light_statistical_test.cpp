// Roulette and splitting by learned light have the mean of plain paths, whatever was learned.
//
// Seeds are fixed; limits are z_limit standard errors (picture_mean.h), a false alarm in 1.6 million comparisons.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "base/denormals.h"
#include "integrate/deeper_light.h"
#include "integrate/path_tracer.h"
#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

constexpr int side = 32;

/// Hair and a wall in the dark, lit by one lamp at x = `at`.
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
  scene.meshes.resize(1);
  scene.meshes[0].positions = {{-2, 1.2f, -2}, {2, 1.2f, -2}, {2, 1.2f, 2}, {-2, 1.2f, 2}};
  scene.meshes[0].triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.meshes[0].albedo = glm::vec3(0.8f, 0.5f, 0.3f);
  return scene;
}

/// Mean over the samples of all pixels and its error, and the mean number of hits.
struct Measured {
  double mean = 0, error = 0, hits = 0;
};

/// Traced by what `deeper` knows; it learns nothing more.
Measured measure(const scene::Scene& scene, const fiber::FiberModel& model, const std::vector<fiber::FiberId>& fibers,
                 const RenderOptions& options, const DeeperLight* deeper) {
  const FlushDenormals flush;
  const geometry::FiberScene intersector(scene);
  const PathTracer tracer(scene, intersector, model, fibers, options, deeper);
  double n = 0, sum = 0, squares = 0, hits = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      for (int sample = 0; sample < options.samples; ++sample) {
        const PathSums path = tracer.trace(x, y, static_cast<std::uint32_t>(sample));
        const glm::vec3 light = path.beauty();
        const double value = static_cast<double>(light.x + light.y + light.z) / 3;
        sum += value;
        squares += value * value;
        hits += path.vertices;
        ++n;
      }
    }
  }
  return {sum / n, std::sqrt((squares / n - sum / n * (sum / n)) / n), hits / n};
}

/// By `passes` samples a pixel, updates as a render makes them.
void teach(DeeperLight& deeper, const scene::Scene& scene, const fiber::FiberModel& model,
           const std::vector<fiber::FiberId>& fibers, RenderOptions options, int passes) {
  const DeeperLight::PictureSoFar picture{0.1, 0.05, 6};
  deeper.update(picture, 1);
  for (int pass = 0; pass < passes; ++pass) {
    options.samples = 1;
    options.seed += 1;
    measure(scene, model, fibers, options, &deeper);
    deeper.update(picture, static_cast<std::uint64_t>(pass) + 2);
  }
}

class LampThatMoved : public testing::Test {
 protected:
  LampThatMoved() {
    fiber::LobeColors shares{};
    shares[0] = {0.9f, 0.8f, 0.6f};
    fibers_ = {model_.add_fiber(shares)};
    options_ = long_paths(64, 21);
  }
  WhiteFiber model_;
  std::vector<fiber::FiberId> fibers_;
  RenderOptions options_;
};

TEST_F(LampThatMoved, LeavesNoTraceInThePicture) {
  const scene::Scene scene = lit_from(2);
  RenderOptions plain = options_;
  plain.seed += 1000;
  plain.roulette_depth = plain.max_depth + 1;
  plain.samples *= 2;
  const Measured truth = measure(scene, model_, fibers_, plain, nullptr);
  for (const float taught_at : {-2.0f, 2.0f}) {
    DeeperLight deeper(scene);
    teach(deeper, lit_from(taught_at), model_, fibers_, options_, 8);
    ASSERT_TRUE(deeper.is_ready());
    const Measured learned = measure(scene, model_, fibers_, options_, &deeper);
    EXPECT_LT(std::abs(learned.mean - truth.mean), z_limit * std::hypot(learned.error, truth.error)) << taught_at;
    EXPECT_LT(learned.error, 0.02 * learned.mean);                     // else the comparison says little
    EXPECT_GT(std::abs(learned.hits - truth.hits), 0.1 * truth.hits);  // else nothing was learned
  }
}

TEST_F(LampThatMoved, LeavesNoTraceOfFibersThatCanOnlyBeSampled) {
  struct Sampled : WhiteFiber {
    bool evaluates(const fiber::FiberEvent& event) const override { return event.xi1 < 0.5f; }
    bool evaluates() const override { return true; }
  };
  Sampled model;
  fiber::LobeColors shares{};
  shares[0] = {0.9f, 0.8f, 0.6f};
  const std::vector<fiber::FiberId> fibers{model.add_fiber(shares)};
  const scene::Scene scene = lit_from(2);
  RenderOptions plain = options_;
  plain.seed += 2000;
  plain.roulette_depth = plain.max_depth + 1;
  const Measured truth = measure(scene, model, fibers, plain, nullptr);
  DeeperLight deeper(scene);
  teach(deeper, lit_from(-2), model, fibers, options_, 8);
  options_.bcsdf_samples = 2;
  const Measured learned = measure(scene, model, fibers, options_, &deeper);
  EXPECT_LT(std::abs(learned.mean - truth.mean), z_limit * std::hypot(learned.error, truth.error));
}

/// Lossless fibers: every path goes on until roulette ends it. Shadow rays are all traced, since roulette for them
/// makes up most of the noise here. Over 12 seeds of 256 samples the mean was 1.0001 +- 0.0002.
TEST(LearnedRoulette, FurnaceIsOne) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  scene::Scene scene = tangle(400, 48, 48);
  scene.camera.vertical_fov_deg = 8;
  RenderOptions options = long_paths(96, 31);
  options.roulette = Roulette::learned;
  options.shadow_roulette = false;
  DeeperProgress progress;
  const RenderResult result = render_with(scene, model, fibers, options, 2, never_stop, [&](const PassProgress& pass) {
    progress = pass.deeper;
    return true;
  });
  EXPECT_GT(progress.copies, 10000u);
  for (const char* color : {"R", "G", "B"}) {
    const Mean mean = mean_of(result, color);
    EXPECT_LT(std::abs(mean.value - 1), z_limit * mean.error) << color;
    // Else the comparison says little; 0.0013 to 0.0015 were measured. Of a few samples (TRESS_TEST_SCALE) most are of
    // passes that have not learned yet, and noisier.
    if (options.samples >= 96) {
      EXPECT_LT(mean.error, 0.002) << color;
    }
  }
}

}  // namespace
}  // namespace tress::integrate
