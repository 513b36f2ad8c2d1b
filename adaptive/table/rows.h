// The slices and rows of a table, and what answers at their nodes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "density/mixture_store.h"
#include "table/row.h"
#include "table/slice.h"
#include "tress/adaptive/row_view.h"

namespace tress::inline v0_2::adaptive {

/// The view that a reader gets of a node that has a row.
RowView view_of(const Slot& slot);

/// The one place that knows how a row answers: a Learning, a mixture, ribbons, or a refusal. Slices and rows stay where
/// they are, and are never removed. Functions that change something: one thread, while there is no reader.
class Rows {
 public:
  /// Adds a slice; the arguments are those of its constructor.
  SliceId add_slice(const SliceDescription& description, bool has_index, std::uint32_t parts);
  std::uint32_t slice_count() const { return static_cast<std::uint32_t>(slices_.size()); }
  Slice& slice(SliceId id) const { return *slices_[id]; }
  const std::vector<std::unique_ptr<Slice>>& slices() const { return slices_; }
  /// The slices of a kind that have an index, in the order in which they were added.
  const std::vector<SliceId>& of_kind(SliceKind kind) const { return of_kind_[static_cast<std::size_t>(kind)]; }
  /// The slices in the order of their keys.
  const std::map<SliceKey, SliceId>& by_key() const { return by_key_; }
  /// Null if there is no slice of this key.
  const SliceId* find(const SliceKey& key) const {
    const auto found = by_key_.find(key);
    return found == by_key_.end() ? nullptr : &found->second;
  }

  /// Adds a row at its node, which has none; it does not answer yet.
  Row& add(Row row);
  std::uint32_t size() const { return static_cast<std::uint32_t>(rows_.size()); }
  bool empty() const { return rows_.empty(); }
  Row& operator[](std::size_t i) { return rows_[i]; }
  const Row& operator[](std::size_t i) const { return rows_[i]; }
  auto begin() { return rows_.begin(); }
  auto begin() const { return rows_.begin(); }
  auto end() { return rows_.end(); }
  auto end() const { return rows_.end(); }

  Slot& slot_of(const Row& row) const { return slice(row.slice).slots[row.node]; }
  RowState state_of(const Row& row) const;
  /// The bound of the row's last test; negative before the first, and for refused rows of samples.
  float objective_of(const Row& row) const;
  /// Bytes of the row and of its answer.
  std::size_t bytes_of(const Row& row) const;
  /// The row as a cache stores it: earlier_of(row) if there is one; otherwise as it is now, refused rows as open.
  CachedRow cached_form(const Row& row) const;

  // What readers use from now on.
  /// Shows a row that learns and, if `publishes`, its fit. If it has converged, its Learning is freed.
  void show_learning(Row& row, bool converged, bool publishes = true);
  /// Lets a cached row answer, without learning. has_converged: whether a row of samples counts as converged.
  void show_cached(Row& row, const CachedRow& cached, bool has_converged);
  void show_ribbons(Row& row, std::unique_ptr<const RibbonAnswer> answer) {
    slot_of(row).set(answer.release(), Slot::Kind::ribbons);
  }
  void refuse(Row& row) { slot_of(row).set<RibbonAnswer>(nullptr, Slot::Kind::refusal); }
  /// Leaves the row without an answer, until one of the above.
  void clear(Row& row) { slot_of(row).set<RibbonAnswer>(nullptr, Slot::Kind::traced); }

 private:
  std::vector<std::unique_ptr<Slice>> slices_;
  std::map<SliceKey, SliceId> by_key_;
  std::array<std::vector<SliceId>, 2> of_kind_;
  std::deque<Row> rows_;   ///< in order of creation
  MixtureStore mixtures_;  ///< the published fits
};

}  // namespace tress::inline v0_2::adaptive
