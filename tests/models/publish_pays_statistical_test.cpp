// When to publish: a host that asks publish_pays() as include/README.md says has its queries answered by rows.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "references/registry.h"
#include "tress/adaptive/query.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress {
namespace {

struct Loop {
  double first = 0, later = 0;  ///< the shares of queries that rows answered: of the first sample, of all others
  int publishes = 0;
};

/// A renderer of waves of 1, 1, 2 and 4 samples of a picture; each sample is `events` hits of hair from all sides,
/// with one light each.
Loop run(const char* name, std::uint64_t events, bool cuts_first) {
  const fiber::ModelInfo& info = *references::find_model(name);
  fiber::ModelService learned = fiber::make_service(info, {});
  const auto model = info.make({.estimator = fiber::Estimator::fitted, .service = learned.service.get()});
  const fiber::FiberId id = model->add_fiber({});
  learned.service->prepare();
  Loop loop;
  std::uint64_t asked[2] = {0, 0}, exact[2] = {0, 0};
  const auto render = [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i) {
      RandomStream random(5, i);
      const fiber::FiberDirection wr{std::asin(2 * random.next() - 1), 6.28f * (random.next() - 0.5f)};
      const fiber::FiberEvent event = model->begin(id, wr, random.next(), random.next(), 0);
      const fiber::FiberSample drawn =
          model->sample(event, {random.next(), random.next(), random.next(), random.next()});
      const fiber::FiberValue lit = model->evaluate(event, {2 * random.next() - 1, 6 * random.next() - 3});
      const int sample = i < events ? 0 : 1;
      asked[sample] += drawn.value.queries + lit.queries;
      exact[sample] += drawn.value.exact_queries + lit.exact_queries;
    }
    if (!learned.service->publish_pays()) return;
    learned.service->publish(end - begin);
    ++loop.publishes;
  };
  for (std::uint64_t part = 0; part < 8; ++part) {
    if (cuts_first) render(part * events / 8, (part + 1) * events / 8);
  }
  if (!cuts_first) render(0, events);
  for (std::uint64_t sample = 1; sample < 8; sample = sample == 1 ? 2 : 2 * sample)
    render(sample * events, sample == 1 ? 2 * events : 2 * sample * events);
  const auto share = [&](int sample) {
    return 1 - static_cast<double>(exact[sample]) / static_cast<double>(asked[sample]);
  };
  loop.first = share(0);
  loop.later = share(1);
  return loop;
}

TEST(PublishPays, AHostThatAsksIsAnsweredByRowsFromItsSecondSampleOn) {
  for (const char* name : {"elliptical", "rough"}) {
    const Loop loop = run(name, 80000, true);
    EXPECT_GT(loop.later, 0.99) << name;
    EXPECT_LE(loop.publishes, 11) << name;
  }
  EXPECT_LT(run("elliptical", 20000, false).later, 0.9) << "without cutting the first sample";
}

TEST(PublishPays, NotBeforeAQueryNorOnceAllHasConvergedNorWhileNothingIsLearned) {
  struct Flat final : adaptive::Target {
    void trace(const adaptive::SliceDescription&, float a, float,
               std::vector<adaptive::TracedRay>& out) const override {
      for (int i = 0; i < 16; ++i) out.push_back({a + 0.1f * static_cast<float>(i), 0.05f, 0});
    }
    std::string model_name() const override { return "flat"; }
  } const target;
  adaptive::Service service({}, target);
  const adaptive::SliceId slice = *service.add_slice({.key = {}, .axis_a = {0, 1}, .axis_b = {0}, .blur_rad = 0.3f});
  EXPECT_FALSE(service.publish_pays());
  RandomStream random(3);
  const auto ask = [&](std::uint32_t node, int times) {
    for (int i = 0; i < times; ++i) sample(service, {slice, node, 0}, {random.next(), 0, 0});
  };
  ask(0, 7);
  EXPECT_FALSE(service.publish_pays()) << "a row is created at the eighth query";
  ask(0, 1);
  EXPECT_TRUE(service.publish_pays());
  ask(1, 2000);
  service.set_learning(false);
  EXPECT_FALSE(service.publish_pays());
  service.set_learning(true);
  for (int pass = 0; pass < 8; ++pass) {
    service.publish();
    ask(0, 100);
    ask(1, 100);
  }
  EXPECT_FALSE(service.publish_pays()) << "both have converged";
  EXPECT_FALSE(service.publish_pays(0)) << "and nothing waits";
}

}  // namespace
}  // namespace tress
