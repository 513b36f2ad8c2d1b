// A saved state as read from bytes, before the table takes it over.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cache/packed_slice.h"
#include "table/state.h"
#include "table/table.h"

namespace tress::adaptive {

struct SavedNode {
  std::uint32_t node, queries, events;
  std::uint64_t light;
};

/// The fields have the meaning that they have in Row and Learning.
struct Service::Table::SavedRow {
  SliceId slice = 0;
  std::uint32_t node = 0;
  state_format::Kind kind = state_format::Kind::answer;
  Audit audit = Audit::none;
  bool has_converged = false;  ///< for rows of samples
  std::uint8_t failed = 0;
  float energy = 0;
  std::uint32_t generation = 0;
  std::uint64_t count = 0;
  // The rest is read for rows that learn.
  float objective = -1;
  bool has_earlier = false;
  std::unique_ptr<const CachedRow> earlier;
  std::vector<SketchBin> sketch;
  std::unique_ptr<RowLearner> learner;
  StopTest::State stop;
  bool has_fit = false, is_published = false;
  Mixture fit;
  std::uint64_t taught = 0;  ///< Learning::count
  std::uint32_t created_pass = 0, queries_at_creation = 0;
  std::uint64_t observed = 0;
  FixedMoments<14>::Words weights{};
  std::unique_ptr<const TracedNodes> nodes;  ///< not saved; traced again
};

struct Service::Table::SavedSlice {
  explicit SavedSlice(const SliceDescription& slice) : answers(slice), stored(slice), earlier(slice) {}
  std::uint32_t node_count() const { return answers.description().node_count(); }

  bool audited = false;
  std::vector<SavedNode> nodes;
  PackedSlice answers, stored, earlier;
  std::vector<std::uint32_t> interpolated;
  std::uint64_t heard_paths = 0;
  std::vector<std::pair<std::uint32_t, std::vector<SampledExit>>> heard;  ///< by node
  std::vector<std::vector<std::uint32_t>> made;                           ///< nodes whose answer each form had made
  std::vector<std::uint32_t> row_of_node;                                 ///< Slot::no_row for nodes without a row
};

struct Service::Table::SavedTable {
  std::uint32_t version = 0, pass = 0;
  std::uint64_t paths = 0, reopened = 0, reopened_told = 0, queried = 0;
  bool ceiling_told = false, unusable_told = false;
  ErrorQuantiles absorbed_errors;
  std::vector<SavedSlice> slices;
  std::map<SliceKey, PackedSlice, KeyLess> unused;  ///< as in Table
  std::vector<SavedRow> rows;
};

}  // namespace tress::adaptive
