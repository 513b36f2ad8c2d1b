// Every learner on the toy targets, through the service: it learns them, stays within the constraints, does not depend
// on threads, and writes the same kind of file.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>
#include <string>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "references/registry.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::uint32_t size = 4;  // nodes of an axis

/// Converged rows that a learner owes us on the toy slice after 40 passes, of its 16: em and appendix are slow
/// (two thirds of all rows of bench_rows for em, so that rounding decides between 11 and 12 of these: half is owed),
/// and appendix-literal is here as a warning.
std::uint64_t rows_owed(const Learner* learner) {
  if (learner == &references::em_learner || learner == &references::appendix_learner) return size * size / 2;
  return learner == &references::appendix_literal_learner ? 0 : size * size;
}

double relative_l2(const CachedRow& row, const TracedNodes& nodes) {
  constexpr int points = 2048;  // a fortieth of the narrowest scale of these fits: under 1e-4 of the integral
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const auto x = static_cast<float>(-pi + 2 * pi * (i + 0.5) / points);
    const float f = row.density()->fit.density(x);
    const double r = static_cast<double>(f) - nodes.density(x);
    sum += r * r;
  }
  return sum * 2 * pi / points / nodes.variation();
}

struct Learned {
  TableSnapshot image;
  PassReport last;
  std::uint64_t g_evaluations = 0;
};

Learned learn(const Learner* learner, unsigned threads, int passes) {
  const tbb::global_control width(tbb::global_control::max_allowed_parallelism, threads);
  const testing::MovingPeaks target;
  Options options;
  options.learner = learner;
  options.tests_before_refusal = 64;  // more than there are passes
  Service service(options, target);
  service.add_slice(testing::toy_slice(1, size));
  Learned learned;
  for (int pass = 0; pass < passes; ++pass) {
    testing::run_pass(service, 1, static_cast<std::uint64_t>(pass), 1000, threads);
    learned.last = service.publish();
    learned.g_evaluations += learned.last.g_evaluations;
  }
  learned.image = service.snapshot();
  return learned;
}

class EveryLearner : public ::testing::TestWithParam<const Learner*> {};

TEST_P(EveryLearner, HasANameThatFindsIt) { EXPECT_EQ(references::find_learner(GetParam()->name), GetParam()); }

TEST_P(EveryLearner, LearnsTheToyTargets) {
  const Learned learned = learn(GetParam(), 2, 40);
  EXPECT_GE(learned.last.rows_converged, rows_owed(GetParam()));
  EXPECT_EQ(learned.last.rows_open + learned.last.rows_converged + learned.last.rows_refused, size * size);
  const testing::MovingPeaks target;
  for (const CachedSlice& slice : learned.image.slices) {
    for (const CachedRow& row : slice.rows) {
      if (row.state != RowState::converged) continue;
      std::vector<TracedRay> rays;
      const SliceDescription& d = slice.description;
      target.trace(d, d.axis_a[row.node / size], d.axis_b[row.node % size], rays);
      const TracedNodes nodes(rays, d.blur_rad);
      // The test lets about one row in a thousand pass whose error is above epsilon; twice that was never seen.
      EXPECT_LE(relative_l2(row, nodes), 2 * Options{}.epsilon) << "node " << row.node;
      EXPECT_NEAR(row.density()->fit.energy(), nodes.energy(), 1e-5 * nodes.energy());
      EXPECT_GE(row.density()->fit.uniform_weight, 0);
      for (const Component& part : row.density()->fit.parts()) {
        EXPECT_GE(part.weight, 0);
        EXPECT_GT(part.attribute_mean, 0);
        for (const float scale : {part.shape.s_left, part.shape.s_right}) {
          EXPECT_GE(scale, 0.004f);
          EXPECT_LE(scale, 0.5f);
        }
      }
    }
  }
}

TEST_P(EveryLearner, GivesTheSameBitsForAnyNumberOfThreads) {
  const Learned one = learn(GetParam(), 1, 4);
  for (const unsigned threads : {2u, 8u}) {
    const Learned many = learn(GetParam(), threads, 4);
    EXPECT_EQ(encode_cache(one.image), encode_cache(many.image));
    EXPECT_EQ(one.g_evaluations, many.g_evaluations);
    EXPECT_EQ(one.last.bytes, many.last.bytes);
  }
}

TEST_P(EveryLearner, StaysBelowTheCeiling) {
  const testing::MovingPeaks target;
  Options options;
  options.learner = GetParam();
  options.memory_bytes = 60000;  // a handful of open rows
  Service service(options, target);
  service.add_slice(testing::toy_slice(1, size));
  for (std::uint64_t pass = 0; pass < 6; ++pass) {
    testing::run_pass(service, 1, pass, 1000, 2);
    EXPECT_LE(service.publish().bytes, options.memory_bytes);
  }
}

TEST_P(EveryLearner, TakesOverTheOpenRowsOfAnother) {
  const testing::MovingPeaks target;
  Options options;
  Service first(options, target);
  first.add_slice(testing::toy_slice(1, size));
  for (std::uint64_t pass = 0; pass < 2; ++pass) {
    testing::run_pass(first, 1, pass, 1000, 1);
    first.publish();
  }
  const Result<TableSnapshot> saved = decode_cache(encode_cache(first.snapshot()), target.model_name(), "cache");
  ASSERT_TRUE(saved);
  options.learner = GetParam();
  options.epsilon = 0.005;  // some of the converged ones are open again
  Service second(options, target);
  second.add_slice(testing::toy_slice(1, size));
  ASSERT_FALSE(second.load(*saved));
  PassReport report;
  for (std::uint64_t pass = 0; pass < 40; ++pass) {
    testing::run_pass(second, 1, pass, 1000, 1);
    report = second.publish();
  }
  EXPECT_EQ(report.rows_reopened, 0u);
  EXPECT_EQ(report.rows_open + report.rows_converged + report.rows_refused, size * size);
  EXPECT_TRUE(decode_cache(encode_cache(second.snapshot()), target.model_name(), "cache"));
}

INSTANTIATE_TEST_SUITE_P(Learners, EveryLearner,
                         ::testing::ValuesIn(references::learners().begin(), references::learners().end()),
                         [](const auto& info) {
                           std::string name = info.param->name;
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

// What only they promise.
TEST(Learners, EagerHasNoOpenRows) {
  const Learned learned = learn(&references::eager_learner, 1, 1);
  EXPECT_EQ(learned.last.rows_open, 0u);
  EXPECT_EQ(learned.last.rows_converged, learned.last.creations);
  EXPECT_EQ(learned.last.newly_converged, learned.last.creations);
  EXPECT_GT(learned.last.creations, 0u);
}

TEST(Learners, TheLiteralAppendixDoesNotConverge) {
  const Learned learned = learn(&references::appendix_literal_learner, 1, 40);
  EXPECT_EQ(learned.last.rows_converged, 0u) << "if it does now, the documents are wrong";
  EXPECT_GT(learned.last.objective_p50, 0.1);
}

TEST(Learners, FixedNumbersOfComponentsAreKept) {
  const testing::MovingPeaks target;
  for (const Learner* learner :
       {&references::em_learner, &references::appendix_learner, &references::appendix_literal_learner}) {
    Options options;
    options.learner = learner;
    options.max_components = 3;
    options.queries_before_creation = 1;
    Service service(options, target);
    const SliceId slice = *service.add_slice(testing::toy_slice(1, 1));
    service.look_up(slice, 0, 0);
    service.publish();
    ASSERT_NE(service.peek(slice, 0, 0).fit, nullptr);
    EXPECT_EQ(service.peek(slice, 0, 0).fit->component_count, 3u) << learner->name;
  }
}

TEST(Learners, ANameThatIsNoneFindsNone) { EXPECT_EQ(references::find_learner("skech"), nullptr); }

}  // namespace
}  // namespace tress::inline v0_2::adaptive
