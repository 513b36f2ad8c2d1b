// Events that begin near: what the fiber does with light from where the ray met it, without a row.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "models/learned_model.h"

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
  const FiberEvent far = elliptical.model->begin(elliptical.id, wr, 0.4f, 0.6f, 0.5f),
                   near = elliptical.model->begin_near(elliptical.id, wr, 0.4f, 0.6f, 0.5f);
  const FiberDirection wi{0.1f, 2};
  const FiberValue a = elliptical.model->evaluate(far, wi), b = elliptical.model->evaluate(near, wi);
  EXPECT_EQ(a.total(), b.total());
  EXPECT_EQ(a.pdf, b.pdf);
}

TEST(NearEvents, AreBlackForAnIdThatWasNotGiven) {
  const Model rough(fiber::rough_info);
  const FiberEvent event = rough.model->begin_near(rough.id + 1, wr, 0.4f, 0.6f, 0.5f);
  EXPECT_EQ(rough.model->sample(event, {0.1f, 0.2f, 0.3f, 0.4f}).value.total(), glm::vec3(0.0f));
}

}  // namespace
}  // namespace tress
