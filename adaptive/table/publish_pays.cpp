// Whether a publish would make answers better, by what the pass has asked so far.
#include <algorithm>

#include "table/table.h"

namespace tress::inline v0_2::adaptive {

bool Service::Table::publish_pays(double share) const {
  if (!learns_) return false;
  const bool has_room = bytes_ < options_.memory_bytes;
  std::uint64_t queries = answered_queries_.sum() + unindexed_queries_.sum(), waiting = 0;
  for (const SliceId id : rows_.of_kind(SliceKind::samples)) {
    if (samples_pay(id, share)) return true;
  }
  for (const SliceId id : rows_.of_kind(SliceKind::density)) {
    const Slice& slice = rows_.slice(id);
    for (std::uint32_t n = 0; n < slice.description.node_count(); ++n) {
      const Slot& slot = slice.slots[n];
      const std::uint32_t in_all = slot.queries.load(std::memory_order_relaxed),
                          asked = in_all - slice.queries_before[n];
      queries += asked;
      const bool is_learned = slot.row == Slot::no_row ? has_room && in_all >= options_.queries_before_creation
                                                       : rows_.state_of(rows_[slot.row]) == RowState::open;
      if (is_learned) waiting += asked;
    }
  }
  return waiting > 0 && static_cast<double>(waiting) >= share * static_cast<double>(queries);
}

bool Service::publish_pays(double share) const { return table_->publish_pays(share); }

}  // namespace tress::inline v0_2::adaptive
