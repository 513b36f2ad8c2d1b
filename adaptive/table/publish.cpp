// The steps that end a pass: update of the rows that were queried, creation of rows, totals.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <ctime>
#include <exception>
#include <mutex>
#include <set>
#include <utility>

#include "table/table.h"

namespace tress::inline v0_2::adaptive {
namespace {

// Returns the smallest value that at least this share of the ascending values does not exceed.
double quantile(const std::vector<float>& ascending, double share) {
  if (ascending.empty()) return 0;
  const double rank = std::ceil(share * static_cast<double>(ascending.size()));
  return ascending[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

}  // namespace

void Service::Table::account(const RowOutcome& outcome, PassReport& report) {
  report.g_evaluations += outcome.g_evaluations;
  report.validation_draws += outcome.validation_draws;
  report.refits += outcome.refits;
  report.bad_fits += outcome.bad_fits;
  report.traces += outcome.traces;
  report.newly_converged += outcome.converged ? 1 : 0;
  if (outcome.absorbed_error >= 0) absorbed_errors_.add(outcome.absorbed_error);
}

void Service::Table::update_rows(PassReport& report) {
  std::vector<std::uint32_t> dirty;
  double weighted_samples = 0;
  std::uint64_t scored = 0;
  for (std::uint32_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    Slice& slice = rows_.slice(row.slice);
    if (!row.learning && slice.slots[row.node].mixture() == nullptr) continue;  // grow_samples() learns it
    const bool asked = slice.slots[row.node].queries.load(std::memory_order_relaxed) != slice.queries_before[row.node];
    const bool observed = row.learning && row.learning->observed.load(std::memory_order_relaxed) != 0;
    // The first cached row of a slice that is queried is audited, in addition to those chosen by key.
    const bool audits = row.audit == Audit::due || (row.audit == Audit::possible && !slice.audited);
    const RowState state = rows_.state_of(row);
    const bool is_audited = state == RowState::converged && audits && asked;
    if (is_audited) {
      row.audit = Audit::due;
      slice.audited = true;
    }
    if (state == RowState::open ? asked || observed : is_audited) dirty.push_back(i);
  }
  std::vector<RowOutcome> outcomes(dirty.size());
  std::vector<std::size_t> sizes(dirty.size());
  std::set<SliceId> misfitting;  // slices with a row that no longer fits
  in_parallel(dirty.size(), [&](std::size_t i) {
    Row& row = rows_[dirty[i]];
    sizes[i] = rows_.bytes_of(row);
    outcomes[i] = row.learning ? densities_.update(row, pass_) : densities_.audit(row, pass_);
  });
  for (std::size_t i = 0; i < dirty.size(); ++i) {
    Row& row = rows_[dirty[i]];
    RowOutcome& outcome = outcomes[i];
    if (row.learning) show(row, outcome);
    if (outcome.audit_failed) {
      if (outcome.nodes) start_anew(row, std::move(outcome.nodes), report);
      if (row.audit == Audit::none) {
        ++reopened_;
        changes_.push_back({row.slice, row.node});
      }
      misfitting.insert(row.slice);
      // Readers make them again, and so show which rows are in use.
      for (const std::uint32_t form : rows_.slice(row.slice).forms) forms_.drop(form);
    }
    bytes_ = bytes_ - sizes[i] + rows_.bytes_of(row);
    account(outcome, report);
    if (outcome.changed) changes_.push_back({row.slice, row.node});
    if (outcome.weights.count > 0 && outcome.weights.mean_square > 0) {
      const Moments& w = outcome.weights;
      weighted_samples += static_cast<double>(w.count) * w.mean * w.mean / w.mean_square;
      scored += w.count;
    }
  }
  for (Row& row : rows_) {
    if (row.audit == Audit::possible && misfitting.contains(row.slice)) row.audit = Audit::due;
  }
  if (scored > 0) report.effective_sample_size = weighted_samples / static_cast<double>(scored);
}

void Service::Table::start_anew(Row& row, std::unique_ptr<const TracedNodes> nodes, PassReport& report) {
  const std::size_t wanted =
      Learning::bytes_before_nodes(rows_.slice(row.slice).description.blur_rad, learner_bytes_) + nodes->bytes();
  if (bytes_ + wanted > options_.memory_bytes) {
    row.audit = Audit::due;  // it is audited again when memory has room
    return;
  }
  row.learning = std::make_unique<Learning>(std::move(nodes), *options_.learner, row.failed_tests());
  row.raise_generation();
  row.learning->created_pass = pass_;
  row.learning->queries_at_creation = rows_.slot_of(row).queries.load(std::memory_order_relaxed);
  RowOutcome again = densities_.open(row, nullptr, pass_);
  show(row, again);
  account(again, report);
}

bool Service::Table::goes_on(double done) {
  if (stopped_ || !options_.progress) return !stopped_;
  call_host("progress", [&] { stopped_ = !options_.progress(done); });
  return !stopped_;
}

bool Service::Table::takes(std::size_t size) {
  if (monitor_refused_ || bytes_ + size > options_.memory_bytes) return false;
  if (options_.memory_monitor) {
    call_host("memory_monitor",
              [&] { monitor_refused_ = !options_.memory_monitor(static_cast<std::int64_t>(size), false); });
    if (monitor_refused_) return false;
    monitored_bytes_ += size;
  }
  bytes_ += size;
  return true;
}

void Service::Table::report_memory(std::size_t bytes) {
  monitor_refused_ = false;
  const auto change = static_cast<std::int64_t>(bytes) - static_cast<std::int64_t>(monitored_bytes_);
  if (!options_.memory_monitor || change == 0) return;
  monitored_bytes_ = bytes;
  call_host("memory_monitor", [&] { options_.memory_monitor(change, true); });
}

void Service::Table::in_parallel(std::size_t count, const std::function<void(std::size_t)>& task) {
  if (!options_.parallel_for) {
    tbb::parallel_for(std::size_t{0}, count, task);
    return;
  }
  std::vector<std::atomic<bool>> is_taken(count);
  std::mutex mutex;
  std::exception_ptr thrown;
  const auto once = [&](std::size_t i) {
    if (i >= count || is_taken[i].exchange(true)) return;
    try {
      task(i);
    } catch (...) {
      const std::lock_guard lock(mutex);
      thrown = std::current_exception();
    }
  };
  if (count > 1) call_host("parallel_for", [&] { options_.parallel_for(count, once); });
  for (std::size_t i = 0; i < count; ++i) once(i);
  if (thrown) std::rethrow_exception(thrown);
}

void Service::Table::prepare() {
  if (!learns_ || discipline_.within_pass("prepare")) return;
  const std::clock_t start = std::clock();
  changes_.clear();
  stopped_ = false;
  grow_samples(between_passes_, 0);
  prepared_ = std::exchange(changes_, {});
  between_passes_.learning_cpu_seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

PassReport Service::Table::publish(std::uint64_t paths) {
  if (!discipline_.begin_publish()) return {};
  PassReport report = end_pass(paths);
  discipline_.end_publish();
  report.misuse = discipline_.take();
  log_events(report);
  return report;
}

void Service::Table::log_events(const PassReport& report) {
  if (report.misuse) log(report.misuse->message());
  if (report.at_ceiling && !ceiling_logged_) {
    ceiling_logged_ = true;
    log("the table is at its ceiling of " + std::to_string(options_.memory_bytes) + " bytes" +
        (options_.memory_monitor ? ", or its monitor refuses more" : "") +
        ": what has no row is traced at every query");
  }
  if (report.unusable > 0 && !unusable_logged_) {
    unusable_logged_ = true;
    log("a target of samples draws invalid samples (a weight that is negative or not finite, a place that is not "
        "finite, "
        "a part that is not there, or no mass): such rows, " +
        std::to_string(report.unusable) + " so far, are never learned");
  }
  if (report.rows_reopened > reopened_logged_) {
    log(std::to_string(report.rows_reopened - reopened_logged_) +
        " cached rows do not fit their target and are learned anew");
    reopened_logged_ = report.rows_reopened;
  }
}

PassReport Service::Table::end_pass(std::uint64_t paths) {
  const std::clock_t start = std::clock();
  PassReport report = between_passes_;
  between_passes_ = PassReport{};
  changes_ = std::exchange(prepared_, {});
  ++pass_;
  light_.paths += paths;
  report.traces += traces_.exchange(0, std::memory_order_relaxed);
  report.converged_queries += converged_queries_.take();
  report.answered_queries += answered_queries_.take();
  report.forms_made_anew += forms_made_anew_.take();
  report.queries += report.answered_queries;

  for (const std::unique_ptr<Slice>& slice : rows_.slices()) {
    const std::size_t room = options_.memory_bytes > bytes_ ? options_.memory_bytes - bytes_ : 0;
    report.newly_heard -= slice->heard.paths();
    bytes_ += slice->heard.take_in(slice->description.node_count(), room);
    report.newly_heard += slice->heard.paths();
    report.heard_paths += slice->heard.paths();
  }

  std::vector<Candidate> candidates;
  const std::uint64_t unindexed = unindexed_queries_.take();
  report.queries += unindexed;
  for (SliceId p = 0; p < rows_.slice_count(); ++p) {
    Slice& slice = rows_.slice(p);
    if (!slice.has_index()) continue;
    const bool has_samples = slice.description.kind == SliceKind::samples;
    for (std::uint32_t n = 0; n < slice.description.node_count(); ++n) {
      Slot& slot = slice.slots[n];
      // A node that only forms have asked for counts as queried too; of samples once, since paths follow from queries.
      const std::uint32_t unasked = has_samples ? 0 : slice.queries_before[n];
      const bool is_formed = slice.formed[n].exchange(0, std::memory_order_relaxed) != 0 &&
                             slot.queries.load(std::memory_order_relaxed) == unasked;
      if (is_formed) slot.queries.store(unasked + 1, std::memory_order_relaxed);
      const std::uint32_t in_all = slot.queries.load(std::memory_order_relaxed);
      report.rows_queried += in_all != 0 ? 1 : 0;
      const std::uint32_t queries = in_all - slice.queries_before[n] - (is_formed ? 1 : 0);
      report.queries += queries;
      if (slot.row != Slot::no_row || slot.interpolated() != nullptr) {
        const bool converged = slot.row != Slot::no_row && rows_.state_of(rows_[slot.row]) == RowState::converged;
        if (converged) report.converged_queries += queries;
        if (slot.has_answer() || slot.interpolated() != nullptr) report.answered_queries += queries;
        report.rows_coarse += slot.row == Slot::no_row ? 1 : 0;
      } else if (learns_ && !has_samples && in_all >= options_.queries_before_creation && in_all > 0) {
        candidates.push_back({p, n, in_all, slice.light_at(n), slot.take_memo()});
      } else {
        slot.take_memo();
      }
    }
  }
  memo_bytes_.store(0, std::memory_order_relaxed);
  light_.queried = report.rows_queried;

  stopped_ = false;
  report_memory();  // what readers have made
  if (learns_ && goes_on(0)) update_rows(report);

  std::ranges::sort(candidates, [&](const Candidate& x, const Candidate& y) {
    if (x.light != y.light) return x.light > y.light;
    if (x.queries != y.queries) return x.queries > y.queries;
    if (x.slice == y.slice) return x.node < y.node;
    return rows_.slice(x.slice).description.key < rows_.slice(y.slice).description.key;
  });
  report.at_ceiling = !admit(candidates, report) || unindexed > 0;
  if (learns_) grow_samples(report, candidates.empty() ? 0 : share_of_densities);
  make_room();

  for (const std::unique_ptr<Slice>& slice : rows_.slices()) {
    if (!slice->has_index()) continue;
    for (std::uint32_t n = 0; n < slice->description.node_count(); ++n) {
      slice->queries_before[n] = slice->slots[n].queries.load(std::memory_order_relaxed);
    }
  }
  report_memory();
  fill_totals(report);
  report.cancelled = stopped_;
  announce();
  report.learning_cpu_seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  return report;
}

bool Service::Table::publish_pays(double share) const {
  if (!learns_) return false;
  const bool has_room = bytes_ < options_.memory_bytes;
  std::uint64_t queries = answered_queries_.sum() + unindexed_queries_.sum(), waiting = 0;
  for (const SliceId id : rows_.of_kind(SliceKind::samples)) {
    if (sampled_.pays(id, share)) return true;
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

void Service::Table::fill_totals(PassReport& report) const {
  std::vector<float> objectives;
  for (const Row& row : rows_) {
    const Slot& slot = rows_.slot_of(row);
    const SliceDescription& slice = rows_.slice(row.slice).description;
    const RowState state = rows_.state_of(row);
    if (slot.has_answer() && light_.paths > 0)
      report.bias_bound +=
          light_.bias_of(slice, rows_.slice(row.slice).light_at(row.node), row.energy, rows_.objective_of(row));
    report.rows_open += state == RowState::open ? 1 : 0;
    report.rows_refused += state == RowState::refused ? 1 : 0;
    report.rows_converged += state == RowState::converged ? 1 : 0;
    if (const PackedMixture* fit = slot.mixture()) ++report.components[fit->component_count];
    report.ribbons += slot.ribbons() != nullptr ? 1 : 0;
    report.unusable += slot.is_refused() ? 1 : 0;
    if (const RibbonAnswer* answer = slot.ribbons())
      report.rows_at_most_paths += !answer->has_converged && answer->paths >= sampled_.most_paths() ? 1 : 0;
    if (const float objective = rows_.objective_of(row); objective >= 0) objectives.push_back(objective);
  }
  report.rows_reopened = reopened_;
  report.bytes = bytes_ + formed_bytes_;
  std::ranges::sort(objectives);
  report.objective_p50 = quantile(objectives, 0.50);
  report.objective_p90 = quantile(objectives, 0.90);
  report.objective_p99 = quantile(objectives, 0.99);
  report.objective_max = quantile(objectives, 1.00);
  report.absorbed_objective = {absorbed_errors_.count(), absorbed_errors_.quantile(0.50),
                               absorbed_errors_.quantile(0.90), absorbed_errors_.quantile(1.00)};
}

void Service::Table::announce() {
  std::ranges::sort(changes_, [](const RowChange& x, const RowChange& y) {
    return x.slice != y.slice ? x.slice < y.slice : x.node < y.node;
  });
  if (!listener_) return;
  for (const RowChange& change : changes_) {
    const Slice& slice = rows_.slice(change.slice);
    const Slot& slot = slice.slots[change.node];
    const Row& row = rows_[slot.row];
    RowReport report;
    report.slice = slice.description.key;
    report.node = change.node;
    report.state = rows_.state_of(row);
    report.count = row.taught();
    report.failed_tests = row.failed_tests();
    report.objective = rows_.objective_of(row);
    report.light = light_.share(slice.light_at(change.node));
    const RowView view = view_of(slot);
    if (view.fit != nullptr) report.components = view.fit->component_count;
    if (view.ribbons != nullptr) report.ribbons = view.ribbons->parts();
    call_host("row listener", [&] { listener_(report); });
  }
}

}  // namespace tress::inline v0_2::adaptive
