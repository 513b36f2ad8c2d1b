// A picture of what moves while the shutter is open, against the mean of 64 stills.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"
#include "scene/model/camera.h"

namespace tress::integrate {
namespace {

constexpr int side = 12, stills = 64;

/// A tangle of fibers that turns and goes to the right, over a square that rises, seen by a camera that goes up, under
/// light from one side.
scene::Scene moving_scene() {
  scene::Scene scene = tangle(60, side, side);
  scene.environment = scene::Environment(2, 1, {glm::vec3(1, 0.2f, 0.5f), glm::vec3(0.1f, 0.6f, 0.5f)}, 0, 1);
  scene.shutter = {0, 0.5, 2};
  scene::Groom& groom = scene.grooms[0];
  groom.later = {{groom.points}};
  for (glm::vec3& point : groom.later[0].points) point += glm::vec3(0.5f - 0.4f * point.y, 0.4f * point.x, 0);
  scene::Mesh mesh;
  mesh.positions = {{-1, -1, -0.7f}, {1, -1, -0.7f}, {1, 1, -0.7f}, {-1, 1, -0.7f}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.later = {{mesh.positions, {}}};
  for (glm::vec3& point : mesh.later[0].positions) point.z += 0.5f;
  scene.meshes = {mesh};
  scene.camera_moments = {scene.camera, scene.camera};
  scene.camera_moments[1].eye.z += 0.8f;
  return scene;
}

scene::Scene still_at(const scene::Scene& moving, float time) {
  scene::Scene still = moving;
  const auto settle = [time](std::vector<glm::vec3>& points, const std::vector<glm::vec3>& last) {
    for (std::size_t i = 0; i < points.size(); ++i) points[i] += time * (last[i] - points[i]);
  };
  settle(still.grooms[0].points, moving.grooms[0].later[0].points);
  settle(still.meshes[0].positions, moving.meshes[0].later[0].positions);
  still.grooms[0].later.clear();
  still.meshes[0].later.clear();
  still.camera = scene::camera_during(moving.camera_moments, time);
  still.camera_moments.clear();
  still.shutter = {};
  return still;
}

RenderResult picture_of(const scene::Scene& scene, int samples, std::uint64_t seed, int threads = 2) {
  WhiteFiber model;
  RenderOptions options;
  options.samples = samples;
  options.max_depth = 20;
  options.seed = test::seed(seed);
  options.roulette = Roulette::throughput;
  return render_with(scene, model, {model.add_fiber({glm::vec3(0.7f, 0.5f, 0.3f)})}, options, threads);
}

/// Seeds 71 and 72 and on. The mean of stills at the middles of 64 parts of the shutter is that of all times to second
/// order; each has 16 samples, the moving picture has 1,024: both have as many. Three channels of 144 pixels are judged
/// against the variance that both pictures tell, which is an upper bound (PICTURE.md): sum of squares over 432
/// deviations of variance 1 at most, beyond 1.4 once in a million by chi-square of 144 degrees of freedom (the three
/// channels of a pixel go together), and means over the picture within 5 standard errors. Without time in the rays the
/// sum is above 10.
TEST(OpenShutter, ShowsTheMeanOfItsStills) {
  const scene::Scene moving = moving_scene();
  const int samples = test::scaled(1024);
  const RenderResult blurred = picture_of(moving, samples, 71);
  const char* const channels[] = {"R", "G", "B"};
  std::vector<std::vector<double>> mean(3, std::vector<double>(side * side)), variance = mean;
  for (int k = 0; k < stills; ++k) {
    const RenderResult still = picture_of(still_at(moving, (static_cast<float>(k) + 0.5f) / stills),
                                          std::max(2, samples / stills), 72 + static_cast<std::uint64_t>(k));
    for (std::size_t c = 0; c < 3; ++c) {
      const std::vector<float>& values = still.picture.find(channels[c])->pixels;
      const std::vector<float>& noise = still.picture.find(std::string("variance.") + channels[c])->pixels;
      for (std::size_t i = 0; i < values.size(); ++i) {
        mean[c][i] += static_cast<double>(values[i]) / stills;
        variance[c][i] += static_cast<double>(noise[i]) / (stills * stills);
      }
    }
  }
  double squares = 0, noisy = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<float>& values = blurred.picture.find(channels[c])->pixels;
    const std::vector<float>& noise = blurred.picture.find(std::string("variance.") + channels[c])->pixels;
    double difference = 0, error = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double off = static_cast<double>(values[i]) - mean[c][i],
                   of = static_cast<double>(noise[i]) + variance[c][i];
      if (!(of > 0)) {  // nothing but the same light in every path
        EXPECT_NEAR(off, 0, 1e-5);
        continue;
      }
      squares += off * off / of;
      ++noisy;
      difference += off;
      error += of;
    }
    EXPECT_LT(std::abs(difference), z_limit * std::sqrt(error)) << channels[c];
  }
  RecordProperty("squares", std::to_string(squares / noisy));
  EXPECT_GT(noisy, 300);
  EXPECT_LT(squares, 1.4 * noisy);
  EXPECT_GT(squares, 0.05 * noisy) << "errors that tell nothing";
}

/// Times of a pixel are stratified: as many paths make no more noise than the stills, whose times are exact. By the
/// differences of 8 pictures from their mean, over 144 pixels and 3 channels; their ratio, of some 1,000 degrees of
/// freedom a side, is below 1.25 but once in 10,000. It may well be below 1: a still has its own noise of place.
TEST(OpenShutter, MakesNoMoreNoiseThanItsStills) {
  const scene::Scene moving = moving_scene();
  constexpr int pictures = 8;
  const auto spread = [&](const auto& picture) {
    std::vector<double> sum(3 * side * side), squares(3 * side * side);
    for (int p = 0; p < pictures; ++p) {
      const std::vector<double> values = picture(static_cast<std::uint64_t>(p));
      for (std::size_t i = 0; i < values.size(); ++i) sum[i] += values[i], squares[i] += values[i] * values[i];
    }
    double variance = 0;
    for (std::size_t i = 0; i < sum.size(); ++i) variance += (squares[i] - sum[i] * sum[i] / pictures) / (pictures - 1);
    return variance;
  };
  const auto values_of = [](const RenderResult& result) {
    std::vector<double> values;
    for (const char* name : {"R", "G", "B"})
      for (const float value : result.picture.find(name)->pixels) values.push_back(static_cast<double>(value));
    return values;
  };
  const double blurred = spread([&](std::uint64_t p) { return values_of(picture_of(moving, 2 * stills, 200 + p)); });
  const double of_stills = spread([&](std::uint64_t p) {
    std::vector<double> mean(3 * side * side);
    for (int k = 0; k < stills; ++k) {
      const auto values = values_of(picture_of(still_at(moving, (static_cast<float>(k) + 0.5f) / stills), 2,
                                               1000 * (p + 1) + static_cast<std::uint64_t>(k)));
      for (std::size_t i = 0; i < values.size(); ++i) mean[i] += values[i] / stills;
    }
    return mean;
  });
  RecordProperty("ratio", std::to_string(blurred / of_stills));
  EXPECT_LT(blurred, 1.25 * of_stills);
}

TEST(OpenShutter, HasTheSameBitsWhateverTheThreads) {
  const scene::Scene moving = moving_scene();
  const RenderResult one = picture_of(moving, 16, 73, 1), three = picture_of(moving, 16, 73, 3);
  for (const image::Channel& channel : one.picture.channels)
    EXPECT_EQ(channel.pixels, three.picture.find(channel.name)->pixels) << channel.name;
}

}  // namespace
}  // namespace tress::integrate
