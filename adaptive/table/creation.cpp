// Creation of rows: which nodes get a row, in which order, and what a new row starts with.
#include <algorithm>

#include "table/row_stream.h"
#include "table/table.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::size_t batch = 256;         // candidates traced between two checks of memory
constexpr std::uint32_t audit_one_in = 8;  // one converged row of a cache in this many is audited, chosen by key

}  // namespace

bool Service::Table::answers(SliceId slice, const CachedRow& cached) const {
  if (cached.state != RowState::converged) return false;
  if (cached.ribbons() != nullptr) return true;
  const double objective = cached.objective;
  return objective <= options_.epsilon ||
         (light_.paths > 0 && objective <= light_.epsilon_of(rows_.slice(slice), cached.node, cached.energy));
}

bool Service::Table::needs_nodes(const Candidate& candidate) const {
  const auto& stored = rows_.slice(candidate.slice).stored;
  const auto found = stored.find(candidate.node);
  return found == stored.end() || !answers(candidate.slice, found->second);
}

std::size_t Service::Table::bytes_needed(const Candidate& candidate) const {
  const Slice& slice = rows_.slice(candidate.slice);
  const auto found = slice.stored.find(candidate.node);
  if (!needs_nodes(candidate)) {
    const CachedDensity* density = found->second.density();
    return sizeof(Row) +
           (density != nullptr ? PackedMixture::bytes_of(density->fit.component_count) : sizeof(RibbonAnswer));
  }
  const bool keeps_earlier = found != slice.stored.end() && found->second.state == RowState::converged;
  return sizeof(Row) + Learning::bytes_before_nodes(slice.description.blur_rad, learner_bytes_) +
         (keeps_earlier ? sizeof(CachedRow) : 0) + (candidate.nodes ? candidate.nodes->bytes() : sizeof(TracedNodes));
}

RowOutcome Service::Table::settle(Row& row) const {
  const Slice& slice = rows_.slice(row.slice);
  const auto found = slice.stored.find(row.node);
  const CachedRow* cached = found == slice.stored.end() ? nullptr : &found->second;
  if (cached != nullptr) row.generation = cached->generation;
  if (cached == nullptr || !answers(row.slice, *cached)) return densities_.open(row, cached, pass_);
  row.set_count(cached->count);
  row.energy = cached->energy;
  const bool is_chosen =
      row_stream(options_.seed, slice.description.key, row.node, pass_).next_bits() % audit_one_in == 0;
  row.audit = is_chosen ? Audit::due : Audit::possible;
  RowOutcome outcome;
  outcome.cached = cached;
  return outcome;
}

bool Service::Table::admit(std::vector<Candidate>& candidates, PassReport& report) {
  bool room = true;
  for (std::size_t start = 0; start < candidates.size() && room; start += batch) {
    if (!goes_on(share_of_densities * static_cast<double>(start) / static_cast<double>(candidates.size()))) break;
    const std::size_t end = std::min(start + batch, candidates.size());
    // Stops before tracing rows that would not fit in memory even without rays.
    std::size_t traced_end = start;
    for (std::size_t least = bytes_; traced_end < end; ++traced_end) {
      least += bytes_needed(candidates[traced_end]);
      if (least > options_.memory_bytes) break;
    }
    room = traced_end == end;
    std::atomic<std::uint64_t> traces{0};
    in_parallel(traced_end - start, [&](std::size_t i) {
      Candidate& one = candidates[start + i];
      if (!one.nodes && needs_nodes(one)) {
        one.nodes = trace(one.slice, one.node);
        traces.fetch_add(1, std::memory_order_relaxed);
      }
    });
    const std::size_t first = rows_.size();
    std::vector<std::size_t> sizes;
    for (std::size_t i = start; i < traced_end; ++i) {
      Candidate& one = candidates[i];
      if (!one.nodes && needs_nodes(one)) continue;  // the target could not trace them
      const std::size_t size = bytes_needed(one);
      if (!takes(size)) {
        room = false;
        break;
      }
      sizes.push_back(size);
      Row& row = rows_.add({one.slice, one.node});
      if (needs_nodes(one)) {
        row.learning = std::make_unique<Learning>(std::move(one.nodes), *options_.learner);
        row.learning->created_pass = pass_;
        row.learning->queries_at_creation = one.queries;
      }
    }
    std::vector<RowOutcome> outcomes(rows_.size() - first);
    in_parallel(outcomes.size(), [&](std::size_t i) { outcomes[i] = settle(rows_[first + i]); });
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      Row& row = rows_[first + i];
      show(row, outcomes[i]);
      rows_.slice(row.slice).stored.erase(row.node);
      bytes_ = bytes_ - sizes[i] + rows_.bytes_of(row);  // settle() may have ended its learning
      changes_.push_back({row.slice, row.node});
      account(outcomes[i], report);
      reopened_ += outcomes[i].reopened ? 1 : 0;
    }
    report.creations += outcomes.size();
    report.traces += traces.load(std::memory_order_relaxed);
  }
  return room;
}

}  // namespace tress::inline v0_2::adaptive
