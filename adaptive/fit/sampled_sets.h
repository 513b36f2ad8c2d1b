// Draws of a sampled target in four independent sets, from which rows are learned and tested.
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
  /// Appends paths [first, first + count) of each of the four streams that begin at `stream`.
  void draw(const SampledNode& node, std::uint64_t stream, std::uint32_t first, std::uint32_t count);
  /// Marks everything drawn from now on as fresh.
  void mark();

  /// Whether all exits are valid (SampledTarget) and of parts below `parts`.
  bool are_exits(std::uint32_t parts) const;
  /// Tests a row by the exits since mark(), or by all exits if mark() was not called. `paths`: their number in each
  /// set. Their parts must be below those of the row.
  SampledTest test(const RibbonRow& row, std::uint32_t paths) const;
  /// Appends all exits, set by set.
  void append_to(std::vector<SampledExit>& exits) const;

 private:
  std::array<std::vector<SampledExit>, HeldOutTest::sets> sets_;
  std::array<std::size_t, HeldOutTest::sets> fresh_{};
};

}  // namespace tress::adaptive
