#include "models/fiber3d.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "fiber/rough_fiber.h"
#include "support/chi_square.h"
#include "tress/base/random.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberParameters;
using fiber::FiberSample;
using fiber::Lobe;

constexpr float pi = std::numbers::pi_v<float>;

/// Fibers of one model share the energies of their cross-section.
struct TracedModel {
  explicit TracedModel(const FiberParameters& parameters) : id(shared().add_fiber(parameters)) {}
  static fiber::FiberModel& shared() {
    static const std::unique_ptr<fiber::FiberModel> shared = fiber::make_fiber3d({});
    return *shared;
  }
  FiberEvent begin(const FiberDirection& wr, float h) const { return model->begin(id, wr, 0.3f, 0.6f, h); }
  FiberSample draw(const FiberDirection& wr, float h, RandomStream& random) const {
    return model->sample(begin(wr, h), {random.next(), random.next(), random.next(), random.next()});
  }
  fiber::FiberModel* model = &shared();
  fiber::FiberId id;
};

bool is_finite(const glm::vec3& color) {
  return std::isfinite(color.r) && std::isfinite(color.g) && std::isfinite(color.b);
}

TEST(Fiber3d, SaysThatItCanOnlyBeSampled) {
  const TracedModel traced(FiberParameters{});
  EXPECT_FALSE(traced.model->evaluates());
  const fiber::FiberValue value = traced.model->evaluate(traced.begin({0.3f, 0.7f}, 0.1f), {-0.3f, -2.0f});
  EXPECT_EQ(value.pdf, 0);
  EXPECT_EQ(value.total(), glm::vec3(0.0f));
}

// The corners of what a scene accepts, and beyond: the axis, the edge of the fiber, uniforms at their ends.
TEST(Fiber3d, IsFiniteForEveryInput) {
  for (const float e : {0.5f, 0.85f, 1.0f}) {
    for (const float alpha : {0.01f, 0.2f, 1.0f}) {
      for (const float tilt : {0.0f, 0.2f, 1.5f}) {
        for (const float sigma_a : {0.0f, 1.0f, 1e30f}) {
          FiberParameters parameters;
          parameters.eccentricity = e;
          parameters.roughness = alpha;
          parameters.tilt = tilt;
          parameters.sigma_a = glm::vec3(0, sigma_a, 0.1f * sigma_a);
          const TracedModel traced(parameters);
          RandomStream random(1);
          for (const float theta : {-pi / 2, -1.57f, 0.0f, 0.9f, 1.5707f, pi / 2, 2.0f}) {
            for (const float phi : {-pi, 0.0f, pi / 2, 7.0f}) {
              for (const float h : {-1.0f, -0.3f, 0.0f, 0.999999f, 1.0f, 1.5f}) {
                const FiberEvent event = traced.begin({theta, phi}, h);
                for (const float first : {0.0f, 0.5f, 0.99999994f}) {
                  const FiberSample sample = traced.model->sample(event, {first, random.next(), first, random.next()});
                  const glm::vec3 weight = sample.value.total();
                  ASSERT_TRUE(is_finite(weight) && weight.g >= 0 && weight.b >= 0) << theta << ' ' << phi << ' ' << h;
                  ASSERT_LE(std::max({weight.r, weight.g, weight.b}), 1.0f);
                  ASSERT_EQ(sample.value.pdf, 1);
                  ASSERT_LE(std::abs(sample.wi.theta), pi / 2);
                  ASSERT_LE(std::abs(sample.wi.phi), pi);
                }
              }
            }
          }
        }
      }
    }
  }
}

TEST(Fiber3d, DrawsThePathOfItsNumbers) {
  const TracedModel one(FiberParameters{}), other(FiberParameters{});
  EXPECT_EQ(one.id, other.id);
  RandomStream random(2), again(2);
  int differ = 0;
  for (int i = 0; i < 100; ++i) {
    const FiberSample a = one.draw({0.4f, 1.0f}, 0.2f, random), b = other.draw({0.4f, 1.0f}, 0.2f, again);
    EXPECT_EQ(a.wi.theta, b.wi.theta);
    EXPECT_EQ(a.wi.phi, b.wi.phi);
    EXPECT_EQ(a.value.total(), b.value.total());
    const FiberSample moved = one.model->sample(one.begin({0.4f, 1.0f}, 0.21f), {0.1f, 0.2f, 0.9f, 0.9f});
    const FiberSample first = one.model->sample(one.begin({0.4f, 1.0f}, 0.2f), {0.1f, 0.2f, 0.9f, 0.9f});
    differ += moved.wi.theta != first.wi.theta;
  }
  EXPECT_EQ(differ, 100) << "h does not matter";
}

// In the near field of a nearly smooth round fiber the reflection leaves in the mirrored direction of h, and R comes
// with the frequency of Fresnel's law: 0.0465 at normal incidence, eta 1.55 (5 standard errors, alpha 0.01 adds 1e-4).
TEST(Fiber3d, EntersAtTheOffsetOfTheHit) {
  FiberParameters parameters;
  parameters.eccentricity = 1;
  parameters.roughness = 0.01f;
  parameters.tilt = 0;
  const TracedModel traced(parameters);
  RandomStream random(3);
  test::SampleMean azimuth, reflected;
  const float h = 0.5f, phi = 0.8f;
  for (int i = 0; i < 20000; ++i) {
    const FiberSample sample = traced.draw({0, phi}, h, random);
    if (sample.lobe == Lobe::r) azimuth.add(static_cast<double>(sample.wi.phi));
    reflected.add(sample.lobe == Lobe::r ? 1 : 0);
  }
  EXPECT_NEAR(azimuth.mean(), phi + 2 * std::asin(h), 5 * azimuth.standard_error() + 1e-3);
  const double cos_i = std::sqrt(0.75), cos_t = std::sqrt(1 - 0.25 / (1.55 * 1.55));
  const double rs = (cos_i - 1.55 * cos_t) / (cos_i + 1.55 * cos_t),
               rp = (1.55 * cos_i - cos_t) / (1.55 * cos_i + cos_t);
  EXPECT_NEAR(reflected.mean(), 0.5 * (rs * rs + rp * rp), 5 * reflected.standard_error() + 1e-4);
}

TEST(Fiber3d, GivesEveryOrderToItsLobeUnderItsGain) {
  FiberParameters parameters;
  parameters.sigma_a = glm::vec3(0, 0.5f, 2);
  for (std::size_t p = 0; p < fiber::lobe_count; ++p) parameters.gain[p] = glm::vec3(static_cast<float>(p + 1), 1, 1);
  const TracedModel traced(parameters);
  RandomStream random(4);
  std::array<int, fiber::lobe_count> drawn{};
  for (int i = 0; i < 4000; ++i) {
    const FiberSample sample = traced.draw({0.5f, 0.7f}, 2 * random.next() - 1, random);
    const auto lobe = static_cast<std::size_t>(sample.lobe);
    const glm::vec3 s = sample.value.s[lobe];
    ++drawn[lobe];
    EXPECT_EQ(sample.value.total(), s);
    EXPECT_LE(s.r, static_cast<float>(lobe + 1));
    if (!(s.r > 0)) continue;
    if (lobe == 0) {
      EXPECT_EQ(s.g, s.b);
      continue;
    }
    EXPECT_LT(s.g, s.r);
    EXPECT_NEAR(std::pow(s.g * static_cast<float>(lobe + 1) / s.r, 4.0f), s.b * static_cast<float>(lobe + 1) / s.r,
                1e-3f);
  }
  for (std::size_t p = 0; p < 5; ++p) EXPECT_GT(drawn[p], 0) << p;
  EXPECT_EQ(drawn[static_cast<std::size_t>(Lobe::glint)], 0);
}

TEST(Fiber3d, PartsTrtWhereTheFiberSplitsOffItsGlint) {
  FiberParameters parameters;
  parameters.split_glint = true;
  const TracedModel traced(parameters);
  RandomStream random(5);
  double trt = 0, glint = 0;
  for (int i = 0; i < 4000; ++i) {
    const FiberSample sample = traced.draw({0.2f, 0.7f}, 2 * random.next() - 1, random);
    trt += static_cast<double>(sample.value.s[2].g);
    glint += static_cast<double>(sample.value.s[5].g);
  }
  EXPECT_GT(glint, 0.2 * (trt + glint));
  EXPECT_GT(trt, 0.2 * (trt + glint));
}

// atan2 gives pi itself for light that leaves along -v: directions are in [-pi, pi).
TEST(fiber3d, leaves_along_the_seam_at_minus_pi) {
  constexpr float pi = std::numbers::pi_v<float>;
  for (const float w : {0.0f, -0.0f, 1e-9f}) {
    fiber::RoughExit exit;
    exit.direction = {0.6f, -0.8f, w};
    EXPECT_LT(exit.angles().phi, pi) << w;
    EXPECT_NEAR(exit.angles().phi, -pi, 1e-6f) << w;
  }
}

}  // namespace
}  // namespace tress
