// The mixture's density and inverse CDF: masses, extremes, agreement of sample and proposal_density.
#include "tress/adaptive/mixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "base/exp_of_negative.h"
#include "support/quadrature.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr float last_u = 1.0f - 0x1p-24f;

// Panels end at the mode, where the two halves meet; narrow scales need short ones.
double mass_between(const SkewLogistic& shape, double from, double to) {
  return test::integrate([&](double x) { return shape.density(static_cast<float>(shape.mu + x)); }, from, to, 2000);
}

Mixture two_parts() {
  Mixture mixture;
  mixture.component_count = 2;
  mixture.components[0] = {{0.4f, 0.1f, 0.3f}, 0.3f};
  mixture.components[1] = {{3.1f, 0.05f, 0.02f}, 0.2f};
  mixture.uniform_weight = 0.1f;
  return mixture;
}

/// SkewLogistic::sample() as its formula stands, by the hyperbolic tangent of the standard library.
float sample_by_formula(const SkewLogistic& shape, double u) {
  const auto mass = [](double s) { return s * std::tanh(0.5 * pi / s); };
  const auto quantile = [](double v, double s) {
    const double e = std::exp(-pi / s), t = (1.0 - e) / (1.0 + e);
    return std::min(s * std::log((1.0 + v * t) / std::max((1.0 - v) * t + 2.0 * e / (1.0 + e), 1e-300)), pi);
  };
  const double left = mass(shape.s_left), p_left = left / (left + mass(shape.s_right));
  const double x = u < p_left ? -quantile(1.0 - u / p_left, shape.s_left)
                              : quantile(std::min((u - p_left) / (1.0 - p_left), 1.0), shape.s_right);
  return wrap_angle(static_cast<float>(shape.mu + x));
}

TEST(FastExp, StaysWithinItsStatedError) {
  for (float x = 0; x > -86.9f; x -= 1e-3f) {
    ASSERT_NEAR(exp_of_negative(x) / std::exp(static_cast<double>(x)), 1, 3e-7) << x;
  }
  EXPECT_GT(exp_of_negative(-1e30f), 0.0f);
}

TEST(WrapAngle, LandsInTheHalfOpenCircle) {
  const float limit = std::numbers::pi_v<float>;
  for (const float x : {0.0f, limit, -limit, 3 * limit, 100.0f, -100.0f, 1e6f, std::nextafter(limit, 0.0f)}) {
    EXPECT_GE(wrap_angle(x), -limit);
    EXPECT_LT(wrap_angle(x), limit);
    EXPECT_NEAR(std::cos(wrap_angle(x)), std::cos(static_cast<double>(x)), 1e-6);
  }
}

TEST(SkewLogistic, HasMassOne) {
  for (const float left : {0.004f, 0.02f, 0.1f, 0.3f, 0.5f}) {
    for (const float right : {0.004f, 0.17f, 0.5f, 5.0f}) {
      const SkewLogistic shape{2.9f, left, right};
      // Float density (1e-6) at float azimuths: at s = 0.004 a rounding of 2e-7 rad moves a value by 6e-5, at random.
      EXPECT_NEAR(mass_between(shape, -pi, 0) + mass_between(shape, 0, pi), 1, 2e-5) << left << " " << right;
    }
  }
}

TEST(SkewLogistic, SampleInvertsTheCumulativeDensity) {
  for (const SkewLogistic& shape :
       {SkewLogistic{-2.5f, 0.05f, 0.4f}, SkewLogistic{0.0f, 0.5f, 0.1f}, SkewLogistic{1.0f, 5.0f, 5.0f}}) {
    for (const float u : {0.001f, 0.1f, 0.3f, 0.5f, 0.7f, 0.9f, 0.999f}) {
      double x = wrap_angle(shape.sample(u) - shape.mu);
      EXPECT_NEAR(mass_between(shape, -pi, std::min(x, 0.0)) + (x > 0 ? mass_between(shape, 0, x) : 0), u, 1e-5);
    }
  }
}

// Draws are what stored tables and pictures depend on: faster steps must have the same bits.
TEST(SkewLogistic, SamplesHaveTheBitsOfTheFormula) {
  for (std::uint32_t i = 0; i < 20000; ++i) {
    RandomStream random(17, i);
    const auto scale = [&] { return 0.004f * std::pow(125.0f, random.next()); };  // to 0.5
    const SkewLogistic shape{wrap_angle(7 * random.next()), scale(), scale()};
    const float u = random.next();
    ASSERT_EQ(shape.sample(u), sample_by_formula(shape, u)) << shape.s_left << " " << shape.s_right << " " << u;
  }
}

// The density in lanes is the sum over the parts one by one, whatever their number and wherever they wrap.
TEST(PackedMixture, DrawsInOneCallWhatSeveralGive) {
  alignas(16) std::array<std::byte, PackedMixture::bytes_of(Mixture::max_components)> memory;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    RandomStream random(19, i);
    Mixture mixture;
    mixture.component_count = i % (Mixture::max_components + 1);
    mixture.uniform_weight = i % 2 == 0 ? 0 : random.next();
    for (Component& part : std::span(mixture.components).first(mixture.component_count)) {
      const float left = 0.004f * std::pow(125.0f, random.next()), right = 0.004f * std::pow(125.0f, random.next());
      part = {{wrap_angle(7 * random.next()), left, right}, random.next()};
    }
    const PackedMixture& packed = *PackedMixture::put(memory.data(), mixture, 0);
    const float share = i % 5 == 0 ? 0.0f : 0.02f;
    const float u = random.next();
    const MixtureDraw drawn = packed.draw(u, share);
    ASSERT_EQ(drawn.azimuth, packed.sample(u, share));
    ASSERT_EQ(drawn.density, packed.density(drawn.azimuth));
    ASSERT_EQ(drawn.pdf, packed.proposal_density(drawn.azimuth, share));
    float sum = mixture.uniform_weight * (0.5f * std::numbers::inv_pi_v<float>);
    for (const Component& part : mixture.parts()) sum += part.weight * part.shape.density(drawn.azimuth);
    ASSERT_EQ(drawn.density, sum) << mixture.component_count;
  }
}

TEST(SkewLogistic, IsFiniteAtTheExtremes) {
  for (const float s : {0.004f, 0.5f, 5.0f}) {
    for (const float u : {0.0f, 0x1p-24f, 0.5f, last_u}) {
      const SkewLogistic shape{-3.1f, s, s};
      const float x = shape.sample(u);
      EXPECT_GE(x, -std::numbers::pi_v<float>);
      EXPECT_LT(x, std::numbers::pi_v<float>);
      EXPECT_TRUE(std::isfinite(shape.density(x)));
      EXPECT_GE(shape.density(wrap_angle(shape.mu + 3.1415f)), 0.0f);
    }
  }
}

TEST(Mixture, ProposalHasMassOneAndTheUniformFloor) {
  const Mixture mixture = two_parts();
  EXPECT_FLOAT_EQ(mixture.energy(), 0.6f);
  const auto q = [&](double x) { return mixture.proposal_density(static_cast<float>(x), 0.02f); };
  // Panels of 0.0016 rad against scales of 0.02: the kinks at the modes cost less than 1e-5.
  EXPECT_NEAR(test::integrate(q, -pi, pi, 4000), 1, 2e-5);
  for (double x = -pi; x < pi; x += 0.01) EXPECT_GE(q(x), 0.02 / (2 * pi) * 0.999999);
}

TEST(Mixture, WithoutEnergyProposesUniformly) {
  const Mixture nothing;
  EXPECT_FLOAT_EQ(nothing.proposal_density(1.0f, 0.02f), static_cast<float>(1 / (2 * pi)));
  EXPECT_NEAR(nothing.sample(0.75f, 0.0f), pi / 2, 1e-6);
}

TEST(Mixture, ConvergedWeightIsBoundedByTheUniformShare) {
  const Mixture mixture = two_parts();
  for (float x = -3.14f; x < 3.14f; x += 0.01f) {
    EXPECT_LE(mixture.density(x) / (mixture.energy() * mixture.proposal_density(x, 0.02f)), 1 / 0.98f * 1.000001f);
  }
}

TEST(Mixture, SampleUsesTheWholeOfU) {
  for (const float u : {0.0f, 0.0199999f, 0.02f, 0.5f, last_u}) {
    const float x = two_parts().sample(u, 0.02f);
    EXPECT_GE(x, -std::numbers::pi_v<float>);
    EXPECT_LT(x, std::numbers::pi_v<float>);
  }
}

// What a table publishes is a packed copy: the stop test judges the one, readers draw from the other.
TEST(Mixture, PackedAnswersToTheBit) {
  for (std::uint32_t count = 0; count <= Mixture::max_components; ++count) {
    Mixture mixture;
    mixture.component_count = count;
    mixture.uniform_weight = 0.05f * static_cast<float>(count % 3);
    for (std::uint32_t d = 0; d < count; ++d) {
      const auto i = static_cast<float>(d);
      mixture.components[d] = {{0.7f * i - 2.5f, 0.05f + 0.05f * i, 0.3f - 0.03f * i}, 0.1f + 0.01f * i, 0, 0};
    }
    std::vector<float> memory(PackedMixture::bytes_of(count) / sizeof(float));
    const PackedMixture& packed = *PackedMixture::put(memory.data(), mixture, 0.25f);
    EXPECT_EQ(packed.objective, 0.25f);
    EXPECT_EQ(packed.energy(), mixture.energy());
    for (float x = -3.1f; x < 3.1f; x += 0.173f) {
      ASSERT_EQ(packed.density(x), mixture.density(x));
      ASSERT_EQ(packed.proposal_density(x, 0.02f), mixture.proposal_density(x, 0.02f));
      ASSERT_EQ(Mixture(packed).density(x), mixture.density(x));
    }
    for (float u = 0; u < 1; u += 0.0371f) ASSERT_EQ(packed.sample(u, 0.02f), mixture.sample(u, 0.02f));
  }
}

// 8 bits behind the point, to the nearest: within 2^-9; and what has been rounded stays.
// Four components at a time, and added one after the other.
TEST(Mixture, DensityIsTheSumOfItsComponentsToTheBit) {
  for (std::uint32_t count = 0; count <= Mixture::max_components; ++count) {
    Mixture mixture;
    mixture.component_count = count;
    mixture.uniform_weight = 0.1f;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto k = static_cast<float>(i);
      mixture.components[i] = {{wrap_angle(0.9f * k - 3), 0.004f + 0.07f * k, 0.5f - 0.06f * k}, 0.1f + 0.03f * k};
    }
    for (float x = -10; x < 10; x += 0.013f) {
      float sum = mixture.uniform_weight * (0.5f * std::numbers::inv_pi_v<float>);
      for (const Component& one : mixture.parts()) sum += one.weight * one.shape.density(x);
      ASSERT_EQ(mixture.density(x), sum) << count << " at " << x;
    }
  }
}

TEST(Mixture, PackedAttributesAreRoundedOnce) {
  for (const float attribute : {0.0f, 1e-37f, 0.001f, 0.9999f, 1.0f, 2.0f, 2.71828f, 1e6f, 3.4e38f}) {
    Mixture mixture;
    mixture.component_count = 1;
    mixture.components[0].attribute_mean = mixture.uniform_attribute_variance = attribute;
    std::vector<float> memory(PackedMixture::bytes_of(1) / sizeof(float));
    const Mixture once = *PackedMixture::put(memory.data(), mixture, 0);
    EXPECT_NEAR(once.components[0].attribute_mean, attribute, attribute * 0x1p-9f);
    EXPECT_EQ(once.uniform_attribute_variance, once.components[0].attribute_mean);
    EXPECT_EQ(once.components[0].attribute_variance, 0);
    const Mixture twice = *PackedMixture::put(memory.data(), once, 0);
    EXPECT_EQ(twice.components[0].attribute_mean, once.components[0].attribute_mean);
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
