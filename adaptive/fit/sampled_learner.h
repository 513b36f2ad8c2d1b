// How a row of a sampled target is learned: draws, fits, tests, doubles (ESTIMATOR.md, E9).
#pragma once

#include <cstdint>

#include "convergence/held_out_test.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::adaptive {

struct SampledRow {
  RibbonRow row;                   ///< of all paths drawn; its shapes of those that are not for energies alone
  float objective = 1;             ///< bound() of the last test, of the fit before its batch joined; >= 0
  std::uint64_t paths = 0;         ///< that taught and tested it
  std::uint64_t energy_paths = 0;  ///< drawn besides, for its energies alone
  enum class Verdict : std::uint8_t {
    converged,  ///< bound() <= epsilon
    refused,    ///< not within most_paths
    unusable,   ///< the target's draws are none: SampledTarget
  };
  Verdict verdict = Verdict::refused;
};

struct SampledLimits {
  double epsilon = Options{}.sampled_epsilon;
  std::uint32_t first_paths = 1024;     ///< of the first fit, and of the batch that tests it
  std::uint32_t most_paths = 1u << 16;  ///< in all; a power of 2 times first_paths
  /// A row that has converged knows its energies by this many paths over its epsilon at least, within most_paths: at
  /// 0.07 by 8,192. A shape is told by fewer. 0: by those that taught it.
  double energy_paths_times_epsilon = 574;
  /// Whole sets of 256.
  std::uint32_t energy_paths() const;
};

/// Learns the row at (a, b): 1,024 paths teach the first fit; each following batch has as many paths as all before it,
/// tests the fit of those, and then joins them. Where the test passes further paths tell the energies. Pure: depends on
/// its arguments alone. Any thread; takes some 50 bytes an exit of memory meanwhile.
SampledRow learn_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
                         const SampledLimits& limits);

/// Tests a row on fresh draws: `round` chooses streams that no learning has. count: a multiple of 4.
SampledTest test_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
                         const RibbonRow& row, std::uint64_t round, std::uint32_t count);

}  // namespace tress::adaptive
