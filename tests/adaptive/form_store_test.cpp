// Answers of forms alone: made once, counted, kept while there is room, dropped by node.
#include "table/form_store.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <memory>
#include <vector>

#include "adaptive/toy_target.h"

namespace tress::inline v0_2::adaptive {
namespace {

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
  const FormedRows& rows = *store.add(0, slice, form, true, true);
  const std::size_t entries = 16 * sizeof(RowEntry);
  EXPECT_EQ(bytes, entries);
  EXPECT_TRUE(store.has(rows));
  EXPECT_FALSE(store.find(rows, 5));
  const RowAnswer made = store.make(rows, converged(5));
  EXPECT_EQ(*static_cast<const std::uint32_t*>(made.block()), 5u);
  EXPECT_EQ(store.find(rows, 5).block(), made.block());
  EXPECT_EQ(store.make(rows, converged(5)).block(), made.block());
  EXPECT_EQ(bytes, entries + 128);
}

TEST_F(Stored, WhatIsGrantedRestsAndTheRestIsDropped) {
  const FormedRows& rows = *store.add(0, slice, form, true, true);
  const std::size_t entries = bytes;
  EXPECT_TRUE(store.ask(rows, 1)) << "all have room";
  const RowAnswer made = store.make(rows, converged(5));
  store.make(rows, converged(6));
  EXPECT_TRUE(store.was_asked(rows, 5));
  EXPECT_FALSE(store.was_asked(rows, 1)) << "it was not made";
  store.mark_all();
  store.grant(rows, 5);
  store.rest_all();
  EXPECT_EQ(bytes, entries + 128);
  EXPECT_FALSE(store.find(rows, 5));
  EXPECT_FALSE(store.wake(rows, 6));
  EXPECT_FALSE(store.was_asked(rows, 5));
  EXPECT_TRUE(store.ask(rows, 5));
  EXPECT_FALSE(store.ask(rows, 6));
  EXPECT_TRUE(store.was_asked(rows, 6));
  EXPECT_EQ(store.wake(rows, 5).block(), made.block());
  EXPECT_EQ(store.find(rows, 5).block(), made.block());
  EXPECT_EQ(store.made_nodes(0), (std::vector<std::uint32_t>{5}));
  store.rest_all();
  store.free_all();
  EXPECT_EQ(store.find(rows, 5).block(), made.block());
}

TEST_F(Stored, RunsMayHideWhatIsMade) {
  const FormedRows& hidden = *store.add(0, slice, form, true, false);
  const RowAnswer made = store.make(hidden, converged(5));
  EXPECT_EQ(store.find(hidden, 5).block(), made.block());
  EXPECT_FALSE(AnswerReader(nullptr).read(hidden.run(1), 1));
  EXPECT_FALSE(FormStore::has_entries(*store.add(0, slice, form, false, true)));
}

TEST_F(Stored, ANodeMayHaveAnAnswerInPlaceOfItsRow) {
  const FormedRows& rows = *store.add(0, slice, form, true, true);
  EXPECT_EQ(store.find(rows, 3).block(), &form->fixed);
  EXPECT_FALSE(store.find(rows, 3).has_row());
  EXPECT_TRUE(store.made_nodes(0).empty());
}

TEST_F(Stored, AnswersAreDroppedByNode) {
  const FormedRows& rows = *store.add(0, slice, form, true, true);
  const std::size_t entries = bytes;
  for (const std::uint32_t node : {9u, 5u, 1u}) store.make(rows, converged(node));
  EXPECT_EQ(store.made_nodes(0), (std::vector<std::uint32_t>{1, 5, 9}));
  store.drop_if(0, [](std::uint32_t node) { return node == 5; });
  EXPECT_EQ(store.made_nodes(0), (std::vector<std::uint32_t>{1, 9}));
  EXPECT_FALSE(store.find(rows, 5));
  EXPECT_TRUE(store.find(rows, 9));
  store.drop(0);
  EXPECT_EQ(bytes, entries);
}

TEST_F(Stored, AHandleOfAnotherStoreIsReported) {
  std::atomic<std::size_t> others{0};
  FormStore other(others);
  const FormedRows& rows = *other.add(0, slice, form, true, true);
  EXPECT_FALSE(store.has(rows));
  store.add(0, slice, form, true, true);
  EXPECT_FALSE(store.has(rows));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
