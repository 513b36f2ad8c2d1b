// Draws of a sampled target in four independent sets, as rows are taught and tested by them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "convergence/held_out_test.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::adaptive {

/// The node where a row is learned.
struct SampledNode {
  const SampledTarget& target;
  const SliceDescription& slice;
  float a, b;
};

class SampledSets {
 public:
  /// Appends paths [first, first + count) of each of the four streams from `stream` on.
  void draw(const SampledNode& node, std::uint64_t stream, std::uint32_t first, std::uint32_t count);
  /// What is drawn from now on is fresh.
  void mark();

  /// Whether all exits are some (SampledTarget), of parts below `parts`.
  bool are_exits(std::uint32_t parts) const;
  /// Tests a row by the exits since mark(), or by all exits without one: `paths` of each set. Parts are below those of
  /// the row.
  SampledTest test(const RibbonRow& row, std::uint32_t paths) const;
  /// Appends all, set by set.
  void append_to(std::vector<SampledExit>& exits) const;

 private:
  std::array<std::vector<SampledExit>, HeldOutTest::sets> sets_;
  std::array<std::size_t, HeldOutTest::sets> fresh_{};
};

}  // namespace tress::adaptive
