// How a row answers, from its creation to each of its ends.
#include "table/rows.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <utility>

#include "adaptive/toy_target.h"
#include "tress/adaptive/learner.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr float blur = 0.2f;

std::unique_ptr<const TracedNodes> one_ray() {
  return std::make_unique<const TracedNodes>(std::array<TracedRay, 1>{{{0, 0.5f, 1}}}, blur);
}

/// A row of a density that learns.
Row& learning_row(Rows& rows, SliceId slice, std::uint32_t node) {
  Row& row = rows.add({slice, node});
  row.learning = std::make_unique<Learning>(one_ray(), sketch_learner);
  rows.show_learning(row, false);
  return row;
}

struct OneSlice : ::testing::Test {
  Rows rows;
  SliceId slice = rows.add_slice(testing::toy_slice(0, 4), true, 0);
  const Slot& slot(std::uint32_t node) const { return rows.slice(slice).slots[node]; }
};

TEST_F(OneSlice, IsFoundByItsKey) {
  ASSERT_NE(rows.find(testing::toy_slice(0, 4).key), nullptr);
  EXPECT_EQ(*rows.find(testing::toy_slice(0, 4).key), slice);
  EXPECT_EQ(rows.find(testing::toy_slice(7, 4).key), nullptr);
}

TEST_F(OneSlice, ShowsARowThatLearnsUntilItHasConverged) {
  Row& row = learning_row(rows, slice, 3);
  EXPECT_EQ(slot(3).row, 0u);
  EXPECT_EQ(rows.state_of(row), RowState::open);
  EXPECT_LT(rows.objective_of(row), 0) << "not tested yet";
  EXPECT_EQ(view_of(slot(3)).fit, nullptr);
  EXPECT_EQ(view_of(slot(3)).nodes, row.learning->nodes.get());
  EXPECT_EQ(rows.cached_form(row).state, RowState::open);

  row.learning->fit.uniform_weight = 0.5f;
  row.learning->has_fit = true;
  row.learning->objective = 0.25f;
  rows.show_learning(row, false, false);
  EXPECT_EQ(view_of(slot(3)).fit, nullptr) << "it is not published";
  rows.show_learning(row, false);
  ASSERT_NE(view_of(slot(3)).fit, nullptr);
  EXPECT_EQ(view_of(slot(3)).fit->uniform_weight, 0.5f);

  row.learning->count = 77;
  const std::size_t learns = rows.bytes_of(row);
  rows.show_learning(row, true);
  EXPECT_EQ(row.learning, nullptr);
  EXPECT_EQ(row.taught(), 77u);
  EXPECT_LT(rows.bytes_of(row), learns);
  EXPECT_EQ(rows.state_of(row), RowState::converged);
  EXPECT_EQ(rows.objective_of(row), 0.25f);
  const CachedRow cached = rows.cached_form(row);
  EXPECT_EQ(cached.state, RowState::converged);
  EXPECT_EQ(cached.node, 3u);
  EXPECT_EQ(cached.density()->fit.uniform_weight, 0.5f);
}

TEST_F(OneSlice, KeepsAnEarlierFitInTheCacheWhileTheRowIsOpen) {
  Row& row = learning_row(rows, slice, 1);
  CachedRow earlier;
  earlier.state = RowState::converged;
  earlier.generation = 5;
  row.learning->earlier = std::make_unique<const CachedRow>(earlier);
  EXPECT_EQ(rows.cached_form(row).generation, 5u);
}

TEST_F(OneSlice, ShowsCachedRowsOfBothKinds) {
  CachedRow mixture;
  mixture.state = RowState::converged;
  mixture.objective = 0.125f;
  Row& density = rows.add({slice, 0});
  rows.show_cached(density, mixture, false);
  EXPECT_EQ(rows.state_of(density), RowState::converged);
  EXPECT_EQ(rows.objective_of(density), 0.125f);

  CachedRow ribbons = mixture;
  ribbons.learned =
      CachedSamples{std::make_shared<const RibbonRow>(std::array<RibbonRow::Part, 1>{{{Ribbon(), 0.5f}}})};
  ribbons.count = 2048;
  Row& samples = rows.add({slice, 2});
  rows.show_cached(samples, ribbons, false);
  EXPECT_EQ(rows.state_of(samples), RowState::open);
  rows.show_cached(samples, ribbons, true);
  EXPECT_EQ(rows.state_of(samples), RowState::converged);
  EXPECT_EQ(view_of(slot(2)).paths, 2048u);
  EXPECT_EQ(*rows.cached_form(samples).ribbons(), *ribbons.ribbons());
}

TEST_F(OneSlice, RefusesARowOfSamplesAndCanClearIt) {
  Row& row = rows.add({slice, 0});
  rows.show_ribbons(row, std::make_unique<const RibbonAnswer>(RibbonAnswer{RibbonRow(), 0.5f, 512, false}));
  EXPECT_EQ(rows.state_of(row), RowState::open);
  EXPECT_EQ(rows.bytes_of(row), sizeof(Row) + sizeof(RibbonAnswer));
  rows.refuse(row);
  EXPECT_EQ(rows.state_of(row), RowState::refused);
  EXPECT_LT(rows.objective_of(row), 0);
  EXPECT_EQ(rows.cached_form(row).state, RowState::open) << "a cache keeps it as open";
  rows.clear(row);
  EXPECT_EQ(view_of(slot(0)).ribbons, nullptr);
  EXPECT_EQ(rows.bytes_of(row), sizeof(Row));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
