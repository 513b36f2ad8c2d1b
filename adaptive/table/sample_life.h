// Which rows of samples are to have more paths, and how one learns from them (README.md, the life of a row).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "table/light_policy.h"
#include "table/row_outcome.h"
#include "table/rows.h"
#include "tress/adaptive/sampled_target.h"
#include "tress/base/error.h"

namespace tress::inline v0_2::adaptive {

/// Changes nothing: the table shows what came out. Functions of one row run in parallel with those of others.
class SampleLife {
 public:
  /// All must outlive this object. target: null if there are no slices of samples.
  SampleLife(const Options& options, const Rows& rows, const LightPolicy& light, const SampledTarget* target)
      : options_(options), rows_(rows), light_(light), target_(target) {}

  /// A row that is to have more paths.
  struct Growth {
    std::uint32_t node, paths;
    std::uint64_t light;
    double events;
  };
  /// The coarse rows of one slice that are to grow, or all of its rows; those of most light come first. again: by node,
  /// the paths of rows that start again, else 0; empty if no row does.
  std::vector<Growth> growths(SliceId slice, bool is_coarse, const std::vector<std::uint32_t>& again) const;
  /// Whether rows of a slice would grow: coarse ones, or others with at least `share` of its events.
  bool pays(SliceId slice, double share) const;
  /// Learns a row up to `paths`, and further if it is to learn until it passes its test. parent: what answered before a
  /// new row, or null.
  RowOutcome learn(const Row& row, std::uint32_t paths, bool is_coarse, const RibbonAnswer* parent) const;
  /// Tests a row of a cache on draws of the pass.
  RowOutcome audit(const Row& row, std::uint32_t pass) const;
  /// What the target drew for a refused row that SampledTarget does not allow. It draws anew: a node is refused at most
  /// once.
  std::optional<Error> invalid_exits(const Row& row, std::uint64_t paths) const;

  /// The largest number of paths from which a row is learned.
  std::uint32_t most_paths() const;
  /// Draws from a node over all passes, those included that a coarse row of the slice answered for other slices.
  double asked_of_coarse(const Slice& slice, std::uint32_t node) const;

 private:
  bool learns_to_epsilon() const { return options_.learns_to_epsilon || options_.picture_error > 0; }
  /// Events by node. is_coarse: those of each node are shared among the nodes of the coarse grid around it.
  std::vector<double> gathered_events(const Slice& slice, bool is_coarse) const;
  /// The number of paths that a row is to have, a coarse one or one of its own; 0 if the node gets no row yet.
  std::uint32_t wanted_paths(SliceId slice, bool is_coarse, double events) const;

  const Options& options_;
  const Rows& rows_;
  const LightPolicy& light_;
  const SampledTarget* target_;
};

}  // namespace tress::inline v0_2::adaptive
