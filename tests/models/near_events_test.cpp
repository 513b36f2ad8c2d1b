// Events that begin near: what the fiber does with light from where the ray met it, without a row.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "models/learned_model.h"
#include "tress/base/random.h"

namespace tress {
namespace {

using fiber::Estimator;
using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberParameters;
using fiber::FiberValue;

const FiberDirection wr{0.3f, 0.8f};

struct Model {
  explicit Model(const fiber::ModelInfo& info, bool has_rows = true)
      : learned(fiber::make_service(info, {})),
        model(info.make({.estimator = Estimator::fitted, .service = learned.service.get()})),
        id(model->add_fiber(FiberParameters{})) {
    if (has_rows) learned.service->prepare();
  }
  fiber::ModelService learned;
  std::unique_ptr<fiber::FiberModel> model;
  fiber::FiberId id;
};

TEST(NearEvents, AreTracedAndAskNoRow) {
  const Model rough(fiber::rough_info);
  ASSERT_TRUE(rough.model->evaluates(rough.model->begin(rough.id, wr, 0.4f, 0.6f, 0.5f)));
  const FiberEvent event = rough.model->begin_near(rough.id, wr, 0.4f, 0.6f, 0.5f);
  EXPECT_FALSE(rough.model->evaluates(event));
  EXPECT_TRUE(rough.model->estimates(event));
  EXPECT_EQ(rough.model->sample(event, {0.1f, 0.2f, 0.3f, 0.4f}).value.queries, 0u);
  EXPECT_EQ(rough.model->evaluate(event, {0.2f, -2}).queries, 0u);
  EXPECT_EQ(rough.learned.service->publish().queries, 1u) << "that of begin()";
}

// S of R at h is one place on the ellipse: light of a wi is met from one side of the fiber alone. 400 events a side; a
// row gives the same whatever h is.
TEST(NearEvents, GoByWhereTheRayMetTheFiber) {
  const Model rough(fiber::rough_info);
  const auto reflected = [&](bool is_near, float h) {
    double sum = 0;
    for (int i = 0; i < 400; ++i) {
      const float xi1 = (static_cast<float>(i) + 0.5f) / 400, xi2 = 0.5f;
      const FiberEvent event =
          is_near ? rough.model->begin_near(rough.id, wr, xi1, xi2, h) : rough.model->begin(rough.id, wr, xi1, xi2, h);
      sum += double{rough.model->evaluate(event, {-0.3f, wr.phi + 1.2f}).s[0].x};
    }
    return sum;
  };
  EXPECT_EQ(reflected(false, 0.6f), reflected(false, -0.6f));
  const double one = reflected(true, 0.6f), other = reflected(true, -0.6f);
  EXPECT_GT(std::max(one, other), 5 * std::min(one, other));
}

// A path that replaces a row enters anywhere. If its light left where the path does, drawn directions and sampled
// lights would meet other neighbours, and dense dark fur without rows would be up to 5 % brighter than with them.
TEST(NearEvents, AloneKnowWhereLightLeaves) {
  const Model rough(fiber::rough_info, false);
  for (const bool is_near : {false, true}) {
    const FiberEvent event = is_near ? rough.model->begin_near(rough.id, wr, 0.4f, 0.6f, 0.5f)
                                     : rough.model->begin(rough.id, wr, 0.4f, 0.6f, 0.5f);
    ASSERT_TRUE(rough.model->estimates(event));
    EXPECT_EQ(rough.model->evaluate(event, {0.2f, -2}).exit.is_known, is_near);
    bool is_known = false;
    for (const float u : {0.1f, 0.3f, 0.5f, 0.7f, 0.9f})
      is_known = is_known || rough.model->sample(event, {u, 0.2f, 0.3f, u}).value.exit.is_known;
    EXPECT_EQ(is_known, is_near);
  }
}

TEST(NearEvents, AreThoseOfBeginWhereAModelHasNoOthers) {
  const Model elliptical(fiber::elliptical_info);
  const FiberEvent far = elliptical.model->begin(elliptical.id, wr, 0.4f, 0.6f, 0.5f);
  const FiberDirection wi{0.1f, 2};
  const FiberValue a = elliptical.model->evaluate(far, wi);
  for (const auto begin : {&fiber::FiberModel::begin_near, &fiber::FiberModel::begin_drawn_near}) {
    const FiberValue b =
        elliptical.model->evaluate((*elliptical.model.*begin)(elliptical.id, wr, 0.4f, 0.6f, 0.5f, 1), wi);
    EXPECT_EQ(a.total(), b.total());
    EXPECT_EQ(a.pdf, b.pdf);
  }
}

TEST(DrawnNearEvents, AnswerLightsByTheirRow) {
  const Model rough(fiber::rough_info);
  const FiberEvent far = rough.model->begin(rough.id, wr, 0.4f, 0.6f, 0.5f),
                   near = rough.model->begin_drawn_near(rough.id, wr, 0.4f, 0.6f, 0.5f);
  ASSERT_TRUE(rough.model->evaluates(near));
  const FiberDirection wi{0.1f, 2};
  const FiberValue a = rough.model->evaluate(far, wi), b = rough.model->evaluate(near, wi);
  EXPECT_EQ(a.total(), b.total());
  EXPECT_FALSE(b.exit.is_known);
  EXPECT_FLOAT_EQ(b.pdf, a.pdf + fiber::FiberModel::drawn_near_density * std::cos(wi.theta));
  EXPECT_EQ(b.pdf, rough.model->pdf(near, wi));
}

// Light that is reflected at one side of the fiber goes to that side; of a row the sides are those of the row.
TEST(DrawnNearEvents, DrawFromWhereTheRayMetTheFiber) {
  const Model rough(fiber::rough_info);
  const auto to_one_side = [&](float h) {
    int count = 0;
    for (int i = 0; i < 400; ++i) {
      const float xi1 = (static_cast<float>(i) + 0.5f) / 400, u = static_cast<float>(i % 20) / 20;
      const FiberEvent event = rough.model->begin_drawn_near(rough.id, wr, xi1, 0.5f, h);
      const fiber::FiberSample drawn = rough.model->sample(event, {0.02f, u, xi1, 0.5f});
      EXPECT_TRUE(drawn.value.exit.is_known || drawn.value.total() == glm::vec3(0.0f)) << "it did not leave";
      EXPECT_EQ(drawn.value.pdf, rough.model->pdf(event, drawn.wi));
      if (drawn.lobe == fiber::Lobe::r && std::sin(drawn.wi.phi - wr.phi) > 0) ++count;
    }
    return count;
  };
  const int one = to_one_side(0.8f), other = to_one_side(-0.8f);
  EXPECT_GT(std::max(one, other), 5 * std::min(one, other));
}

// Both draw the same light over the whole width: 16,384 paths, a weight of which is at most 1, so that their means
// differ by 4 standard errors (0.012, 1 in 16,000) and by what the row's energy is off (0.01).
TEST(DrawnNearEvents, HaveTheEnergyOfTheRowOverTheWidth) {
  const Model rough(fiber::rough_info);
  constexpr int paths = 1 << 14;
  RandomStream random(7, 1, 2);
  double far = 0, near = 0;
  for (int i = 0; i < paths; ++i) {
    const float xi1 = random.next(), xi2 = random.next(), h = 2 * (static_cast<float>(i) + 0.5f) / paths - 1;
    const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
    const auto weight = [&](const FiberEvent& event) {
      const FiberValue value = rough.model->sample(event, u).value;
      return double{value.total().x} / double{value.pdf} / paths;
    };
    far += weight(rough.model->begin(rough.id, wr, xi1, xi2, h));
    near += weight(rough.model->begin_drawn_near(rough.id, wr, xi1, xi2, h));
  }
  EXPECT_NEAR(far, near, 0.022);
}

TEST(DrawnNearEvents, AreTracedWhereNoRowAnswers) {
  const Model rough(fiber::rough_info, false);
  const FiberEvent event = rough.model->begin_drawn_near(rough.id, wr, 0.4f, 0.6f, 0.5f);
  EXPECT_FALSE(rough.model->evaluates(event));
  EXPECT_TRUE(rough.model->evaluate(event, {0.2f, -2}).exit.is_known);
}

TEST(NearEvents, AreBlackForAnIdThatWasNotGiven) {
  const Model rough(fiber::rough_info);
  const FiberEvent event = rough.model->begin_near(rough.id + 1, wr, 0.4f, 0.6f, 0.5f);
  EXPECT_EQ(rough.model->sample(event, {0.1f, 0.2f, 0.3f, 0.4f}).value.total(), glm::vec3(0.0f));
}

}  // namespace
}  // namespace tress
