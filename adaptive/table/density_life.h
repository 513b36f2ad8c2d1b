// How a row of densities is opened, tested, fitted anew and audited (README.md, the life of a row).
#pragma once

#include <cstdint>

#include "fit/row_learner.h"
#include "table/guarded_targets.h"
#include "table/light_policy.h"
#include "table/row_outcome.h"
#include "table/rows.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {

/// Changes only the row that it is given, so that rows run in parallel; the table shows what came out. pass: the number
/// of the publish() that runs or ran last, from which random numbers follow.
class DensityLife {
 public:
  /// All must outlive this object. target: null if there are no slices of densities.
  DensityLife(const Options& options, const Rows& rows, const LightPolicy& light, const GuardedTarget* target)
      : options_(options), rows_(rows), light_(light), target_(target) {}

  /// Opens a row whose Learning has its nodes: lets its learner begin. cached: the row of a cache from which it starts,
  /// or null. A sketch that contradicts the nodes is dropped.
  RowOutcome open(Row& row, const CachedRow* cached, std::uint32_t pass) const;
  /// Ends a pass for an open row: takes the draws that its learner wants, tests the fit and lets the learner refit.
  RowOutcome update(Row& row, std::uint32_t pass) const;
  /// Scores a converged row of a cache against a fresh trace.
  RowOutcome audit(Row& row, std::uint32_t pass) const;

 private:
  void begin(Row& row, std::uint32_t pass, RowOutcome& outcome) const;
  /// Lets the row answer by its mean for good, where its error would be invisible. Evaluates no g.
  void leave_unfitted(Row& row, RowOutcome& outcome) const;
  /// True if the pairs of the row's sketch, which came from a cache, contradict its nodes.
  bool outdated(const Row& row) const;
  std::uint64_t draw_validation(Row& row, const Options& options, std::uint32_t pass) const;
  /// The options of the service with the row's own epsilon.
  Options options_of(const Row& row) const;
  /// options: options_of(row), which must outlive the context.
  FitContext context_of(Row& row, const Options& options, std::uint32_t pass) const;
  /// Stores the results of a context and of the stop test in the row.
  void conclude(Row& row, const FitContext& context, RowOutcome& outcome) const;
  /// The largest error of a row's fit, whose attributes are known, at the decay rates of its slice. Negative without
  /// rates and for rows that another row represents.
  double largest_absorbed_error(const Row& row) const;
  RandomStream stream_of(const Row& row, std::uint64_t purpose, std::uint32_t pass) const;

  const Options& options_;
  const Rows& rows_;
  const LightPolicy& light_;
  const GuardedTarget* target_;
};

}  // namespace tress::inline v0_2::adaptive
