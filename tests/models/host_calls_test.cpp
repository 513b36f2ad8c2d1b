// What a host may get wrong: numbers out of range, ids that were not given, services on another target. Every call
// returns, and what it returns is finite or a reason.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "references/registry.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/rough_model.h"

namespace tress {
namespace {

using fiber::Estimator;
using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberId;
using fiber::FiberModel;
using fiber::FiberParameters;

constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();

bool is_sound(const fiber::FiberValue& value) {
  bool sound = std::isfinite(value.pdf) && value.pdf >= 0 && std::isfinite(value.objective);
  for (const glm::vec3& s : value.s) sound = sound && std::isfinite(s.x) && std::isfinite(s.y) && std::isfinite(s.z);
  return sound;
}

bool is_sound(const FiberDirection& w) { return std::abs(w.theta) < 1.6f && std::abs(w.phi) < 3.2f; }

/// Every argument in turn is out of its range while all others are within; and all at once.
void expect_sound(const FiberModel& model, FiberId id, const std::string& what) {
  for (const float wrong : {nan, infinity, -infinity, 1e30f, -2.0f, 1.0f}) {
    for (int place = 0; place < 13; ++place) {
      const auto at = [&](int i, float right) { return place == i || place == 12 ? wrong : right; };
      SCOPED_TRACE(testing::Message() << what << ": " << wrong << " at " << place);
      const FiberEvent event =
          model.begin(id, {at(0, 0.3f), at(1, 0.8f)}, at(2, 0.4f), at(3, 0.6f), at(4, 0.1f), at(5, 1.0f));
      const fiber::FiberSample sample = model.sample(event, {at(6, 0.2f), at(7, 0.7f), at(8, 0.4f), at(9, 0.5f)});
      EXPECT_TRUE(is_sound(sample.value));
      EXPECT_TRUE(is_sound(sample.wi));
      EXPECT_TRUE(is_sound(model.evaluate(event, {at(10, -0.2f), at(11, -2.2f)})));
      const glm::vec3 excess = model.excess(event, {at(10, -0.2f), at(11, -2.2f)}, 0.5f);
      EXPECT_TRUE(std::isfinite(excess.x));
    }
  }
}

// Before this test NaN made `rough` run for ever, and `elliptical` give a density of NaN.
TEST(HostCalls, AnswerNumbersThatAreNone) {
  for (const fiber::ModelInfo* info : {references::find_model("rough"), references::find_model("elliptical"),
                                       references::find_model("chiang2016"), references::find_model("fiber3d")}) {
    const auto exact = info->make({.estimator = Estimator::exact});
    expect_sound(*exact, exact->add_fiber({}), std::string(info->name) + ", traced");
    if (!info->has_rows()) continue;
    const fiber::ModelService learned = fiber::make_service(*info, {});
    const auto model = info->make({.estimator = Estimator::fitted, .service = learned.service.get()});
    const FiberId id = model->add_fiber({});
    expect_sound(*model, id, std::string(info->name) + ", cold");
    learned.service->publish(1);
    expect_sound(*model, id, std::string(info->name) + ", after a pass");
  }
}

TEST(HostCalls, KnowTheirFibers) {
  for (const char* name : {"rough", "elliptical", "chiang2016", "fiber3d"}) {
    const auto model = references::find_model(name)->make({.estimator = Estimator::exact});
    expect_sound(*model, 0, std::string(name) + " without fibers");
    const FiberId id = model->add_fiber({});
    EXPECT_NE(id, fiber::no_fiber);
    for (const FiberId unknown : {id + 1, FiberId{12345}, fiber::no_fiber}) {
      const FiberEvent event = model->begin(unknown, {0.3f, 0.8f}, 0.5f, 0.5f, 0);
      EXPECT_EQ(model->sample(event, {0.5f, 0.5f, 0.5f, 0.5f}).value.pdf, 0);
      EXPECT_EQ(model->evaluate(event, {-0.3f, 2}).pdf, 0);
      EXPECT_EQ(model->excess(event, {-0.3f, 2}, 0.5f), glm::vec3(0.0f));
      EXPECT_GE(model->balance(unknown), 0);
    }
    FiberParameters wide, none;
    wide.eccentricity = 3;
    none.sigma_a.y = nan;
    EXPECT_EQ(model->add_fiber(wide), fiber::no_fiber) << name;
    EXPECT_EQ(model->add_fiber(none), fiber::no_fiber) << name;
    EXPECT_EQ(model->add_fiber({}), id);
  }
}

struct Another final : adaptive::Target {
  void trace(const adaptive::SliceDescription&, float, float, std::vector<adaptive::TracedRay>&) const override {}
  std::string model_name() const override { return "another-1"; }
};

TEST(HostCalls, ModelsAreTiedToTheirService) {
  const Another another;
  const auto densities = fiber::make_elliptical_target();
  const auto samples = fiber::make_rough_target();
  adaptive::Service wrong({}, another), only_densities({}, *densities), only_samples({}, *samples),
      both({}, *densities, *samples);
  const auto reason = [](const auto& made) { return made ? std::string("none") : made.error().message(); };
  EXPECT_EQ(reason(fiber::make_elliptical_model(Estimator::fitted, &wrong)),
            "service: expected a service on a target of densities, elliptical-1, found another-1");
  EXPECT_FALSE(fiber::make_elliptical_model(Estimator::fitted, nullptr));
  EXPECT_FALSE(fiber::make_elliptical_model(Estimator::corrected, nullptr));
  EXPECT_FALSE(fiber::make_elliptical_model(Estimator::fitted, &only_samples));
  EXPECT_FALSE(fiber::make_rough_model(Estimator::fitted, &only_densities));
  EXPECT_FALSE(fiber::make_rough_model(Estimator::fitted, nullptr));
  EXPECT_FALSE(fiber::make_rough_model(Estimator::fitted, &wrong));
  EXPECT_FALSE(fiber::make_rough_model(Estimator::corrected, &both));
  EXPECT_TRUE(fiber::make_rough_model(Estimator::fitted, &only_samples));
  EXPECT_TRUE(fiber::make_rough_model(Estimator::fitted, &both));
  EXPECT_TRUE(fiber::make_elliptical_model(Estimator::corrected, &both));
  EXPECT_TRUE(fiber::make_rough_model(Estimator::exact, nullptr));
  EXPECT_TRUE(fiber::make_elliptical_model(Estimator::exact, nullptr));
}

// It ended the host: the slice of the fiber was asked for an id that an error has not.
TEST(HostCalls, AFiberThatIsAddedDuringAPassIsRefused) {
  adaptive::Options options;
  options.check_passes = true;
  for (const char* name : {"rough", "elliptical"}) {
    const fiber::ModelInfo& info = *references::find_model(name);
    const fiber::ModelService learned = fiber::make_service(info, options);
    const auto model = info.make({.estimator = Estimator::fitted, .service = learned.service.get()});
    const FiberId id = model->add_fiber({});
    const FiberEvent event = model->begin(id, {0.3f, 0.8f}, 0.5f, 0.5f, 0);
    model->sample(event, {0.2f, 0.7f, 0.4f, 0.5f});
    FiberParameters narrow;
    narrow.eccentricity = 0.7f;
    EXPECT_EQ(model->add_fiber(narrow), fiber::no_fiber);
    const adaptive::PassReport report = learned.service->publish(1);
    ASSERT_TRUE(report.misuse.has_value()) << name;
    EXPECT_EQ(report.misuse->place, "add_slice");
    EXPECT_EQ(model->add_fiber(narrow), id + 1);
  }
}

}  // namespace
}  // namespace tress
