// Which of two rows a merge keeps, by example. tests/properties has what holds for all tables.
#include <gtest/gtest.h>

#include "adaptive/cache_images.h"

namespace tress::inline v0_2::adaptive {
namespace {

std::string merged(const TableSnapshot& a, const TableSnapshot& b) { return encode_cache(merge_caches(a, b)); }

TableSnapshot one_row(const CachedRow& row) {
  return {"elliptical-test", {{{{1, {1.55f, 0.85f, 0.2f}}, {0.0f, 0.5f}, {0.0f, 0.3f}, 0.2f}, {row}}}};
}

/// The row that a merge of two tables of one row keeps; the same whichever is first.
CachedRow winner(const CachedRow& a, const CachedRow& b) {
  EXPECT_EQ(merged(one_row(a), one_row(b)), merged(one_row(b), one_row(a)));
  return merge_caches(one_row(a), one_row(b)).slices.at(0).rows.at(0);
}

TEST(CacheMerge, PrefersTheLaterGenerationThenTheConvergedThenTheBetter) {
  CachedRow good = converged_row(0, 0.001f), worse = converged_row(0, 0.009f);
  EXPECT_EQ(winner(good, worse).objective, 0.001f);

  CachedRow counted = good;
  counted.count += 1;
  EXPECT_EQ(winner(good, counted).count, counted.count);

  CachedRow reopened = open_row(0, {sketch_bin(2, 1, 0.5f)});
  reopened.generation = good.generation;
  EXPECT_EQ(winner(good, reopened).state, RowState::converged);
  reopened.generation = good.generation + 1;
  EXPECT_EQ(winner(good, reopened).state, RowState::open);

  CachedRow other = good;
  other.density()->fit.components[0].weight = 0.625f;
  EXPECT_EQ(winner(good, other).density()->fit.components[0].weight, 0.625f);
}

TEST(CacheMerge, OpenRowsShareWhatTheySaw) {
  CachedRow a = open_row(0, {sketch_bin(2, 9, 0.5f), sketch_bin(5, 1, 0.25f)});
  CachedRow b = open_row(0, {sketch_bin(2, 4, 0.75f), sketch_bin(7, 3, 1.0f)});
  b.count = 31;
  const CachedRow both = winner(a, b);
  EXPECT_EQ(both.state, RowState::open);
  EXPECT_EQ(both.count, 31u);
  EXPECT_EQ(both.density()->sketch,
            (std::vector<SketchBin>{sketch_bin(2, 4, 0.75f), sketch_bin(5, 1, 0.25f), sketch_bin(7, 3, 1.0f)}));
}

TEST(CacheMerge, KeepsTheSlicesAndRowsOfBoth) {
  TableSnapshot a = small_image(), b = small_image();
  a.slices.erase(a.slices.begin());
  b.slices.pop_back();
  EXPECT_EQ(merged(a, b), encode_cache(small_image()));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
