// One row of the table: its published fit, its learner and the state of its tests.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "fit/row_learner.h"
#include "observations/fixed_moments.h"
#include "observations/sketch.h"
#include "table/slice.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::inline v0_2::adaptive {

/// Whether a converged row of a cache must still be checked against the target of this session.
enum class Audit : std::uint8_t {
  none,      ///< learned in this session, or checked
  possible,  ///< from a cache; checked if its slice turns out not to fit
  due,       ///< from a cache; checked when it is next queried
};

/// What an open or refused row has beyond its Row. During a pass only `sketch`, `observed`, `weights` and the scores of
/// `stop` are written, by atomics whose result does not depend on the order.
struct Learning {
  /// failed: tests that the row has failed before.
  Learning(std::unique_ptr<const TracedNodes> traced, const Learner& method, std::uint32_t failed = 0)
      : Learning(traced->blur_rad(), method, failed) {
    nodes = std::move(traced);
  }
  /// The nodes are still to be set.
  Learning(float blur_rad, const Learner& method, std::uint32_t failed = 0)
      : sketch(Sketch::bin_count(blur_rad)), learner(method.make()), stop(failed) {}

  std::unique_ptr<const TracedNodes> nodes;
  Sketch sketch;
  std::unique_ptr<RowLearner> learner;
  StopTest stop;

  Mixture fit;  ///< the proposal
  bool has_fit = false;
  float objective = -1;     ///< bound of the last test; negative before the first
  std::uint64_t count = 0;  ///< g evaluations so far, without those of the running pass
  /// `fit` as readers see it, in the table's store; null before the first fit.
  const PackedMixture* published = nullptr;
  /// The cached row, while a row that converged at a larger epsilon is open again; snapshots save it until then.
  std::unique_ptr<const CachedRow> earlier;

  std::uint32_t created_pass = 0;  ///< number of the publish() that made it; 0 if it came from a cache
  std::uint32_t queries_at_creation = 0;

  std::atomic<std::uint64_t> observed{0};  ///< g evaluations that the host has passed in since the last publish()
  FixedMoments<14> weights;                ///< moments of g/(q energy) since the last publish()

  /// learner_bytes: RowLearner::bytes() of the method. The published fit counts at its largest size.
  static std::size_t bytes_before_nodes(float blur_rad, std::size_t learner_bytes) {
    return sizeof(Learning) + learner_bytes + sizeof(std::uint64_t) * Sketch::bin_count(blur_rad) +
           PackedMixture::bytes_of(Mixture::max_components);
  }
  std::size_t bytes() const {
    return bytes_before_nodes(nodes->blur_rad(), learner->bytes()) + nodes->bytes() + (earlier ? sizeof(CachedRow) : 0);
  }

  RowState state() const { return stop.verdict() == StopTest::Verdict::refused ? RowState::refused : RowState::open; }

  /// Scores the published fit at x, where the density is g and which was drawn with density q (1/rad). Thread-safe.
  void add_score(float x, float g, float q) {
    stop.add(static_cast<double>(g) - fit.density(x), q, nodes->variation());
    if (nodes->energy() > 0) weights.add(static_cast<double>(g) / (static_cast<double>(q) * nodes->energy()));
  }
};

/// Changes only between passes, one thread per row. Its Slot has its answer, and so its state.
struct Row {
  Row(std::uint32_t slice_index, std::uint32_t node_index) : slice(slice_index), node(node_index) {}

  std::uint32_t slice;
  std::uint32_t node;
  float energy = 0;              ///< mass of g
  std::uint32_t generation = 0;  ///< raised by each reopening, raise_generation()
  // The next two hold for a row that no longer learns; a row that learns has them in `learning`.
  std::uint64_t count : 48 = 0;  ///< g evaluations from which it was learned
  std::uint64_t failed : 8 = 0;  ///< tests failed in all; 255 stands for 255 or more
  Audit audit = Audit::none;
  std::unique_ptr<Learning> learning;  ///< null once converged, and in slices of samples

  std::uint64_t taught() const { return learning ? learning->count : count; }
  std::uint32_t failed_tests() const { return learning ? learning->stop.failed() : failed; }
  void set_count(std::uint64_t n) { count = std::min(n, (std::uint64_t{1} << 48) - 1); }
  /// Stops at the largest number: after a wrap to 0, a merge would take the row for older than the one it replaces.
  void raise_generation() { generation += generation < ~0u ? 1 : 0; }
  void set_failed(std::uint32_t n) { failed = std::min(n, 255u); }
};
static_assert(sizeof(Row) <= 32);

/// The cached row from which an open row started: it had converged, at a larger epsilon. Null for other rows.
inline const CachedRow* earlier_of(const Row& row) { return row.learning ? row.learning->earlier.get() : nullptr; }

}  // namespace tress::inline v0_2::adaptive
