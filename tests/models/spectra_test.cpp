// Color by wavelength and texture: the values of an event under absorptions that no fiber was added with.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "tress/adaptive/service.h"
#include "tress/base/random.h"
#include "tress/fiber/chiang2016_model.h"
#include "tress/fiber/rough_model.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberSample;
using fiber::FiberValue;

constexpr float pi = std::numbers::pi_v<float>;
const glm::vec3 brown(0.545f, 0.906f, 1.781f);

fiber::FiberParameters hair(const glm::vec3& sigma_a) {
  fiber::FiberParameters parameters;
  parameters.sigma_a = sigma_a;
  return parameters;
}

/// One shape in three colors, and events at one direction: of rows, or before them.
struct Colors {
  explicit Colors(int passes)
      : service(options(), *target), model(*make_rough_model(fiber::Estimator::fitted, &service)) {
    for (const glm::vec3& sigma_a : {glm::vec3(0), brown, glm::vec3(0.02f, 0.4f, 6)})
      ids.push_back(model->add_fiber(hair(sigma_a)));
    if (passes > 0) service.prepare();
    for (int pass = 0; pass < passes; ++pass) {
      RandomStream random(5, static_cast<std::uint64_t>(pass));
      for (int i = 0; i < 2000; ++i)
        (void)model->sample(begin(1, random), {random.next(), random.next(), random.next(), random.next()});
      service.publish(2000);
    }
  }
  static adaptive::Options options() {
    adaptive::Options options;
    options.heard_share = 0.1f;
    return options;
  }
  FiberEvent begin(std::size_t color, RandomStream& random) const {
    const float xi1 = random.next(), xi2 = random.next();
    return model->begin(ids[color], wr, xi1, xi2, 2 * random.next() - 1);
  }
  std::unique_ptr<adaptive::SampledTarget> target = fiber::make_rough_target();
  adaptive::Service service;
  std::unique_ptr<fiber::FiberModel> model;
  std::vector<fiber::FiberId> ids;
  FiberDirection wr{0.33f, 0.83f};
};

FiberDirection any_direction(RandomStream& random) {
  return {pi * (random.next() - 0.5f), pi * (2 * random.next() - 1)};
}

// Rows round densities to 2e-3, and energies are corrected at the node instead of at wr: about a per cent. The sum of
// absolute differences over that of values is 0.0087.
TEST(Spectra, AreTheValuesOfAFiberOfThatColor) {
  const Colors of(6);
  double off = 0, all = 0;
  for (int i = 0; i < 3000; ++i) {
    RandomStream random(9, static_cast<std::uint64_t>(i));
    const FiberDirection wi = any_direction(random);
    for (const std::size_t color : {0u, 2u}) {
      RandomStream one = random, other = random;
      const FiberEvent event = of.begin(1, one), its_own = of.begin(color, other);
      ASSERT_TRUE(of.model->evaluates(event));
      const glm::vec3& sigma_a = color == 0 ? glm::vec3(0) : glm::vec3(0.02f, 0.4f, 6);
      std::array<float, 3> s{};
      const float pdf = of.model->evaluate_spectrum(event, wi, {&sigma_a.x, 3}, s);
      EXPECT_EQ(pdf, of.model->evaluate(event, wi).pdf);
      EXPECT_EQ(of.model->pdf(event, wi), pdf);
      const glm::vec3 expected = of.model->evaluate(its_own, wi).total();
      for (int c = 0; c < 3; ++c) {
        off += std::abs(double{s[static_cast<std::size_t>(c)]} - double{expected[c]});
        all += double{expected[c]};
      }
    }
  }
  RecordProperty("difference", std::to_string(off / all));
  EXPECT_LT(off / all, 0.02);
}

// Before rows answer, both are the same traced path.
TEST(Spectra, OfATracedPathAreItsOwnValues) {
  const Colors of(0);
  for (int i = 0; i < 300; ++i) {
    RandomStream random(10, static_cast<std::uint64_t>(i));
    const FiberEvent event = of.begin(1, random);
    ASSERT_FALSE(of.model->evaluates(event));
    const FiberDirection wi = any_direction(random);
    const std::array<float, 5> sigma_a{brown.x, brown.y, brown.z, brown.x, 100};
    std::array<float, 5> s{}, weights{};
    EXPECT_EQ(of.model->evaluate_spectrum(event, wi, sigma_a, s), of.model->pdf(event, wi));
    const FiberValue value = of.model->evaluate(event, wi);
    EXPECT_EQ(of.model->pdf(event, wi), value.pdf);
    const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
    const FiberSample drawn = of.model->sample_spectrum(event, u, sigma_a, weights);
    for (int c = 0; c < 3; ++c) {
      EXPECT_FLOAT_EQ(s[static_cast<std::size_t>(c)], value.total()[c]);
      EXPECT_NEAR(weights[static_cast<std::size_t>(c)], drawn.value.total()[c], 1e-5f * drawn.value.total()[c]);
    }
    EXPECT_EQ(s[3], s[0]);
    EXPECT_LE(weights[4], weights[0]);
  }
}

// Clear light of a brown fiber's events, and heard paths among them: a furnace keeps all of it. 40,000 draws; the bound
// is 5 standard errors, a false alarm in 1e-6 for seed 11.
TEST(Spectra, OfClearHairKeepAllLight) {
  const Colors of(6);
  RandomStream random(11);
  double sum = 0, squares = 0;
  constexpr int draws = 40000;
  for (int i = 0; i < draws; ++i) {
    const FiberEvent event = of.begin(1, random);
    const float clear = 0;
    float s = 0;
    const FiberSample drawn = of.model->sample_spectrum(
        event, {random.next(), random.next(), random.next(), random.next()}, {&clear, 1}, {&s, 1});
    const double weight = double{s} / double{drawn.value.pdf};
    sum += weight / draws;
    squares += weight * weight / draws;
  }
  EXPECT_NEAR(sum, 1, 5 * std::sqrt((squares - sum * sum) / draws));
}

// Of rows, of paths that an event of a row draws instead, and before rows answer. NaN and what is below 0 count as 0,
// infinity as the largest absorption; where the spans differ the shorter counts.
TEST(Spectra, ClampWhatIsNoAbsorption) {
  constexpr float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  for (const int passes : {0, 6}) {
    const Colors of(passes);
    for (int i = 0; i < 200; ++i) {
      RandomStream random(12, static_cast<std::uint64_t>(i));
      const FiberEvent event = of.begin(1, random);
      const FiberDirection wi = any_direction(random);
      const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
      const std::array<float, 8> strange{nan, -1, -infinity, infinity, 3e38f, 1e-42f, 1, 2};
      const std::array<float, 8> meant{0, 0, 0, 1e20f, 1e20f, 1e-42f, 1, 2};
      std::array<float, 8> s, expected, weights, expected_weights;
      EXPECT_EQ(of.model->evaluate_spectrum(event, wi, strange, s),
                of.model->evaluate_spectrum(event, wi, meant, expected));
      of.model->sample_spectrum(event, u, strange, weights);
      of.model->sample_spectrum(event, u, meant, expected_weights);
      EXPECT_EQ(s, expected);
      EXPECT_EQ(weights, expected_weights);
      for (std::size_t c = 0; c < s.size(); ++c) EXPECT_TRUE(std::isfinite(s[c]) && std::isfinite(weights[c])) << c;
      for (const FiberDirection& odd : {FiberDirection{nan, infinity}, {infinity, nan}}) {
        EXPECT_TRUE(std::isfinite(of.model->evaluate_spectrum(event, odd, strange, s)));
        for (const float one : s) EXPECT_TRUE(std::isfinite(one));
      }

      std::array<float, 2> two;
      std::array<float, 4> longer;
      of.model->evaluate_spectrum(event, wi, std::span(meant).last(2), two);
      of.model->evaluate_spectrum(event, wi, std::span(meant).last(2), longer);
      EXPECT_EQ(longer, (std::array{two[0], two[1], 0.0f, 0.0f}));
      of.model->sample_spectrum(event, u, {}, longer);
      EXPECT_EQ(longer, (std::array<float, 4>{}));
    }
  }
}

TEST(Spectra, OfOtherModelsAreZero) {
  const auto model = fiber::make_chiang2016_model();
  EXPECT_FALSE(model->has_spectra());
  const FiberEvent event = model->begin(model->add_fiber(hair(brown)), {0.3f, 0.8f}, 0.5f, 0.5f, 0.1f);
  float s = 1;
  EXPECT_EQ(model->evaluate_spectrum(event, {0.1f, 1}, {&brown.x, 1}, {&s, 1}), model->evaluate(event, {0.1f, 1}).pdf);
  EXPECT_EQ(s, 0);
}

}  // namespace
}  // namespace tress
