// The service that learns while it is asked. Start here.
//
//   Service service(options, target);
//   SliceId slice = service.add_slice(description);
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

#include "tress/adaptive/cache.h"
#include "tress/adaptive/knot_density.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/target.h"
#include "tress/adaptive/telemetry.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::adaptive {

using SliceId = std::uint32_t;

/// What a reader sees of a row during one pass. Cheap to copy; valid until publish().
struct RowView {
  RowState state = RowState::absent;
  /// The published fit: for converged rows the answer, for open rows the proposal; null before the first fit, and for
  /// converged rows that are answered by knots. Converts to Mixture.
  const PackedMixture* fit = nullptr;
  /// The answer of a converged row that is a knot table; null for all others. A converged row has one of the two,
  /// whatever the learner of this session: a cache may bring both kinds.
  const KnotDensity* knots = nullptr;
  /// g, for every state but converged. Null for converged rows. Owned by the service, or by `kept` past the ceiling.
  const TracedNodes* nodes = nullptr;
  /// Index among the rows ever created, for observe() and score(); no_row if absent.
  std::uint32_t row = no_row;
  /// How far the fit is known to be from g, relative squared L2: the bound of the row's last test, once converged the
  /// stored bound; 1 before the first test and for absent rows. Finite, >= 0; above 1 where a fit is worse than none.
  float objective = 1;
  /// Holds nodes that no memo had room for.
  std::shared_ptr<const TracedNodes> kept;

  static constexpr std::uint32_t no_row = ~0u;

  /// What is published, of either kind: the answer of a converged row, the proposal of an open one; uniform if there is
  /// nothing yet. As Mixture::density() and so on.
  float density(float x) const { return knots ? knots->density(x) : fit ? fit->density(x) : 0; }
  float proposal_density(float x, float u_share) const {
    if (knots) return knots->proposal_density(x, u_share);
    return fit ? fit->proposal_density(x, u_share) : Mixture{}.proposal_density(x, u_share);
  }
  float sample(float u, float u_share) const {
    if (knots) return knots->sample(u, u_share);
    return fit ? fit->sample(u, u_share) : Mixture{}.sample(u, u_share);
  }
};

/// Thread-safety: look_up, count_converged, carry, observe, score: any thread, wait-free but for the trace of an absent
/// node's first touch. All else: one thread, while no reader is left. Same calls between two publishes, in any order
/// and from any number of threads: the same table, to the bit.
class Service {
 public:
  /// `target` must outlive the service.
  Service(const Options& options, const Target& target);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  const Options& options() const;

  /// Registers a slice, or finds the one with that key: its axes must agree, a precondition. Between passes.
  /// See refusals() for a slice that load() brought on other axes.
  SliceId add_slice(const SliceDescription& description);
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

  /// The row at node (a, b): indices into the slice's axes. Counts a query.
  RowView look_up(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  /// Counts queries of converged rows that the host answered from copies of their fits, without look_up(). A copy is
  /// good until the row is among last_changes(); where one of a slice has ceased to be converged, all rows of the slice
  /// are to be looked up again, because the service then checks those that are asked.
  void count_converged(std::uint32_t queries) const;
  /// Tells how much of the picture's light a query of the row at a node stood for: throughput of its path times the
  /// row's share of what is scattered there, >= 0, so that the sum over a pass, over the paths told to publish(), is
  /// the row's share of the picture. Any state. Rows are created in the order of it, and `picture_error` divides by it.
  void carry(SliceId slice, std::uint32_t node, float light) const;
  /// Tells an open row its g at azimuth x, whatever drew x. No effect on other states.
  void observe(const RowView& row, float x, float g) const;
  /// As observe, and scores the published fit: x must have been drawn from this row's own proposal, whose density
  /// there was q (1/rad).
  void score(const RowView& row, float x, float g, float q) const;

  /// On at first. Off: the table stays as it is, so that answers depend on nothing that was asked before; what has no
  /// converged row is traced at the node for good. observe() and score() have no effect, publish() only counts, and
  /// cached rows are not checked any more. Between passes.
  void set_learning(bool on);

  /// Ends a pass: creations, coverage, top-up, tests, refits, publication. Parallel inside (oneTBB), deterministic.
  /// paths: how many of the pass the light of carry() came from.
  PassReport publish(std::uint64_t paths = 0);
  /// Rows whose published fit or state changed in the last publish() or load, ascending (slice, node).
  struct RowChange {
    SliceId slice;
    std::uint32_t node;  ///< a * axis_b.size() + b
    RowState state;
  };
  const std::vector<RowChange>& last_changes() const;

  /// The row without counting a query. nodes is null unless the row is open or refused.
  RowView peek(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  /// Called by publish() for each changed row when set (telemetry level rows). Between passes.
  void set_row_listener(std::function<void(const RowReport&)> listener);

 private:
  class Table;
  std::unique_ptr<Table> table_;
};

}  // namespace tress::adaptive
