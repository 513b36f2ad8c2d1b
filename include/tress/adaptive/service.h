// The service that learns while it is asked. Start here.
//
//   Service service(options, target);
//   SliceId slice = *service.add_slice(description);
//   for (each pass) {
//     // any number of threads:
//     RowView row = service.look_up(slice, a, b);
//     if (row.state == converged) { use row.density(x) }     // weight 1; row.fit or row.knots
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

namespace tress::adaptive {

/// Thread-safety: look_up, fetch, observe, score, credit, hear: any thread, wait-free but for what is made on first
/// touch, the trace of an absent node and the form of a converged row. All else: one thread, while no reader is left.
/// Same calls between two publishes, in any order and from any number of threads: the same table, to the bit. A host
/// that breaks this is told by name with Options::check_passes, in PassReport::misuse.
class Service {
 public:
  /// `target` must outlive the service.
  Service(const Options& options, const Target& target);
  /// The same with slices of samples beside those of densities; both targets have one model name, a precondition.
  Service(const Options& options, const Target& target, const SampledTarget& samples);
  /// A service whose slices are all of samples.
  Service(const Options& options, const SampledTarget& samples);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  const Options& options() const;
  /// The name of its targets.
  std::string model_name() const;
  bool has_target(SliceKind kind) const;

  /// Registers a slice, or finds the one with that key. Between passes. Error if a slice of that key is there on other
  /// axes, with another blur or of the other kind, if it has no nodes, axes that do not ascend, a blur that is not
  /// above 0 or a number that is not finite, if the service has no target of its kind, and if a slice of densities
  /// tells more than its parameters; nothing is then changed. See refusals() for a slice that load() brought on other
  /// axes.
  Result<SliceId> add_slice(const SliceDescription& description);
  /// Without nodes if there is no such slice.
  const SliceDescription& slice(SliceId slice) const;
  std::uint32_t slice_count() const;

  /// Takes over the rows of a cache. Before the first pass, before or after add_slice. Slices without a user are kept
  /// for snapshot(). Rows whose stored bound exceeds epsilon come back open, with their parameters as the fit.
  /// Error if the model differs or a slice's axes differ from the description; nothing is then taken.
  /// Rows are checked against the target of this session: sketches at once, some converged rows when they are first
  /// asked, and then all of a slice that turns out not to fit. What no longer fits is learned anew (rows_reopened).
  /// An error of the source itself, a file that fails while it is read, is told too; what came before it is then taken.
  std::optional<Error> load(RowSource& rows);
  std::optional<Error> load(const TableSnapshot& image);
  /// Cached slices that a later add_slice() found on other axes: their rows are neither used nor saved back. A host
  /// that wants the whole cache refused instead adds its slices before load().
  const std::vector<Error>& refusals() const;
  /// The table row by row, to be saved. Between passes; no longer than until the table changes, or ends. Refused rows
  /// are stored as open. Any number at once.
  std::unique_ptr<RowSource> rows() const;
  /// rows() as data: equal tables give equal images. Takes ten times the memory of the table.
  TableSnapshot snapshot() const;

  /// All that the table is, to the last count, as bytes: given to restore(), a service of the same options, targets,
  /// slices and forms goes on from here as this one would, to the bit. Of use to one build of the program: what lasts
  /// is a cache. Between passes, after a publish(). Error before the first one, and of a learner whose rows cannot be
  /// told.
  Result<std::string> state() const;
  /// Takes over a state. In place of load(), before the first pass, after all slices and forms are added, in the same
  /// order. Error if these, the model or the learner differ, or the bytes are no state; nothing is then changed. Bytes
  /// that were made to deceive give a wrong table, never one that is out of its bounds.
  std::optional<Error> restore(const std::string& state);

  /// Registers a form of the rows of a slice. Between passes. What is made of a row is kept until the row changes, and
  /// counts under Options::memory_bytes; past it answers are made anew whenever they are asked. Owned by the service.
  /// decay_rates: those at which the form lets the attribute take light, exp(-rate attribute) of each ray (ours: the
  /// absorption of the three channels); PassReport::absorbed_objective is measured at them, nothing else depends on
  /// them. What is not finite and > 0 is left out.
  /// Error if there is no such slice.
  Result<const FormedRows*> add_form(SliceId slice, std::shared_ptr<const RowForm> form,
                                     const std::vector<float>& decay_rates = {});

  /// Learns the coarsest rows of slices of samples, so that the first pass is answered. Between passes, after all
  /// slices and caches are added; publish() does the same for slices that came later.
  void prepare();

  /// The row at node (a, b): indices into the slice's axes. Counts a query. A slice or a node that is not there is
  /// answered by g = 0 in any build, and told in PassReport::misuse. In a slice of samples what has not converged
  /// brings nothing to answer by: the host draws from its target itself.
  RowView look_up(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  /// The same in a form, where AnswerReader finds nothing. node: a * axis_b.size() + b.
  FormedLookup look_up(const FormedRows& rows, std::uint32_t node) const;
  /// As look_up, of a row that has converged or a node without a row; no answer for any other, which is then not
  /// counted as a query.
  FormedLookup fetch(const FormedRows& rows, std::uint32_t node) const;
  /// Tells how much of the picture's light a query of a row stood for: throughput of its path times the row's share of
  /// what is scattered there, >= 0, so that the sum over a pass, over the paths told to publish(), is the row's share
  /// of the picture. Any state. Rows are created in the order of it, and `picture_error` divides by it.
  /// events: how many queries this call stands for; rows of samples get paths by them.
  void credit(const RowView& row, float light, std::uint32_t events = 1) const;
  /// Tells an open row its g at azimuth x, whatever drew x. No effect on other states, nor in slices of samples.
  void observe(const RowView& row, float x, float g) const;
  /// Tells a node of samples one path that the host drew from the target itself, at a direction around the node, and
  /// showed in its picture: the exit by which it left, of weight 0 if it did not. No row is taught by it, and nothing
  /// that look_up() answers depends on it: it tells how far the rows are from the target. Any state. What is no exit
  /// (SampledTarget) is left out.
  void hear(const RowView& row, const SampledExit& exit) const;
  /// As observe, and scores the published fit: x must have been drawn from this row's own proposal, whose density
  /// there was q (1/rad).
  void score(const RowView& row, float x, float g, float q) const;

  /// On at first. Off: the table stays as it is, so that answers depend on nothing that was asked before; what has no
  /// converged row is traced at the node for good. observe() and score() have no effect, publish() only counts, and
  /// cached rows are not checked any more. Between passes.
  void set_learning(bool on);

  /// Ends a pass: creations, coverage, top-up, tests, refits, publication. Parallel inside (oneTBB), deterministic.
  /// paths: how many of the pass the light told to credit() came from.
  PassReport publish(std::uint64_t paths = 0);

  /// The row without counting a query. nodes is null unless the row is open or refused.
  RowView peek(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  /// What a node has carried of the light of the paths so far (credit()), a path: >= 0, of all nodes together about the
  /// hits of a path. Between passes. 0 of one that is not there.
  double light(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  /// How often a node was asked over all passes, modulo 2^32; without Options::check_passes but for the answers that
  /// AnswerReader found, and in slices of samples but for all answers in a form after the first. Between passes. 0 of
  /// one that is not there.
  std::uint32_t queries(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  /// How far the rows are from what was heard, all together. Between passes; takes some 0.1 us for each path that is
  /// kept.
  HeardTest test_by_heard() const;
  /// Called for each row whose fit or state changed, ascending (slice, node), at the end of publish(), when set
  /// (telemetry level rows). Between passes.
  void set_row_listener(std::function<void(const RowReport&)> listener);

 private:
  friend class AnswerReader;
  class Table;
  std::unique_ptr<Table> table_;
};

}  // namespace tress::adaptive
