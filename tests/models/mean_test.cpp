// Evaluation without an event: the mean over the nodes that events may choose.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>

#include "base/color.h"
#include "references/registry.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"

namespace tress {
namespace {

using fiber::Estimator;
using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberSample;
using fiber::FiberValue;

/// A model whose rows around wr have been asked for some passes.
struct Model {
  Model(const char* name, Estimator estimator, int passes, float tilt = 0.05f)
      : info(*references::find_model(name)), learned(fiber::make_service(info, {})) {
    fiber::FiberParameters hair;
    hair.tilt = tilt;
    hair.roughness = 0.3f;
    model =
        info.make({.estimator = estimator, .service = estimator == Estimator::exact ? nullptr : learned.service.get()});
    id = model->add_fiber(hair);
    if (learned.service == nullptr) return;
    learned.service->prepare();
    for (int pass = 0; pass < passes; ++pass) {
      RandomStream random(5, static_cast<std::uint64_t>(pass));
      for (int i = 0; i < 1000; ++i) {
        const FiberEvent event = model->begin(id, wr, random.next(), random.next(), 0);
        (void)model->sample(event, {random.next(), random.next(), random.next(), random.next()});
      }
      learned.service->publish(1000);
    }
  }
  const fiber::ModelInfo& info;
  fiber::ModelService learned;
  std::unique_ptr<fiber::FiberModel> model;
  fiber::FiberId id = 0;
  FiberDirection wr{0.33f, 0.83f};
};

// Midpoints of n x n: S and Q are constant between at most 4 steps of xi1 and one of xi2, so that the error is at most
// (4 + 1)/(2 n) of what they range over.
void expect_mean_of_events(const Model& of, const FiberDirection& wr, const FiberDirection& wi) {
  constexpr int n = 48;
  double s = 0, pdf = 0, least_s = 1e30, most_s = 0, least_pdf = 1e30, most_pdf = 0;
  for (int i = 0; i < n * n; ++i) {
    const float xi1 = (static_cast<float>(i % n) + 0.5f) / n, xi2 = (static_cast<float>(i / n) + 0.5f) / n;
    const FiberValue one = of.model->evaluate(of.model->begin(of.id, wr, xi1, xi2, 0), wi);
    const double light = double{luminance(one.total())};
    s += light / (n * n);
    pdf += double{one.pdf} / (n * n);
    least_s = std::min(least_s, light);
    most_s = std::max(most_s, light);
    least_pdf = std::min(least_pdf, double{one.pdf});
    most_pdf = std::max(most_pdf, double{one.pdf});
  }
  const FiberValue mean = of.model->mean(of.id, wr, wi);
  EXPECT_NEAR(double{luminance(mean.total())}, s, 2.5 / n * (most_s - least_s) + 1e-5 * s);
  EXPECT_NEAR(double{mean.pdf}, pdf, 2.5 / n * (most_pdf - least_pdf) + 1e-5 * pdf);
}

TEST(Mean, IsThatOfEventsOverXi) {
  for (const char* name : {"elliptical", "rough"}) {
    for (const int passes : {0, 1, 8}) {
      for (const float tilt : {0.0f, 0.05f}) {
        const Model of(name, Estimator::fitted, passes, tilt);
        for (const FiberDirection& wr : {of.wr, FiberDirection{-0.4f, -2.0f}, FiberDirection{1.56f, 0}})
          for (const FiberDirection& wi : {FiberDirection{-0.3f, 1.6f}, FiberDirection{0.1f, -2.5f}})
            expect_mean_of_events(of, wr, wi);
      }
    }
  }
  expect_mean_of_events(Model("elliptical", Estimator::exact, 0), {0.2f, 1}, {-0.3f, 1.6f});
}

// Without correction and without a path of the fiber, so that it is a function of the directions.
TEST(Mean, OfCorrectedIsThatOfFitted) {
  const Model fitted("elliptical", Estimator::fitted, 6), corrected("elliptical", Estimator::corrected, 6);
  for (int i = 0; i < 200; ++i) {
    RandomStream random(3, static_cast<std::uint64_t>(i));
    const FiberDirection wi{2 * random.next() - 1, 6 * random.next() - 3};
    const FiberValue a = fitted.model->mean(fitted.id, fitted.wr, wi),
                     b = corrected.model->mean(corrected.id, fitted.wr, wi);
    EXPECT_EQ(a.total(), b.total());
    EXPECT_EQ(a.pdf, b.pdf);
  }
}

// Midpoints of 180 x 360: the narrowest lobe has a deviation of 5 degrees or more, five steps, where the rule errs by
// less than 1e-4; the mean over 4000 samples has 2.5 standard errors of what weights range over, 0.02 here.
TEST(Mean, IntegratesToTheEnergyAndIsDrawnFrom) {
  for (const char* name : {"elliptical", "rough"}) {
    const Model of(name, Estimator::fitted, 6);
    double s = 0, pdf = 0, right = 0;
    constexpr int rows = 180, columns = 360;
    constexpr double pi = std::numbers::pi;
    for (int i = 0; i < rows; ++i) {
      for (int j = 0; j < columns; ++j) {
        const FiberDirection wi{static_cast<float>(pi * ((i + 0.5) / rows - 0.5)),
                                static_cast<float>(2 * pi * ((j + 0.5) / columns - 0.5))};
        const FiberValue value = of.model->mean(of.id, of.wr, wi);
        const double area = pi / rows * 2 * pi / columns;
        s += double{luminance(value.total())} * area;
        pdf += double{value.pdf} * area;
        right += wi.phi > 0 ? double{value.pdf} * area : 0;
      }
    }
    double energy = 0;
    constexpr int n = 32;
    for (int i = 0; i < n * n; ++i) {
      const FiberEvent event = of.model->begin(of.id, of.wr, (static_cast<float>(i % n) + 0.5f) / n,
                                               (static_cast<float>(i / n) + 0.5f) / n, 0);
      glm::vec3 sum(0.0f);
      for (const glm::vec3& lobe : event.energy) sum += lobe;
      energy += double{luminance(sum)} / (n * n);
    }
    EXPECT_NEAR(s, energy, 0.005 * energy) << name << ": energies of nodes differ by some percent, over 2.5/n steps";
    EXPECT_NEAR(pdf, 1, 0.002) << name;
    double weight = 0, squares = 0, drawn_right = 0;
    constexpr int draws = 4000;
    RandomStream random(11);
    for (int i = 0; i < draws; ++i) {
      const std::array<float, 6> u{random.next(), random.next(), random.next(),
                                   random.next(), random.next(), random.next()};
      const FiberSample drawn = of.model->sample_mean(of.id, of.wr, u);
      const FiberValue again = of.model->mean(of.id, of.wr, drawn.wi);
      ASSERT_EQ(drawn.value.pdf, again.pdf);
      ASSERT_EQ(drawn.value.total(), again.total());
      const double w = double{luminance(again.total())} / double{again.pdf};
      weight += w / draws;
      squares += w * w / draws;
      drawn_right += drawn.wi.phi > 0 ? 1.0 / draws : 0;
    }
    EXPECT_NEAR(weight, s, 4 * std::sqrt((squares - weight * weight) / draws) + 1e-3) << name;
    EXPECT_NEAR(drawn_right, right, 4 * std::sqrt(right * (1 - right) / draws) + 1e-3) << name;
  }
}

TEST(Mean, IsNotKnownWhereEventsCannotBeEvaluated) {
  const Model exact("rough", Estimator::exact, 0);
  EXPECT_EQ(exact.model->mean(exact.id, exact.wr, {0.1f, 2}).pdf, 0);
  EXPECT_EQ(exact.model->sample_mean(exact.id, exact.wr, {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f}).value.pdf, 0);
  const Model fitted("rough", Estimator::fitted, 0);
  EXPECT_EQ(fitted.model->mean(fitted.id + 1, fitted.wr, {0.1f, 2}).pdf, 0);
  EXPECT_EQ(fitted.model->sample_mean(fitted.id + 1, fitted.wr, {}).value.pdf, 0);
  EXPECT_GT(fitted.model->mean(fitted.id, {std::nanf(""), INFINITY}, {std::nanf(""), 1e30f}).pdf, 0);
}

}  // namespace
}  // namespace tress
