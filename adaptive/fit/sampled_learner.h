// Learns a row of a sampled target, from its first path to the stage that passes its test (ESTIMATOR.md, E9).
#pragma once

#include <cstdint>

#include "convergence/held_out_test.h"
#include "fit/learn_stage.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::adaptive {

struct SampledRow {
  RibbonRow row;            ///< fitted to all paths
  float objective = 1;      ///< bound() of the last test, which tested the previous stage's row; >= 0
  std::uint32_t paths = 0;  ///< number of paths at the last stage
  enum class Verdict : std::uint8_t {
    converged,  ///< bound() <= epsilon
    refused,    ///< not converged within most_paths
    unusable,   ///< the target draws exits that SampledTarget does not allow
  };
  Verdict verdict = Verdict::refused;
};

struct SampledLimits {
  double epsilon = Options{}.sampled_epsilon;
  std::uint32_t most_paths = sampled_stages.back();
};

/// Learns the row at (a, b) alone, stage by stage, as a table does with Options::learns_to_epsilon. Pure: it depends on
/// its arguments alone. Any thread; needs some 50 bytes of memory for each exit.
SampledRow learn_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
                         const SampledLimits& limits);

/// Tests a row on fresh draws: `round` chooses streams that learning never uses. count: a multiple of 4.
SampledTest test_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
                         const RibbonRow& row, std::uint64_t round, std::uint32_t count);

}  // namespace tress::adaptive
