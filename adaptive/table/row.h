// One row of the table: what is published of it, what teaches it, and how its tests stand.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "learner/row_learner.h"
#include "sketch/fixed_moments.h"
#include "sketch/sketch.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/knot_table.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::adaptive {

/// Whether a row that came converged from a cache is still to be checked against the target of this session.
enum class Audit : std::uint8_t {
  none,      ///< learned in this session, or checked
  possible,  ///< from a cache; checked if its page turns out not to fit
  due,       ///< from a cache; checked when it is next asked
};

/// What an open or refused row needs beside what is published of it. During a pass only `sketch`, `observed`, `weights`
/// and the scores of `stop` are written, all by atomics whose result does not depend on the order.
struct Learning {
  /// failed: tests that the row has failed before.
  Learning(std::unique_ptr<const TracedNodes> traced, Learner method, std::uint32_t failed = 0)
      : nodes(std::move(traced)),
        sketch(Sketch::bin_count(nodes->blur_rad())),
        learner(make_row_learner(method)),
        stop(failed) {}

  std::unique_ptr<const TracedNodes> nodes;
  Sketch sketch;
  std::unique_ptr<RowLearner> learner;
  StopTest stop;
  /// Set while a row that a cache held as converged, at a larger epsilon, is open: what a snapshot goes on saving.
  std::unique_ptr<const CachedRow> earlier;

  std::uint32_t born_pass = 0;  ///< number of the publish() that made it; 0 if a cache did
  std::uint32_t touches_at_birth = 0;

  std::atomic<std::uint64_t> observed{0};  ///< g evaluations told by the host since the last publish()
  FixedMoments<14> weights;                ///< of g/(q energy), since the last publish()

  /// learner_bytes: RowLearner::bytes() of the method.
  static std::size_t bytes_before_nodes(float blur_rad, std::size_t learner_bytes) {
    return sizeof(Learning) + learner_bytes + sizeof(std::uint64_t) * Sketch::bin_count(blur_rad);
  }
  std::size_t bytes() const {
    return bytes_before_nodes(nodes->blur_rad(), learner->bytes()) + nodes->bytes() +
           (earlier ? bytes_of(*earlier) : 0);
  }
  /// Of a cached row that is kept.
  static std::size_t bytes_of(const CachedRow& row) { return sizeof(CachedRow) + row.knots.bytes(); }
};

/// Changes between passes, by one thread a row.
struct Row {
  Row(std::uint32_t page_index, std::uint32_t node_index) : page(page_index), node(node_index) {}

  std::uint32_t page;
  std::uint32_t node;
  RowState state = RowState::open;
  bool has_fit = false;
  Audit audit = Audit::none;
  float objective = -1;  ///< bound of the last test, negative before the first; once converged, the stored bound
  float energy = 0;      ///< mass of g
  std::uint32_t generation = 0;            ///< raised by each reopening
  std::uint32_t failed = 0;                ///< tests failed, in all
  std::uint64_t count = 0;                 ///< g evaluations that taught it, those of the running pass not yet in
  std::unique_ptr<Learning> learning;      ///< null once converged
  Mixture fit;                             ///< published; the answer of a converged row, the proposal of an open one
  std::unique_ptr<const KnotTable> knots;  ///< the answer of a converged row in place of `fit`; null for all others

  std::size_t bytes() const {
    return sizeof(Row) + (knots ? bytes_of(*knots) : 0) + (learning ? learning->bytes() : 0);
  }
  static std::size_t bytes_of(const KnotTable& table) { return sizeof(KnotTable) + table.bytes(); }

  // What is published, of either kind.
  float density(float x) const { return knots ? knots->density(x) : fit.density(x); }
  float proposal_density(float x, float share) const {
    return knots ? knots->proposal_density(x, share) : fit.proposal_density(x, share);
  }
  float sample(float u, float share) const { return knots ? knots->sample(u, share) : fit.sample(u, share); }

  /// Scores the published fit at x, whose g was drawn with density q (1/rad). Open rows; any thread.
  void add_score(float x, float g, float q) {
    learning->stop.add(static_cast<double>(g) - fit.density(x), q, learning->nodes->variation());
    if (energy > 0) learning->weights.add(static_cast<double>(g) / (static_cast<double>(q) * energy));
  }
};

}  // namespace tress::adaptive
