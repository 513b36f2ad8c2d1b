// Caches as sessions really leave them, with common ancestors: any order of merging gives the same file, to the byte.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "properties/property.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr const char* model = "moving-peaks-1";
constexpr int nobody = -1;

struct Member {
  int parent = nobody;
  std::string bytes;  ///< of its file
};

TableSnapshot read(const std::string& bytes) {
  Result<TableSnapshot> image = decode_cache(bytes, model, "a cache");
  EXPECT_TRUE(image) << image.error().message();
  return std::move(*image);
}

std::string merged(const std::string& a, const std::string& b) { return encode_cache(merge_caches(read(a), read(b))); }

/// One session: loads its parent, asks queries of its own, saves.
Member session(const std::vector<Member>& family, int parent, std::uint64_t first_pass, int passes,
               std::uint32_t slices) {
  const testing::MovingPeaks target;
  Service service(Options{}, target);
  for (std::uint32_t lobe = 0; lobe < slices; ++lobe) service.add_slice(testing::toy_slice(lobe, 6));
  if (parent != nobody) {
    EXPECT_FALSE(service.load(read(family[static_cast<std::size_t>(parent)].bytes)));
  }
  for (int pass = 0; pass < passes; ++pass) {
    testing::run_pass(service, slices, first_pass + static_cast<std::uint64_t>(pass), 1500, 1);
    service.publish();
  }
  return {parent, encode_cache(service.snapshot())};
}

/// Two lines from nothing; children of one parent; grandchildren; a session with a slice more.
const std::vector<Member>& family() {
  static const std::vector<Member> members = [] {
    std::vector<Member> all;
    all.push_back(session(all, nobody, 0, 2, 2));
    all.push_back(session(all, nobody, 100, 3, 1));
    all.push_back(session(all, 0, 200, 1, 2));
    all.push_back(session(all, 0, 300, 3, 3));
    all.push_back(session(all, 2, 400, 2, 2));
    all.push_back(session(all, 3, 500, 6, 1));
    all.push_back(session(all, 1, 600, 1, 1));
    return all;
  }();
  return members;
}

/// Any of them, small cases too (inRange would begin with the first few).
rc::Gen<std::size_t> any_index() {
  std::vector<std::size_t> indices(family().size());
  std::iota(indices.begin(), indices.end(), std::size_t{0});
  return rc::gen::elementOf(indices);
}
const Member& any_member() { return family()[*any_index()]; }

TEST(CacheFamily, HasOpenAndConvergedRowsOnWhichItsMembersDiffer) {
  std::size_t open = 0, converged = 0;
  for (const Member& member : family()) {
    for (const CachedSlice& slice : read(member.bytes).slices) {
      for (const CachedRow& row : slice.rows) ++(row.state == RowState::converged ? converged : open);
    }
  }
  EXPECT_GT(open, 20u);
  EXPECT_GT(converged, 20u);
  for (std::size_t i = 1; i < family().size(); ++i) EXPECT_NE(family()[i].bytes, family()[i - 1].bytes);
}

RC_GTEST_PROP(CacheFamily, MergesCommute, ()) {
  const std::string &a = any_member().bytes, &b = any_member().bytes;
  RC_ASSERT(merged(a, b) == merged(b, a));
}

RC_GTEST_PROP(CacheFamily, MergesAssociate, ()) {
  const std::string &a = any_member().bytes, &b = any_member().bytes, &c = any_member().bytes;
  RC_ASSERT(merged(merged(a, b), c) == merged(a, merged(b, c)));
}

RC_GTEST_PROP(CacheFamily, MergingAgainChangesNothing, ()) {
  const std::string &a = any_member().bytes, &b = any_member().bytes;
  RC_ASSERT(merged(a, a) == a);
  RC_ASSERT(merged(merged(a, b), b) == merged(a, b));
}

RC_GTEST_PROP(CacheFamily, AnyListInAnyOrderGivesTheSameFile, ()) {
  std::vector<std::size_t> list = *rc::gen::resize(12, rc::gen::container<std::vector<std::size_t>>(any_index()));
  RC_PRE(!list.empty());
  const auto fold = [&] {
    std::string all = family()[list[0]].bytes;
    for (const std::size_t member : list) all = merged(all, family()[member].bytes);
    return all;
  };
  const std::string first = fold();
  std::ranges::sort(list);
  RC_ASSERT(fold() == first);
}

TEST(CacheFamily, AnAncestorMergedIntoItsDescendantGivesTheDescendant) {
  int pairs = 0;
  for (const Member& descendant : family()) {
    for (int parent = descendant.parent; parent != nobody; parent = family()[static_cast<std::size_t>(parent)].parent) {
      EXPECT_EQ(merged(descendant.bytes, family()[static_cast<std::size_t>(parent)].bytes), descendant.bytes);
      ++pairs;
    }
  }
  EXPECT_EQ(pairs, 7);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
