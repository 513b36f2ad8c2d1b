// A method that goes wrong behind the learner interface: what the table then publishes, counts and logs.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "fit/row_learner.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

Mixture peak_at(float mu, float energy) {
  Mixture fit;
  fit.component_count = 1;
  fit.components[0] = {{mu, 0.1f, 0.1f}, energy};
  return fit;
}

/// Legal throughout, and wrong: a peak that wanders about.
class WrongLearner final : public RowLearner {
 public:
  void begin(FitContext& context) override { learn(context); }
  void learn(FitContext& context) override { context.publish(peak_at(context.random.next(), context.nodes.energy())); }
  std::size_t bytes() const override { return sizeof(*this); }
};

/// A uniform fit at first; then never a legal one again.
class BrokenLearner final : public RowLearner {
 public:
  void begin(FitContext& context) override {
    Mixture flat;
    flat.uniform_weight = context.nodes.energy();
    context.publish(flat);
  }
  void learn(FitContext& context) override {
    Mixture bad = peak_at(0, context.nodes.energy());
    bad.components[0].shape.s_left = std::numeric_limits<float>::quiet_NaN();
    context.publish(bad);
  }
  std::size_t bytes() const override { return sizeof(*this); }
};

constinit const Learner wrong_learner{"wrong", "", make_row_learner<WrongLearner>};
constinit const Learner broken_learner{"broken", "", make_row_learner<BrokenLearner>};

class Injected : public ::testing::Test {
 protected:
  /// 40 passes of the toy slice by a learner; every published fit is looked at after each.
  static PassReport learn(Service& service, std::uint64_t* bad_fits) {
    PassReport report;
    for (std::uint64_t pass = 0; pass < 40; ++pass) {
      testing::run_pass(service, 1, pass, 500, 1);
      report = service.publish();
      *bad_fits += report.bad_fits;
      for (std::uint32_t node = 0; node < 16; ++node) {
        const RowView view = service.peek(0, node / 4, node % 4);
        EXPECT_NE(view.state, RowState::converged);
        if (view.fit == nullptr) continue;
        for (const float x : {-3.0f, -1.0f, 0.0f, 2.0f}) {
          EXPECT_TRUE(view.density(x) >= 0 && std::isfinite(view.density(x)));
          EXPECT_GT(view.proposal_density(x, 0.05f), 0.0f);
        }
        EXPECT_NEAR(view.fit->energy(), view.nodes->energy(), 1e-5);
      }
    }
    return report;
  }

  /// What is asked of the row after it was refused is g of its node, to the bit.
  static void expect_answered_by_g(const Service& service) {
    const testing::MovingPeaks target;
    const SliceDescription slice = testing::toy_slice(1, 4);
    std::vector<TracedRay> rays;
    target.trace(slice, slice.axis_a[1], slice.axis_b[2], rays);
    const TracedNodes nodes(rays, slice.blur_rad);
    const RowView view = service.look_up(0, 1, 2);
    EXPECT_EQ(view.state, RowState::refused);
    ASSERT_NE(view.nodes, nullptr);
    for (const float x : {-3.0f, -1.0f, 0.0f, 2.0f}) EXPECT_EQ(view.nodes->density(x), nodes.density(x));
  }
};

TEST_F(Injected, AWrongFitIsRefusedAndReportedAndNeverTheAnswer) {
  const testing::MovingPeaks target;
  Options options;
  options.learner = &wrong_learner;
  Service service(options, target);
  service.add_slice(testing::toy_slice(1, 4));
  std::uint64_t bad_fits = 0;
  const PassReport report = learn(service, &bad_fits);
  EXPECT_EQ(bad_fits, 0u);
  EXPECT_EQ(report.rows_refused, 16u);
  EXPECT_GT(report.objective_p50, 0.01);
  expect_answered_by_g(service);
}

TEST_F(Injected, AFitOutsideTheConstraintsIsReplacedCountedAndNeverTheAnswer) {
  const testing::MovingPeaks target;
  Options options;
  options.learner = &broken_learner;
  Service service(options, target);
  service.add_slice(testing::toy_slice(1, 4));
  std::uint64_t bad_fits = 0;
  const PassReport report = learn(service, &bad_fits);
  EXPECT_GE(bad_fits, 16u * 31);  // a row makes one after each test that it fails but the last
  EXPECT_EQ(report.rows_refused, 16u);
  expect_answered_by_g(service);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
