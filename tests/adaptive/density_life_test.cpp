// How one row of densities is opened, tested and audited: without a service.
#include "table/density_life.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "adaptive/toy_target.h"
#include "tress/adaptive/learner.h"

namespace tress::inline v0_2::adaptive {
namespace {

struct DensityLifeTest : ::testing::Test {
  Options options;
  Rows rows;
  LightPolicy light{options};
  std::vector<Error> errors;
  testing::MovingPeaks peaks;
  GuardedTarget target = guarded(peaks);
  DensityLife life{options, rows, light, &target};
  SliceId slice = rows.add_slice(testing::toy_slice(0, 2), true, 0);

  GuardedTarget guarded(const Target& any) {
    return {any, [this](Error error) { errors.push_back(std::move(error)); }};
  }
  /// A row whose Learning has its nodes.
  Row& added(std::uint32_t node) {
    Row& row = rows.add({slice, node});
    const Slice& of = rows.slice(slice);
    row.learning =
        std::make_unique<Learning>(target.trace(of.description, of.a_of(node), of.b_of(node)), *options.learner);
    return row;
  }
  /// Opens the row and ends passes of 100 queries until it has converged. Returns the number of passes.
  std::uint32_t converge(Row& row) {
    RowOutcome outcome = life.open(row, nullptr, 0);
    rows.show_learning(row, outcome.converged);
    std::uint32_t pass = 0;
    while (!outcome.converged && pass < 100) {
      rows.slot_of(row).queries += 100;
      outcome = life.update(row, ++pass);
    }
    rows.show_learning(row, outcome.converged);
    return pass;
  }
};

TEST_F(DensityLifeTest, ARowConvergesByDrawsOfItsOwn) {
  Row& row = added(1);
  EXPECT_LT(converge(row), 100u);
  EXPECT_EQ(rows.state_of(row), RowState::converged);
  EXPECT_LE(rows.objective_of(row), options.epsilon);
  EXPECT_TRUE(errors.empty());
}

TEST_F(DensityLifeTest, ARowThatNobodyAsksForDrawsNothing) {
  Row& row = added(1);
  const RowOutcome opened = life.open(row, nullptr, 0);
  rows.show_learning(row, opened.converged);
  EXPECT_EQ(life.update(row, 1).validation_draws, 0u);
  rows.slot_of(row).queries += 8;
  EXPECT_GT(life.update(row, 2).validation_draws, 0u);
}

TEST_F(DensityLifeTest, AnAuditFindsAnotherTarget) {
  Row& row = added(2);
  converge(row);
  ASSERT_EQ(rows.state_of(row), RowState::converged);
  row.audit = Audit::due;
  EXPECT_FALSE(life.audit(row, 7).audit_failed);
  EXPECT_EQ(row.audit, Audit::none);
  const testing::MovingPeaks peaks_turned(0.5f);
  const GuardedTarget turned = guarded(peaks_turned);
  const RowOutcome failed = DensityLife(options, rows, light, &turned).audit(row, 7);
  EXPECT_TRUE(failed.audit_failed);
  EXPECT_TRUE(failed.nodes) << "to learn it anew from";
}

TEST_F(DensityLifeTest, ASketchThatContradictsItsTargetIsDropped) {
  Row& first = added(0);
  (void)life.open(first, nullptr, 0);
  rows.show_learning(first, false);
  const CachedRow cached = rows.cached_form(first);
  ASSERT_EQ(cached.state, RowState::open);
  Rows other;
  const SliceId same = other.add_slice(testing::toy_slice(0, 2), true, 0);
  for (const float turn : {0.0f, 0.5f}) {
    const testing::MovingPeaks peaks_turned(turn);
    const GuardedTarget turned = guarded(peaks_turned);
    Row row{same, 0};
    const Slice& of = other.slice(same);
    row.learning = std::make_unique<Learning>(turned.trace(of.description, of.a_of(0), of.b_of(0)), *options.learner);
    const RowOutcome opened = DensityLife(options, other, light, &turned).open(row, &cached, 1);
    EXPECT_EQ(opened.reopened, turn != 0) << turn;
    EXPECT_EQ(row.generation, turn != 0 ? 1u : 0u);
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
