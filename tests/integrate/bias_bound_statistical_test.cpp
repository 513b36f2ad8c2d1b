// The bias that a picture by fits really has, against `exact`; the bound on it that the table reports, and what the
// paths estimate of it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"
#include "support/seed.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::integrate {
namespace {

using fiber::Estimator;

struct Rendered {
  std::vector<float> pixels;  ///< luminance
  double bound = 0;
  std::optional<Brightening> excess;
  std::uint64_t fitted_rows = 0;  ///< converged, with a component or more
};

/// Of the light that hair() stands in, over its mean: four pixels of 12 among 128 of 0.02, all as large in azimuth and
/// none near a pole. The bound is given at 1 (adaptive/ESTIMATOR.md, E8).
const double variation = std::sqrt((4 * 12.0 * 12.0 + 124 * 0.02 * 0.02) / 128) / ((4 * 12.0 + 124 * 0.02) / 128);

/// Brown hair under a small bright window, whose light varies over the azimuth as much as light can in an hour of
/// tests.
scene::Scene hair() {
  scene::Scene scene = tangle(250, 32, 32);
  scene.camera.vertical_fov_deg = 10;
  std::vector<glm::vec3> pixels(16 * 8, glm::vec3(0.02f));
  for (const int i : {35, 36, 51, 52}) pixels[static_cast<std::size_t>(i)] = glm::vec3(12.0f);
  scene.environment = scene::Environment(16, 8, pixels, 0, 1.0f);
  scene.environment_visible = false;
  return scene;
}

/// Renders twice with one table; the second picture is returned, and the bound after it.
Rendered render(const scene::Scene& scene, Estimator estimator, const adaptive::Options& learning, int samples,
                int threads = 2) {
  const auto target = fiber::make_elliptical_target();
  adaptive::Service service(learning, *target);
  adaptive::Service* const rows = estimator == Estimator::exact ? nullptr : &service;
  const auto model = *fiber::make_elliptical_model(estimator, rows);
  std::vector<fiber::FiberId> ids;
  for (const fiber::FiberParameters& fiber : scene.fibers) ids.push_back(model->add_fiber(fiber));
  RenderOptions options;
  options.max_depth = 6;
  Rendered rendered;
  for (const std::uint64_t seed : {51ull, 52ull}) {
    if (rows == nullptr && seed == 51ull) continue;
    options.samples = samples;
    options.seed = test::seed(seed);
    const auto listen = [&](const PassProgress& pass) {
      rendered.bound = pass.table.bias_bound;
      rendered.fitted_rows = 0;
      for (std::size_t d = 1; d < pass.table.components.size(); ++d) rendered.fitted_rows += pass.table.components[d];
      return true;
    };
    const RenderResult result = render_with(scene, *model, ids, options, threads, never_stop, listen, rows);
    const std::vector<float>&red = result.picture.find("R")->pixels, &green = result.picture.find("G")->pixels,
          &blue = result.picture.find("B")->pixels;
    rendered.pixels.clear();
    for (std::size_t i = 0; i < green.size(); ++i)
      rendered.pixels.push_back(0.2126f * red[i] + 0.7152f * green[i] + 0.0722f * blue[i]);
    rendered.excess = result.excess;
  }
  return rendered;
}

/// Mean of a - b over that of b, and its standard error: pixels are independent, seeds the same.
Mean relative_difference(const std::vector<float>& a, const std::vector<float>& b) {
  const double n = static_cast<double>(a.size());
  double light = 0, mean = 0, squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    light += static_cast<double>(b[i]) / n;
    mean += (static_cast<double>(a[i]) - static_cast<double>(b[i])) / n;
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double off = static_cast<double>(a[i]) - static_cast<double>(b[i]) - mean;
    squares += off * off;
  }
  return {mean / light, std::sqrt(squares / (n * (n - 1))) / light};
}

/// What the render says of its rows against what a second render without rows shows. |z| beyond 4.5 once in 150,000.
void expect_reported(const Rendered& rendered, const Mean& bias, const char* what, double setting) {
  ASSERT_TRUE(rendered.excess);
  EXPECT_GT(rendered.excess->error, 0);
  EXPECT_LT(std::abs(rendered.excess->value - bias.value), 4.5 * std::hypot(rendered.excess->error, bias.error))
      << what << ' ' << setting << ": reported " << rendered.excess->value << " +- " << rendered.excess->error
      << ", found " << bias.value << " +- " << bias.error;
}

// |bias| <= variation x bound + 4 standard errors, five times: one false alarm in 3,000 runs were the bias the bound
// itself; seeds are fixed. A tenth of the bound, which sky and studio keep, is broken here by the coarsest of them: it
// is no idle one.
TEST(BiasBound, holds_against_exact) {
  const scene::Scene scene = hair();
  const Rendered exact = render(scene, Estimator::exact, {}, 24);
  std::vector<std::uint64_t> rows;
  for (const double picture_error : {0.3, 0.1, 0.03}) {
    adaptive::Options learning;
    learning.picture_error = picture_error;
    const Rendered rendered = render(scene, Estimator::fitted, learning, 24);
    const Mean bias = relative_difference(rendered.pixels, exact.pixels);
    EXPECT_GT(rendered.bound, 0);
    EXPECT_LE(rendered.bound, 10 * picture_error) << "E / n of each row, at v = .1; the bound is at v = 1";
    EXPECT_LE(std::abs(bias.value), variation * rendered.bound + 4 * bias.error) << "picture error " << picture_error;
    expect_reported(rendered, bias, "picture error", picture_error);
    rows.push_back(rendered.fitted_rows);
    if (picture_error == 0.3) {
      EXPECT_GT(std::abs(bias.value), 0.1 * rendered.bound + 4 * bias.error);
    }
  }
  EXPECT_FALSE(exact.excess) << "nothing to report";
  EXPECT_LT(rows[0], rows[1]) << "the more the picture may err, the fewer rows are fitted";
  EXPECT_LE(rows[1], rows[2]);
  for (const double epsilon : {0.3, 0.01}) {
    adaptive::Options learning;
    learning.epsilon = epsilon;
    const Rendered rendered = render(scene, Estimator::fitted, learning, 24);
    const Mean bias = relative_difference(rendered.pixels, exact.pixels);
    EXPECT_LE(std::abs(bias.value), variation * rendered.bound + 4 * bias.error) << "epsilon " << epsilon;
    expect_reported(rendered, bias, "epsilon", epsilon);
  }
}

TEST(BiasBound, pictures_by_light_are_the_same_bits_for_any_number_of_threads) {
  const scene::Scene scene = hair();
  adaptive::Options learning;
  learning.picture_error = 0.1;
  const Rendered one = render(scene, Estimator::fitted, learning, 4, 1);
  for (const int threads : {2, 8}) {
    const Rendered many = render(scene, Estimator::fitted, learning, 4, threads);
    EXPECT_EQ(one.pixels, many.pixels);
    EXPECT_EQ(one.bound, many.bound);
    EXPECT_EQ(one.excess->value, many.excess->value);
    EXPECT_EQ(one.excess->error, many.excess->error);
  }
}

}  // namespace
}  // namespace tress::integrate
