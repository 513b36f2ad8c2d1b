// The service that learns while it answers queries. Start here; query.h has the loop below as one call.
//
//   Service service(options, target);
//   SliceId slice = *service.add_slice(description);
//   for (each pass) {
//     // any number of threads:
//     RowView row = service.look_up(slice, a, b);
//     if (row.state == converged) { use row.density(x) }     // weight 1
//     else { g = row.nodes->density(x); service.observe(row, x, g); or service.score(row, x, g, q); }
//     // one thread, no reader left:
//     PassReport report = service.publish();
//   }
//   merge_into_cache(path, *service.rows());
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tress/adaptive/cache.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/row_form.h"
#include "tress/adaptive/row_view.h"
#include "tress/adaptive/sampled_target.h"
#include "tress/adaptive/target.h"
#include "tress/adaptive/telemetry.h"
#include "tress/base/error.h"

namespace tress::inline v0_2::adaptive {

/// Thread-safety. look_up, fetch, observe, score, credit, hear: any thread. They are wait-free, except for what is made
/// on first touch, the trace of an absent node and the form of a converged row. All other functions: one thread, while
/// there is no reader. The same calls between two publishes, in any order and from any number of threads, give the same
/// table to the bit. With Options::check_passes, PassReport::misuse names a call of the host that breaks this.
class Service {
 public:
  /// `target` must outlive the service.
  Service(const Options& options, const Target& target);
  /// The same, with slices of samples beside those of densities. Precondition: both targets have one model name.
  Service(const Options& options, const Target& target, const SampledTarget& samples);
  /// A service whose slices are all of samples.
  Service(const Options& options, const SampledTarget& samples);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  const Options& options() const;
  /// The model name of its targets.
  std::string model_name() const;
  bool has_target(SliceKind kind) const;

  /// Registers a slice, or finds the one with that key. Call it between passes. Returns an error and
  /// changes nothing in these cases: a slice of that key exists with other axes, another blur or the other kind; the
  /// slice has no nodes, axes that do not ascend, a blur that is not above 0 or a number that is not finite; the
  /// service has no target of its kind; a slice of densities uses more parameters than it may. See refusals() for a
  /// slice that load() brought with other axes.
  Result<SliceId> add_slice(const SliceDescription& description);
  /// A description without nodes if there is no such slice.
  const SliceDescription& slice(SliceId slice) const;
  std::uint32_t slice_count() const;

  /// Takes over the rows of a cache. Before the first pass, before or after add_slice. Slices that are never added are
  /// kept for snapshot(). Rows whose stored bound exceeds epsilon become open, with their parameters as the fit. Error
  /// if the model differs or a slice's axes differ from the description; nothing is then taken.
  /// Rows are checked against the target of this session: sketches at once, some converged rows when they are first
  /// looked up, and then all rows of a slice of which one does not fit. Rows that no longer fit are learned anew
  /// (rows_reopened). An error of the source itself (a file that fails while it is read) is returned too; the rows
  /// before it are then taken.
  std::optional<Error> load(RowSource& rows);
  std::optional<Error> load(const TableSnapshot& image);
  /// Cached slices that a later add_slice() found to have other axes: their rows are neither used nor saved back. A
  /// host that wants the whole cache refused instead must add its slices before load().
  const std::vector<Error>& refusals() const;
  /// The table row by row, to be saved. Between passes; valid until the table changes or ends. Refused rows are stored
  /// as open. Any number may exist at once.
  std::unique_ptr<RowSource> rows() const;
  /// The rows as data: equal tables give equal snapshots. Takes ten times the memory of the table.
  TableSnapshot snapshot() const;

  /// The whole state of the table as bytes. A service with the same options, targets, slices and forms that gets it by
  /// restore() continues from here as this one would, to the bit. Only the same build of the program can read it; use a
  /// cache to keep rows. Between passes, after a publish(). Error before the first publish(), and with a learner whose
  /// rows cannot be saved.
  Result<std::string> state() const;
  /// Takes over a state, instead of load(). Call it before the first pass, after all slices and forms were added, in
  /// the same order. Error if these, the model or the learner differ, or the bytes are no valid state; nothing is then
  /// changed. Forged bytes can give a wrong table, but never one that is out of its bounds.
  std::optional<Error> restore(const std::string& state);

  /// Registers a form of the rows of a slice. Between passes. The form of a row is kept until the row changes, and
  /// counts under Options::memory_bytes; beyond that limit, answers are made anew at every query. Owned by the service.
  /// decay_rates: the rates at which the form absorbs, exp(-rate attribute) of each ray (hair: the absorption of the
  /// three channels). PassReport::absorbed_objective is measured at them; nothing else depends on them. Rates that are
  /// not finite and > 0 are left out. Error if there is no such slice.
  Result<const FormedRows*> add_form(SliceId slice, std::shared_ptr<const RowForm> form,
                                     const std::vector<float>& decay_rates = {});

  /// Learns the coarsest rows of slices of samples, so that the first pass gets answers. Between passes, after all
  /// slices and caches were added; publish() does the same for slices that were added later.
  void prepare();

  /// Looks up the row at node (a, b), indices into the slice's axes, and counts a query. For a slice or node that does
  /// not exist the answer is g = 0 in any build, and PassReport::misuse reports it. In a slice of samples, a row that
  /// has not converged has no g: the host draws from its target itself.
  RowView look_up(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  /// The same in a form, for nodes where AnswerReader finds nothing. node: a * axis_b.size() + b.
  FormedLookup look_up(const FormedRows& rows, std::uint32_t node) const;
  /// Does what look_up does for a row that has converged or a node without a row. For any other it returns no answer
  /// and counts no query.
  FormedLookup fetch(const FormedRows& rows, std::uint32_t node) const;
  /// Reports how much of the picture's light a query of a row stood for: the throughput of its path times the row's
  /// share of what is scattered there, >= 0. The sum over a pass, divided by the paths passed to publish(), is then the
  /// row's share of the picture. Any state. Rows are created in this order, and `picture_error` is divided among them
  /// by it. events: the number of queries that this call stands for; it decides how many paths rows of samples get.
  void credit(const RowView& row, float light, std::uint32_t events = 1) const;
  /// Passes to an open row its g at azimuth x, wherever x comes from. No effect on rows in other states, or in slices
  /// of samples.
  void observe(const RowView& row, float x, float g) const;
  /// Reports one path to a node of samples: the host drew it from the target itself, at a direction around the node,
  /// and used it in its picture. `exit` is where the path left, with weight 0 if it did not. It measures how far the
  /// rows are from the target; rows learn from it only if Options::own_paths is off. Any state. Invalid exits
  /// (SampledTarget) are left out.
  void hear(const RowView& row, const SampledExit& exit) const;
  /// Does what observe does, and scores the published fit: x must have been drawn from this row's own proposal, whose
  /// density there was q (1/rad).
  void score(const RowView& row, float x, float g, float q) const;

  /// Switches learning, which is on at first. While it is off the table does not change, so answers do not depend on
  /// earlier queries, and nodes without a converged row are traced for good. observe() and score() have no effect,
  /// publish() only counts, and cached rows are no longer checked. Between passes.
  void set_learning(bool on);

  /// Ends a pass: creations, coverage, top-up, tests, refits, publication. Parallel inside (oneTBB), deterministic.
  /// paths: the number of paths of the pass whose light was passed to credit().
  PassReport publish(std::uint64_t paths = 0);

  /// Whether a publish() now would make answers better: it would create, test or refine rows that had at least `share`
  /// of this pass's queries (for samples, of all events so far), or learn coarse rows. It reads every node once. Any
  /// thread, during a pass; while others query, the answer depends on how far they are.
  bool publish_pays(double share = 0.01) const;

  /// The row, without counting a query. nodes is null unless the row is open or refused.
  RowView peek(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  /// The light that a node has carried (credit()), as a mean over the paths so far: >= 0; the sum over all nodes is
  /// about the number of hits of a path. Between passes. 0 for a node that does not exist.
  double light(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  /// The number of queries of a node over all passes, modulo 2^32. Without Options::check_passes it misses answers that
  /// AnswerReader found, and in slices of samples all answers in a form after the first. Between passes. 0 for a node
  /// that does not exist.
  std::uint32_t queries(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  /// The error of all rows together against the paths passed to hear(). Between passes; takes some 0.1 us for each path
  /// that is kept.
  HeardTest test_by_heard() const;
  /// Sets a function that is called at the end of publish() for each row whose fit or state changed, in ascending
  /// (slice, node) (telemetry level rows). Between passes.
  void set_row_listener(std::function<void(const RowReport&)> listener);

 private:
  friend class AnswerReader;
  class Table;
  class MonitoredCall;
  std::unique_ptr<Table> table_;
};

}  // namespace tress::inline v0_2::adaptive
