#include "fit/sampled_learner.h"

#include <algorithm>
#include <cmath>

#include "convergence/held_out_test.h"
#include "fit/sampled_sets.h"

namespace tress::adaptive {
namespace {

constexpr std::uint64_t test_streams = std::uint64_t{1} << 48;  // learning never draws from these streams

}  // namespace

SampledRow learn_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
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

SampledTest test_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
                         const RibbonRow& row, std::uint64_t round, std::uint32_t count) {
  SampledSets batch;
  batch.draw({target, slice, a, b}, test_streams + HeldOutTest::sets * round, 0, count / HeldOutTest::sets);
  if (!batch.are_exits(row.parts())) return {HUGE_VAL, 0};
  return batch.test(row, count / HeldOutTest::sets);
}

}  // namespace tress::adaptive
