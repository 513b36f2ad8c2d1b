// Nodes of samples without a row of their own: the coarser rows around them answer, by displacement interpolation.
#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "density/interpolated_row.h"
#include "table/table.h"

namespace tress::inline v0_2::adaptive {

Service::Table::SampledAnswer Service::Table::answer_of(Slice& slice, std::uint32_t node) {
  const std::uintptr_t word = slice.slots[node].word.load(std::memory_order_acquire);
  const Slot::Kind kind = Slot::kind_of(word);
  if (kind == Slot::Kind::ribbons || kind == Slot::Kind::interpolated)
    return without_owner(Slot::target_of<RibbonAnswer>(word));
  if (kind == Slot::Kind::refusal) return {};
  if (slice.grid.has(node)) {
    const SampledAnswer theirs = slice.coarse_rows != nullptr ? answer_of(*slice.coarse_rows, node) : SampledAnswer();
    if (!theirs) return {};
    auto copy = std::make_unique<RibbonAnswer>(*theirs);
    copy->has_converged = false;
    return keep_interpolated(slice, node, std::move(copy));
  }
  if (slice.grid.empty()) return {};

  std::array<DecodedRow, 4> decoded;
  std::array<WeightedRow, 4> rows;
  std::size_t count = 0;
  auto made = std::make_unique<RibbonAnswer>();
  for (const CoarseGrid::Corner& corner : slice.grid.around(node)) {
    if (!(corner.weight > 0)) continue;
    const SampledAnswer parent = answer_of(slice, corner.node);
    if (!parent) return {};
    made->objective = std::max(made->objective, parent->objective);
    made->paths = count == 0 ? parent->paths : std::min(made->paths, parent->paths);
    decoded[count] = DecodedRow(parent->row);
    rows[count] = {&decoded[count], corner.weight};
    ++count;
  }
  made->row = interpolate_rows({rows.data(), count});
  made->has_converged = false;
  return keep_interpolated(slice, node, std::move(made));
}

Service::Table::SampledAnswer Service::Table::keep_interpolated(Slice& slice, std::uint32_t node,
                                                                std::unique_ptr<const RibbonAnswer> made) {
  Slot& slot = slice.slots[node];
  const std::size_t before = formed_bytes_.fetch_add(sizeof(RibbonAnswer), std::memory_order_relaxed);
  const std::size_t others = bytes_ + memo_bytes_.load(std::memory_order_relaxed);
  const bool has_room = kept_before_ != nullptr
                            ? &slice == kept_slice_ && std::ranges::binary_search(*kept_before_, node)
                            : others + before + sizeof(RibbonAnswer) <= options_.memory_bytes;
  if (slot.row != Slot::no_row || !has_room) {
    formed_bytes_.fetch_sub(sizeof(RibbonAnswer), std::memory_order_relaxed);
    return made;
  }
  const auto [there, is_first] = slot.put_first(std::move(made), Slot::Kind::interpolated);
  if (!is_first) {
    formed_bytes_.fetch_sub(sizeof(RibbonAnswer), std::memory_order_relaxed);
    return without_owner(there);
  }
  const std::scoped_lock lock(interpolated_mutex_);
  slice.interpolated.push_back(node);
  return without_owner(there);
}

RowView Service::Table::view_at(SliceId id, std::uint32_t node) {
  Slice& slice = rows_.slice(id);
  const Slot& slot = slice.slots[node];
  RowView view = slot.row != Slot::no_row ? view_of(slot) : RowView{};
  view.slice = id;
  view.node = node;
  view.pass = pass_;
  if (slot.row != Slot::no_row) return view;
  const SampledAnswer answer = answer_of(slice, node);
  if (!answer) return view;
  view.ribbons = &answer->row;
  view.objective = answer->objective;
  view.paths = answer->paths;
  if (answer.use_count() > 0) view.kept = answer;
  return view;
}

void Service::Table::forget_interpolated(SliceId id, std::vector<bool> moved) {
  if (std::ranges::find(moved, true) == moved.end()) return;
  Slice& slice = rows_.slice(id);
  for (std::uint32_t n = 0; n < slice.description.node_count() && !slice.grid.empty(); ++n) {
    if (slice.grid.has(n) || slice.slots[n].row != Slot::no_row) continue;
    for (const CoarseGrid::Corner& corner : slice.grid.around(n)) {
      if (corner.weight > 0 && moved[corner.node]) moved[n] = true;
    }
  }
  for (const std::uint32_t form : slice.forms) forms_.drop_if(form, [&](std::uint32_t node) { return moved[node]; });
  std::erase_if(slice.interpolated, [&](std::uint32_t n) {
    if (!moved[n] && slice.slots[n].row == Slot::no_row) return false;
    let_go_interpolated(slice, n);
    return true;
  });
}

void Service::Table::let_go_all_interpolated(Slice& slice) {
  for (const std::uint32_t node : slice.interpolated) let_go_interpolated(slice, node);
  slice.interpolated.clear();
}

void Service::Table::let_go_interpolated(Slice& slice, std::uint32_t node) {
  if (slice.slots[node].interpolated() == nullptr) return;
  formed_bytes_ -= sizeof(RibbonAnswer);
  slice.slots[node].set<TracedNodes>(nullptr, Slot::Kind::traced);
}

}  // namespace tress::inline v0_2::adaptive
