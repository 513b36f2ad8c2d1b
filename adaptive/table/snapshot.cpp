// Slices, and the conversion of a table to plain data and back: load and snapshot.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "table/table.h"
#include "tress/adaptive/to_string.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::size_t least_index_bytes = std::size_t{16} << 20;
constexpr std::size_t batch_of_cached = 256;  // cached rows that are admitted at once; admit() has as many in a batch

bool same_axes(const SliceDescription& a, const SliceDescription& b) {
  return a.axis_a == b.axis_a && a.axis_b == b.axis_b && a.blur_rad == b.blur_rad && a.kind == b.kind;
}

std::string describe(const SliceDescription& slice) { return "slice of " + to_string(slice.key); }

std::string describe_axes(const SliceDescription& slice) {
  return std::to_string(slice.axis_a.size()) + " x " + std::to_string(slice.axis_b.size()) + " nodes, " +
         (slice.kind == SliceKind::samples ? "of samples" : "blur " + std::to_string(slice.blur_rad) + " rad");
}

Error other_axes(const SliceDescription& own, const SliceDescription& cached) {
  return {"", describe(own), describe_axes(own), describe_axes(cached) + " (or other coordinates of as many)"};
}

/// Clears the fields that have no meaning for a slice of samples.
SliceDescription normal_form(SliceDescription slice) {
  if (slice.kind == SliceKind::samples) slice.blur_rad = 0;
  return slice;
}

}  // namespace

std::optional<Error> Service::Table::unusable(const SliceDescription& slice) const {
  if (slice.node_count() == 0) return Error{"", describe(slice), "at least one node", "none"};
  const bool samples = slice.kind == SliceKind::samples;
  const auto ascends = [](const std::vector<float>& axis) {
    return std::ranges::all_of(axis, [](float x) { return std::isfinite(x); }) &&
           std::ranges::adjacent_find(axis, std::greater_equal<>()) == axis.end();
  };
  if (!ascends(slice.axis_a) || !ascends(slice.axis_b))
    return Error{"", describe(slice), "axes of finite numbers that ascend", "others"};
  if (!std::ranges::all_of(slice.key.parameters, [](float x) { return std::isfinite(x); }))
    return Error{"", describe(slice), "parameters that are finite", "others"};
  if (!samples && !(slice.blur_rad > 0 && std::isfinite(slice.blur_rad)))
    return Error{"", describe(slice), "a finite blur above 0", std::to_string(slice.blur_rad)};
  for (const CoarseAxes& grid : slice.coarse) {
    const auto covers = [](const std::vector<std::uint32_t>& chosen, std::size_t size) {
      return !chosen.empty() && chosen.front() == 0 && chosen.back() == size - 1 &&
             std::ranges::adjacent_find(chosen, std::greater_equal<>()) == chosen.end();
    };
    if (!samples || !covers(grid.a, slice.axis_a.size()) || !covers(grid.b, slice.axis_b.size()))
      return Error{"", describe(slice), "coarse axes of ascending indices, the first and the last among them",
                   "others"};
  }
  if (slice.coarse_rows_of) {
    const SliceId* found = rows_.find(*slice.coarse_rows_of);
    const Slice* other = found != nullptr ? &rows_.slice(*found) : nullptr;
    if (!samples || other == nullptr || !same_axes(other->description, normal_form(slice)) ||
        other->description.coarse != slice.coarse || samples_->parts(other->description) != samples_->parts(slice))
      return Error{"", describe(slice), "coarse rows of a slice of samples with the same grids that was added before",
                   other == nullptr ? "none" : describe(other->description)};
  }
  if (samples ? samples_ == nullptr : target_ == nullptr) {
    return Error{"", describe(slice), samples ? "a target of samples" : "a target of densities", "none"};
  }
  const std::size_t count = slice.key.used_parameters().size();
  if (samples || count <= SliceKey::density_parameters) return std::nullopt;
  return Error{"", describe(slice),
               std::to_string(SliceKey::density_parameters) + " parameters of a slice of densities",
               std::to_string(count)};
}

Result<SliceId> Service::Table::add_slice(const SliceDescription& asked) {
  if (std::optional<Error> early = discipline_.within_pass("add_slice")) {
    discipline_.note(*early);  // models pass on only the id, so the error would be lost
    return std::move(*early);
  }
  if (std::optional<Error> error = unusable(asked)) return std::move(*error);
  const SliceDescription description = normal_form(asked);
  if (const SliceId* found = rows_.find(description.key)) {
    const SliceDescription& own = rows_.slice(*found).description;
    if (!same_axes(own, description)) return other_axes(own, description);
    return *found;
  }
  const std::size_t index = Slice::index_bytes(description);
  const bool has_index = index_bytes_ + index <= std::max(options_.memory_bytes, least_index_bytes);
  if (has_index) {
    index_bytes_ += index;
  } else {
    log(describe(description) + ": no room for its index, so it is traced whenever it is asked");
  }
  const bool is_of_samples = description.kind == SliceKind::samples;
  const SliceId id = rows_.add_slice(description, has_index, is_of_samples ? samples_->parts(description) : 0);
  if (description.coarse_rows_of) {
    Slice& other = rows_.slice(*rows_.find(*description.coarse_rows_of));
    Slice* const owner = other.coarse_rows != nullptr ? other.coarse_rows : &other;
    Slice& added = rows_.slice(id);
    if (owner->has_index() && added.has_index()) {
      added.coarse_rows = owner;
      owner->answers_for.push_back(&added);
    }
  }
  if (const auto cached = unused_.find(description.key); cached != unused_.end()) {
    // A slice on other axes cannot be used, nor saved beside this one.
    if (same_axes(cached->second.description(), description)) {
      PackedSliceRows rows(cached->second, model_name());
      (void)take(rows);
    } else {
      refusals_.push_back(other_axes(description, cached->second.description()));
      log(refusals_.back().message());
    }
    unused_.erase(cached);
  }
  return id;
}

bool Service::Table::may_answer(const Slice& slice, const CachedRow& row) const {
  const bool is_density = slice.description.kind == SliceKind::density;
  if (row.density() != nullptr || is_density) return row.density() != nullptr && is_density;
  return row.state != RowState::converged || (row.ribbons() != nullptr && row.ribbons()->parts() == slice.parts);
}

std::optional<Error> Service::Table::take(RowSource& rows) {
  PassReport resumed;
  std::vector<Candidate> candidates;
  bool room = true;
  const auto admit_candidates = [&] {
    room = admit(candidates, resumed) && room;
    candidates.clear();
  };
  // Rows that answer at once come first; the others go on learning in the memory that is left.
  for (const bool answering : {true, false}) {
    rows.rewind();
    while (const SliceDescription* description = rows.next_slice()) {
      const SliceId* found = rows_.find(description->key);
      if (found == nullptr) {
        if (!answering) continue;
        PackedSlice& unused = unused_.insert_or_assign(description->key, PackedSlice(*description)).first->second;
        while (const CachedRow* row = rows.next_row()) unused.add(*row);
        continue;
      }
      const SliceId id = *found;
      Slice& slice = rows_.slice(id);
      while (const CachedRow* row = rows.next_row()) {
        const bool is_node = row->node < slice.description.node_count();
        if (!is_node || !may_answer(slice, *row) || answers(id, *row) != answering) continue;
        if (slice.has_index() && slice.slots[row->node].row != Slot::no_row) continue;
        slice.stored.insert_or_assign(row->node, *row);
        // Whether a coarse row is good enough is known once the light of its node is; an open row of samples has
        // nothing to start from.
        const bool waits = !answering && (light_.is_driven() || row->density() == nullptr);
        if (!slice.has_index() || !room || waits) continue;
        const std::uint32_t queries = slice.slots[row->node].queries.load(std::memory_order_relaxed);
        candidates.push_back({id, row->node, queries, 0, nullptr});
        if (candidates.size() == batch_of_cached) admit_candidates();
      }
    }
  }
  admit_candidates();
  between_passes_.g_evaluations += resumed.g_evaluations;
  between_passes_.refits += resumed.refits;
  between_passes_.bad_fits += resumed.bad_fits;
  between_passes_.traces += resumed.traces;
  return rows.failure();
}

std::optional<Error> Service::Table::load(RowSource& rows) {
  if (rows.model() != model_name()) return Error{"", "model", model_name(), rows.model()};
  rows.rewind();
  while (const SliceDescription* cached = rows.next_slice()) {
    const SliceId* found = rows_.find(cached->key);
    if (found == nullptr) continue;
    const SliceDescription& own = rows_.slice(*found).description;
    if (!same_axes(own, *cached)) return other_axes(own, *cached);
  }
  if (std::optional<Error> error = rows.failure()) return error;
  changes_.clear();
  return take(rows);
}

/// The rows of all slices, including unused ones, in order of their keys. Slices without rows are left out: the next
/// session describes them again.
class Service::Table::AllRows final : public RowSource {
 public:
  explicit AllRows(const Table& table) : table_(table), model_(table.model_name()) { rewind(); }

  const std::string& model() const override { return model_; }
  void rewind() override {
    used_ = table_.rows_.by_key().begin();
    unused_ = table_.unused_.begin();
    slice_ = nullptr;
    cached_.reset();
    failure_.reset();
  }
  const SliceDescription* next_slice() override {
    while (used_ != table_.rows_.by_key().end() || unused_ != table_.unused_.end()) {
      slice_ = nullptr;
      cached_.reset();
      node_ = 0;
      const bool from_cache =
          used_ == table_.rows_.by_key().end() || (unused_ != table_.unused_.end() && unused_->first < used_->first);
      if (from_cache) {
        cached_.emplace((unused_++)->second, model_);
        return cached_->next_slice();
      }
      slice_ = &table_.rows_.slice((used_++)->second);
      stored_ = slice_->stored.begin();
      if (has_rows()) return &slice_->description;
    }
    slice_ = nullptr;
    cached_.reset();
    return nullptr;
  }
  const CachedRow* next_row() override {
    if (cached_) {
      const CachedRow* row = cached_->next_row();
      if (row == nullptr && !failure_) failure_ = cached_->failure();
      return row;
    }
    if (slice_ == nullptr) return nullptr;
    while (slice_->has_index() && node_ < slice_->description.node_count()) {
      const std::uint32_t node = node_++;
      const Slot& slot = slice_->slots[node];
      const bool is_stored = stored_ != slice_->stored.end() && stored_->first == node;
      const CachedRow* stored = is_stored ? &(stored_++)->second : nullptr;
      if (slot.row == Slot::no_row && stored == nullptr) continue;
      if (slot.row == Slot::no_row) return stored;
      row_ = table_.rows_.cached_form(table_.rows_[slot.row]);
      return &row_;
    }
    return !slice_->has_index() && stored_ != slice_->stored.end() ? &(stored_++)->second : nullptr;
  }
  std::optional<Error> failure() const override { return failure_; }

 private:
  bool has_rows() const {
    if (!slice_->stored.empty()) return true;
    for (std::uint32_t n = 0; slice_->has_index() && n < slice_->description.node_count(); ++n) {
      if (slice_->slots[n].row != Slot::no_row) return true;
    }
    return false;
  }

  const Table& table_;
  std::string model_;
  std::map<SliceKey, SliceId>::const_iterator used_;
  std::map<SliceKey, PackedSlice>::const_iterator unused_;
  const Slice* slice_ = nullptr;           ///< the current slice of the table, or
  std::optional<PackedSliceRows> cached_;  ///< the current unused slice
  std::optional<Error> failure_;
  std::uint32_t node_ = 0;  ///< next node of slice_
  std::map<std::uint32_t, CachedRow>::const_iterator stored_;
  CachedRow row_;
};

std::unique_ptr<RowSource> Service::Table::rows() const { return std::make_unique<AllRows>(*this); }

TableSnapshot Service::Table::snapshot() const { return collect(*rows()); }

}  // namespace tress::inline v0_2::adaptive
