// The table as plain data and back: slices, load and snapshot.
#include <algorithm>
#include <cassert>
#include <string>

#include "table/table.h"

namespace tress::adaptive {
namespace {

constexpr std::size_t least_index_bytes = std::size_t{16} << 20;

bool same_axes(const SliceDescription& a, const SliceDescription& b) {
  return a.axis_a == b.axis_a && a.axis_b == b.axis_b && a.blur_rad == b.blur_rad;
}

std::string describe(const SliceDescription& slice) {
  std::string text = "page of lobe " + std::to_string(slice.key.lobe);
  for (const float parameter : slice.key.parameters) text += ", " + std::to_string(parameter);
  return text;
}

std::string describe_axes(const SliceDescription& slice) {
  return std::to_string(slice.axis_a.size()) + " x " + std::to_string(slice.axis_b.size()) + " nodes, blur " +
         std::to_string(slice.blur_rad) + " rad";
}

Error other_axes(const SliceDescription& own, const SliceDescription& cached) {
  return {"", describe(own), describe_axes(own), describe_axes(cached) + " (or other coordinates of as many)"};
}

void keep_stored(Slice& slice, CachedSlice&& cached) {
  for (CachedRow& row : cached.rows) {
    const bool has_row =
        slice.has_index() && row.node < slice.description.node_count() && slice.slots[row.node].row != Slot::no_row;
    if (row.node < slice.description.node_count() && !has_row) {
      slice.stored.insert_or_assign(row.node, std::move(row));
    }
  }
}

CachedRow cached_form(const Row& row, const Slot& slot) {
  if (row.learning && row.learning->earlier) return *row.learning->earlier;
  CachedRow cached;
  cached.node = row.node;
  cached.generation = row.generation;
  cached.energy = row.energy;
  cached.count = row.taught();
  if (row.learning) {
    cached.sketch = row.learning->sketch.bins();
    return cached;
  }
  cached.state = RowState::converged;
  if (const KnotRow* knots = slot.knots()) {
    cached.knots = knots->table;
    cached.objective = knots->objective;
  } else {
    cached.fit = *slot.mixture();
    cached.objective = slot.mixture()->objective;
  }
  return cached;
}

}  // namespace

SliceId Service::Table::add_slice(const SliceDescription& description) {
  assert(description.node_count() > 0);
  if (const auto found = slice_of_key_.find(description.key); found != slice_of_key_.end()) {
    assert(same_axes(slices_[found->second]->description, description));
    return found->second;
  }
  const auto id = static_cast<SliceId>(slices_.size());
  const std::size_t index = Slice::index_bytes(description);
  const bool has_index = index_bytes_ + index <= std::max(options_.memory_bytes, least_index_bytes);
  if (has_index) index_bytes_ += index;
  slices_.push_back(std::make_unique<Slice>(description, has_index));
  slice_of_key_.emplace(description.key, id);
  if (const auto cached = unused_.find(description.key); cached != unused_.end()) {
    // A slice on other axes cannot be used, nor saved beside this one.
    if (same_axes(cached->second.description, description)) {
      keep_stored(*slices_.back(), std::move(cached->second));
      resume({id});
    } else {
      refusals_.push_back(other_axes(description, cached->second.description));
    }
    unused_.erase(cached);
  }
  return id;
}

void Service::Table::resume(const std::vector<SliceId>& slices) {
  std::vector<Candidate> candidates;
  for (const SliceId p : slices) {
    if (!slices_[p]->has_index()) continue;
    for (const auto& [node, cached] : slices_[p]->stored) {
      // What a coarse row is good for is not known before the light of its node is.
      if (is_light_driven() && !answers(p, cached)) continue;
      candidates.push_back({p, node, slices_[p]->slots[node].queries.load(std::memory_order_relaxed), 0, nullptr});
    }
  }
  std::ranges::sort(candidates, [&](const Candidate& x, const Candidate& y) {
    const bool x_open = needs_nodes(x), y_open = needs_nodes(y);
    if (x_open != y_open) return y_open;
    const auto order = compare_keys(slices_[x.slice]->description.key, slices_[y.slice]->description.key);
    return order != 0 ? order < 0 : x.node < y.node;
  });
  PassReport resumed;
  admit(candidates, resumed);
  between_passes_.g_evaluations += resumed.g_evaluations;
  between_passes_.refits += resumed.refits;
  between_passes_.bad_fits += resumed.bad_fits;
  between_passes_.traces += resumed.traces;
  std::ranges::sort(changes_, [](const RowChange& x, const RowChange& y) {
    return x.slice != y.slice ? x.slice < y.slice : x.node < y.node;
  });
}

std::optional<Error> Service::Table::load(TableSnapshot image) {
  if (image.model != target_.model_name()) {
    return Error{"", "model", target_.model_name(), image.model};
  }
  for (const CachedSlice& cached : image.slices) {
    const auto found = slice_of_key_.find(cached.description.key);
    if (found == slice_of_key_.end()) continue;
    const SliceDescription& own = slices_[found->second]->description;
    if (!same_axes(own, cached.description)) return other_axes(own, cached.description);
  }
  changes_.clear();
  std::vector<SliceId> used;
  for (CachedSlice& cached : image.slices) {
    const auto found = slice_of_key_.find(cached.description.key);
    if (found == slice_of_key_.end()) {
      unused_.insert_or_assign(cached.description.key, std::move(cached));
      continue;
    }
    keep_stored(*slices_[found->second], std::move(cached));
    used.push_back(found->second);
  }
  resume(used);
  return std::nullopt;
}

TableSnapshot Service::Table::snapshot() const {
  std::map<SliceKey, CachedSlice, KeyLess> all = unused_;
  for (const auto& [key, id] : slice_of_key_) {
    const Slice& slice = *slices_[id];
    CachedSlice cached{slice.description, {}};
    if (!slice.has_index()) {
      for (const auto& [node, row] : slice.stored) cached.rows.push_back(row);
    }
    for (std::uint32_t n = 0; slice.has_index() && n < slice.description.node_count(); ++n) {
      if (slice.slots[n].row != Slot::no_row) {
        cached.rows.push_back(cached_form(rows_[slice.slots[n].row], slice.slots[n]));
      } else if (const auto stored = slice.stored.find(n); stored != slice.stored.end()) {
        cached.rows.push_back(stored->second);
      }
    }
    // A slice without rows says nothing: the next session describes it anew.
    if (!cached.rows.empty()) all.insert_or_assign(key, std::move(cached));
  }
  TableSnapshot image;
  image.model = target_.model_name();
  for (auto& [key, slice] : all) image.slices.push_back(std::move(slice));
  return image;
}

}  // namespace tress::adaptive
