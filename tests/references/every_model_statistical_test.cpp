// Samplers of all models of the registry against their densities, and their mean weights. Seeds are fixed; each
// family's false-alarm rate is 1e-4.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <string>

#include "models/model_measures.h"
#include "references/registry.h"
#include "support/seed.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberParameters;
using test::OneFiber;

constexpr float degree = std::numbers::pi_v<float> / 180;
constexpr double family_level = 1e-4;

class every_model_statistics : public testing::TestWithParam<std::size_t> {
 protected:
  const fiber::ModelInfo& info() const { return references::models()[GetParam()]; }
  /// Rays or points at every vertex: such models are asked less often.
  bool is_slow() const { return info().has_rows() || info().has_quadrature; }
};

std::string name_of(const testing::TestParamInfo<std::size_t>& index) {
  std::string name = references::models()[index.param].name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(models, every_model_statistics, testing::Range(std::size_t{0}, references::models().size()),
                         name_of);

struct Case {
  float e, theta_deg, phi, h, roughness;
  glm::vec3 sigma_a;
};
constexpr Case cases[] = {{0.8f, 17, 0.7f, 0.3f, 0.3f, {0.3f, 0.5f, 1}}, {1, -83, -2.5f, -0.7f, 0.2f, {0, 0, 0}}};

FiberParameters fiber_of(const Case& k) {
  FiberParameters parameters;
  parameters.eccentricity = k.e;
  parameters.roughness = k.roughness;
  parameters.sigma_a = k.sigma_a;
  return parameters;
}

// 16 x 16 bins (12 x 12), 8 x 8 points in each: bins of 15 x 30 degrees hold lobes of 6 degrees and more to 1e-3 of a
// count of some hundred, far below its deviation.
TEST_P(every_model_statistics, samples_follow_the_density) {
  for (const Case& k : cases) {
    const OneFiber fiber(info(), fiber_of(k));
    if (!fiber.model().evaluates()) return;
    const auto event = fiber.begin({k.theta_deg * degree, k.phi}, k.h);
    const test::ChiSquare result = test::samples_against_density(fiber.model(), event, is_slow() ? 6000 : 20000,
                                                                 is_slow() ? 12 : 16, test::seed(17));
    EXPECT_GT(result.degrees_of_freedom, 20);
    EXPECT_GT(result.p_value, test::sidak_level(family_level, 2 * references::models().size()))
        << "theta_r " << k.theta_deg;
    std::printf("%s theta_r %.0f: p value %.3g, %d degrees of freedom\n", info().name, static_cast<double>(k.theta_deg),
                result.p_value, result.degrees_of_freedom);
  }
}

// The mean weight at one xi and h is the integral of S, to 4.5 standard errors (7e-6 each), 3e-3 for kinks and the
// difference to a coarser rule, which bounds the error of the finer one. A
// model that is only sampled returns no more than it receives, to the rounding of 10,000 sums.
TEST_P(every_model_statistics, mean_weight_is_the_integral) {
  for (const Case& k : cases) {
    const OneFiber fiber(info(), fiber_of(k));
    const FiberDirection wr{k.theta_deg * degree, k.phi};
    const auto event = fiber.begin(wr, k.h);
    test::SampleMean mean;
    RandomStream random(test::seed(23));
    for (int i = 0; i < (is_slow() ? 2000 : 10000); ++i) {
      const fiber::FiberValue value = test::draw(fiber.model(), event, random).value;
      mean.add(double{value.total().g} / double{value.pdf});
    }
    if (fiber.model().evaluates()) {
      const double expected = test::masses(fiber.model(), event, 21, 14).s;
      const double rule = std::abs(test::masses(fiber.model(), event, 14, 9).s - expected);
      EXPECT_NEAR(mean.mean(), expected, 3e-3 + rule + 4.5 * mean.standard_error()) << "theta_r " << k.theta_deg;
      EXPECT_LT(rule, 0.02 * expected);
    } else {
      EXPECT_LT(mean.mean(), 1 + 1e-5 + 4.5 * mean.standard_error());
      EXPECT_GT(mean.mean(), 0);
    }
    std::printf("%s theta_r %.0f: mean weight %.4f +- %.4f\n", info().name, static_cast<double>(k.theta_deg),
                mean.mean(), mean.standard_error());
  }
}

}  // namespace
}  // namespace tress
