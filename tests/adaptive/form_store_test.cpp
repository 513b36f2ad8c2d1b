// Answers of forms alone: made once, counted, kept while there is room, dropped by node.
#include "table/form_store.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "adaptive/toy_target.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::size_t all_room = std::numeric_limits<std::size_t>::max();

/// Writes the node; node 3 has an answer in place of its row.
struct NodeForm final : RowForm {
  std::size_t bytes(const RowView&) const override { return 100; }
  void write(const RowView& row, void* memory) const override { std::memcpy(memory, &row.node, sizeof row.node); }
  const void* instead_of_row(std::uint32_t node) const override { return node == 3 ? &fixed : nullptr; }
  std::uint32_t fixed = 7;
};

RowView converged(std::uint32_t node) {
  RowView row;
  row.state = RowState::converged;
  row.node = node;
  return row;
}

struct Stored : ::testing::Test {
  std::atomic<std::size_t> bytes{0};
  FormStore store{bytes};
  const SliceDescription slice = testing::toy_slice(1, 4);
  const std::shared_ptr<const NodeForm> form = std::make_shared<NodeForm>();
};

TEST_F(Stored, AnAnswerIsMadeOnceAndCountedInWholeLines) {
  const FormedRows& rows = *store.add(0, slice, form, true);
  EXPECT_EQ(bytes, 0u);
  EXPECT_TRUE(store.has(rows));
  EXPECT_FALSE(store.find(rows, 5));
  const FormedLookup made = store.make(rows, converged(5), all_room);
  EXPECT_FALSE(made.kept);
  EXPECT_EQ(*static_cast<const std::uint32_t*>(made.answer.block()), 5u);
  EXPECT_EQ(store.find(rows, 5).block(), made.answer.block());
  EXPECT_EQ(store.make(rows, converged(5), all_room).answer.block(), made.answer.block());
  EXPECT_EQ(bytes, 128u);
}

TEST_F(Stored, PastTheRoomAnAnswerBelongsToItsReader) {
  const FormedRows& rows = *store.add(0, slice, form, true);
  EXPECT_TRUE(store.make(rows, converged(5), bytes + 127).kept);
  EXPECT_FALSE(store.find(rows, 5));
  EXPECT_FALSE(store.make(rows, converged(5), bytes + 128).kept);
  const FormedRows& without = *store.add(0, slice, form, false);
  EXPECT_FALSE(FormStore::has_entries(without));
  EXPECT_TRUE(store.make(without, converged(5), all_room).kept);
}

TEST_F(Stored, ANodeMayHaveAnAnswerInPlaceOfItsRow) {
  const FormedRows& rows = *store.add(0, slice, form, true);
  EXPECT_EQ(store.find(rows, 3).block(), &form->fixed);
  EXPECT_FALSE(store.find(rows, 3).has_row());
  EXPECT_TRUE(store.made_nodes(0).empty());
}

TEST_F(Stored, AnswersAreDroppedByNode) {
  const FormedRows& rows = *store.add(0, slice, form, true);
  for (const std::uint32_t node : {9u, 5u, 1u}) store.make(rows, converged(node), all_room);
  EXPECT_EQ(store.made_nodes(0), (std::vector<std::uint32_t>{1, 5, 9}));
  store.drop_if(0, [](std::uint32_t node) { return node == 5; });
  EXPECT_EQ(store.made_nodes(0), (std::vector<std::uint32_t>{1, 9}));
  EXPECT_FALSE(store.find(rows, 5));
  EXPECT_TRUE(store.find(rows, 9));
  store.drop(0);
  EXPECT_EQ(bytes, 0u);
}

TEST_F(Stored, AHandleOfAnotherStoreIsReported) {
  std::atomic<std::size_t> others{0};
  FormStore other(others);
  const FormedRows& rows = *other.add(0, slice, form, true);
  EXPECT_FALSE(store.has(rows));
  store.add(0, slice, form, true);
  EXPECT_FALSE(store.has(rows));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
