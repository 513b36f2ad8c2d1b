// The end of a pass for rows of samples: coarse rows grow first, then finer ones.
#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "convergence/held_out_test.h"
#include "fit/learn_stage.h"
#include "table/table.h"

namespace tress::inline v0_2::adaptive {
std::vector<std::uint32_t> Service::Table::audit_slice(SliceId id, PassReport& report, std::vector<bool>& moved) {
  Slice& slice = rows_.slice(id);
  std::vector<std::uint32_t> due, others;
  bool asks = false;
  for (std::uint32_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    if (row.slice != id || row.audit == Audit::none || rows_.slot_of(row).ribbons() == nullptr) continue;
    (row.audit == Audit::due ? due : others).push_back(i);
  }
  for (std::uint32_t n = 0; n < slice.description.node_count() && !asks; ++n)
    asks = sampled_.asked_of_coarse(slice, n) > 0;
  if (!asks || (due.empty() && others.empty())) return {};
  if (due.empty() && !slice.audited) {  // the first row is audited for its slice
    due.push_back(others.front());
    others.erase(others.begin());
  }
  slice.audited = true;
  std::vector<std::uint32_t> again;
  for (const std::vector<std::uint32_t>* group : {&due, &others}) {
    if (group == &others && again.empty()) break;  // the slice fits: the rest need no audit
    std::vector<RowOutcome> outcomes(group->size());
    in_parallel(group->size(), [&](std::size_t i) { outcomes[i] = sampled_.audit(rows_[(*group)[i]], pass_); });
    for (std::size_t i = 0; i < group->size(); ++i) {
      Row& row = rows_[(*group)[i]];
      row.audit = Audit::none;
      account(outcomes[i], report);
      if (!outcomes[i].audit_failed) continue;
      row.raise_generation();
      ++reopened_;
      again.resize(moved.size(), 0);
      again[row.node] = rows_.slot_of(row).ribbons()->paths;
      rows_.clear(row);
      moved[row.node] = true;
    }
  }
  return again;
}

void Service::Table::grow_samples(PassReport& report, double done) {
  std::map<const Slice*, std::vector<bool>> moved_of;
  for (const SliceId id : rows_.of_kind(SliceKind::samples)) {
    Slice& slice = rows_.slice(id);
    const auto done_with = [&](double of_slice) {
      return done + (1 - done) * (static_cast<double>(id) + of_slice) / static_cast<double>(rows_.slice_count());
    };
    bool grows = goes_on(done_with(0));
    std::vector<bool>& moved = moved_of[&slice];
    moved.resize(slice.description.node_count(), false);
    if (slice.coarse_rows != nullptr) {  // an earlier slice, which has grown
      const std::vector<bool>& theirs = moved_of.at(slice.coarse_rows);
      for (std::uint32_t n = 0; n < moved.size(); ++n) moved[n] = theirs[n] && slice.grid.has(n);
    }
    // A row that does not fit its target starts again, with as many paths as it had.
    const std::vector<std::uint32_t> again = grows ? audit_slice(id, report, moved) : std::vector<std::uint32_t>();
    if (!slice.grid.empty()) {
      if (grows) grow_rows(id, true, again, moved, report);
      forget_interpolated(id, moved);
      // Rows that start again may have no answer yet, so such a slice is not left half-way.
      if (again.empty()) grows = goes_on(done_with(0.5));
    }
    if (grows) grow_rows(id, false, again, moved, report);
    forget_interpolated(id, moved);
  }
}

void Service::Table::grow_rows(SliceId id, bool is_coarse, const std::vector<std::uint32_t>& again,
                               std::vector<bool>& moved, PassReport& report) {
  Slice& slice = rows_.slice(id);
  std::vector<SampleLife::Growth> growing = sampled_.growths(id, is_coarse, again);
  // New rows need room; existing rows keep theirs.
  std::erase_if(growing, [&](const SampleLife::Growth& one) {
    if (slice.slots[one.node].row != Slot::no_row) return false;
    const std::size_t size = sizeof(Row) + sizeof(RibbonAnswer);
    if (!takes(size)) {
      report.at_ceiling = true;
      return true;
    }
    let_go_interpolated(slice, one.node);
    Row& row = rows_.add({id, one.node});
    ++report.creations;
    const auto stored = slice.stored.find(one.node);
    if (stored == slice.stored.end()) return false;
    const bool answers = stored->second.state == RowState::converged;  // a cached row that waited for room
    if (answers) {
      RowOutcome outcome = settle(row);
      show(row, outcome);
    }
    slice.stored.erase(stored);
    if (!answers) return false;
    moved[one.node] = true;
    changes_.push_back({id, row.node});
    return slice.slots[one.node].ribbons()->paths >= one.paths;
  });
  std::vector<RowOutcome> outcomes(growing.size());
  in_parallel(growing.size(), [&](std::size_t i) {
    const SampleLife::Growth& one = growing[i];
    const Row& row = rows_[slice.slots[one.node].row];
    SampledAnswer parent;
    if (slice.slots[one.node].ribbons() == nullptr) parent = answer_of(slice, one.node);
    outcomes[i] = sampled_.learn(row, one.paths, is_coarse, parent.get());
  });
  for (std::size_t i = 0; i < growing.size(); ++i) {
    Row& row = rows_[slice.slots[growing[i].node].row];
    RowOutcome& outcome = outcomes[i];
    const std::size_t before = rows_.bytes_of(row);
    if (outcome.ribbons) {
      row.energy = outcome.ribbons->row.total_mass();
      row.set_count(outcome.ribbons->paths);
      row.set_failed(row.failed_tests() + outcome.failed);
    }
    const bool was_there = rows_.slot_of(row).has_answer();
    show(row, outcome);
    bytes_ = bytes_ + rows_.bytes_of(row) - (was_there ? before : sizeof(Row) + sizeof(RibbonAnswer));
    moved[row.node] = true;
    changes_.push_back({id, row.node});
    account(outcome, report);
  }
}

}  // namespace tress::inline v0_2::adaptive
