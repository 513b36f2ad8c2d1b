#include "table/rows.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace tress::inline v0_2::adaptive {

RowView view_of(const Slot& slot) {
  RowView view;
  view.row = slot.row;
  const std::uintptr_t word = slot.word.load(std::memory_order_relaxed);
  switch (Slot::kind_of(word)) {
    case Slot::Kind::traced:
      view.nodes = Slot::target_of<TracedNodes>(word);
      break;
    case Slot::Kind::learning: {
      const auto* learning = Slot::target_of<Learning>(word);
      view.state = learning->state();
      view.fit = learning->published;
      view.nodes = learning->nodes.get();
      if (learning->objective >= 0) view.objective = learning->objective;
      break;
    }
    case Slot::Kind::mixture:
      view.state = RowState::converged;
      view.fit = Slot::target_of<PackedMixture>(word);
      view.objective = view.fit->objective;
      break;
    case Slot::Kind::ribbons:
    case Slot::Kind::interpolated: {
      const auto* answer = Slot::target_of<RibbonAnswer>(word);
      view.state = Slot::kind_of(word) == Slot::Kind::interpolated ? RowState::absent
                   : answer->has_converged                         ? RowState::converged
                                                                   : RowState::open;
      view.ribbons = &answer->row;
      view.objective = answer->objective;
      view.paths = answer->paths;
      break;
    }
    case Slot::Kind::refusal:
      view.state = RowState::refused;
      break;
  }
  return view;
}

SliceId Rows::add_slice(const SliceDescription& description, bool has_index, std::uint32_t parts) {
  const SliceId id = slice_count();
  slices_.push_back(std::make_unique<Slice>(description, has_index, parts));
  by_key_.emplace(description.key, id);
  if (has_index) of_kind_[static_cast<std::size_t>(description.kind)].push_back(id);
  return id;
}

Row& Rows::add(Row row) {
  slot_of(row).row = size();
  return rows_.emplace_back(std::move(row));
}

std::size_t Rows::bytes_of(const Row& row) const {
  return sizeof(Row) + (row.learning ? row.learning->bytes() : slot_of(row).answer_bytes());
}

RowState Rows::state_of(const Row& row) const {
  if (row.learning) return row.learning->state();
  if (slot_of(row).is_refused()) return RowState::refused;
  const RibbonAnswer* answer = slot_of(row).ribbons();
  return answer != nullptr && !answer->has_converged ? RowState::open : RowState::converged;
}

float Rows::objective_of(const Row& row) const {
  if (row.learning) return row.learning->objective;
  return slot_of(row).is_refused() ? -1 : view_of(slot_of(row)).objective;
}

CachedRow Rows::cached_form(const Row& row) const {
  const Slot& slot = slot_of(row);
  if (const CachedRow* earlier = earlier_of(row)) return *earlier;
  CachedRow cached;
  cached.node = row.node;
  cached.generation = row.generation;
  cached.energy = row.energy;
  cached.count = row.taught();
  if (row.learning) {
    cached.learned = CachedDensity{{}, row.learning->sketch.bins()};
  } else if (const PackedMixture* fit = slot.mixture()) {
    cached.state = RowState::converged;
    cached.objective = fit->objective;
    cached.learned = CachedDensity{*fit, {}};
  } else if (const RibbonAnswer* answer = slot.ribbons()) {
    cached.state = RowState::converged;
    cached.objective = answer->objective;
    cached.learned = CachedSamples{std::make_shared<const RibbonRow>(answer->row)};
  } else {
    cached.learned = CachedSamples{};
  }
  return cached;
}

void Rows::show_learning(Row& row, bool converged, bool publishes) {
  Learning& learning = *row.learning;
  Slot& slot = slot_of(row);
  mixtures_.give_back(slot.mixture());  // not null if the row is reopened
  mixtures_.give_back(learning.published);
  learning.published = learning.has_fit && publishes ? mixtures_.put(learning.fit, learning.objective) : nullptr;
  if (!converged) {
    slot.set(&learning, Slot::Kind::learning);
    return;
  }
  slot.set(learning.published, Slot::Kind::mixture);
  row.set_count(learning.count);
  row.set_failed(learning.stop.failed());
  row.learning.reset();
}

void Rows::show_cached(Row& row, const CachedRow& cached, bool has_converged) {
  if (const CachedDensity* density = cached.density()) {
    slot_of(row).set(mixtures_.put(density->fit, cached.objective), Slot::Kind::mixture);
  } else {
    const auto paths = static_cast<std::uint32_t>(std::min<std::uint64_t>(cached.count, ~0u));
    slot_of(row).set(new RibbonAnswer{*cached.ribbons(), cached.objective, paths, has_converged}, Slot::Kind::ribbons);
  }
}

}  // namespace tress::inline v0_2::adaptive
