// Learns a row of a sampled target alone, stage by stage, as a table does with Options::learns_to_epsilon.
#pragma once

#include <algorithm>
#include <cstdint>

#include "fit/learn_stage.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::inline v0_2::adaptive {

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

/// Learns the row at (a, b). Pure. Any thread; needs some 50 bytes of memory for each exit.
inline SampledRow learn_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
                                const SampledLimits& limits) {
  SampledRow learned;
  for (const std::uint32_t paths : sampled_stages) {
    if (paths > limits.most_paths) break;
    const StagedRow staged =
        learn_stage(target, slice, a, b, paths, learned.paths, learned.paths > 0 ? &learned.row : nullptr, nullptr);
    if (!staged.usable) {
      learned.verdict = SampledRow::Verdict::unusable;
      return learned;
    }
    if (staged.tested) learned.objective = static_cast<float>(std::max(staged.test.bound(), 0.0));
    learned.row = staged.row;
    learned.paths = paths;
    if (staged.tested && may_converge(paths) && static_cast<double>(learned.objective) <= limits.epsilon) {
      learned.verdict = SampledRow::Verdict::converged;
      break;
    }
  }
  return learned;
}

}  // namespace tress::inline v0_2::adaptive
