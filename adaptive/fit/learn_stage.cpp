#include "fit/learn_stage.h"

#include <cmath>
#include <vector>

#include "convergence/held_out_test.h"
#include "fit/fitted_row.h"
#include "fit/part_energies.h"
#include "fit/row_exits.h"
#include "fit/sampled_sets.h"

namespace tress::adaptive {
namespace {

constexpr double worst_parent = 0.3;  ///< largest T + deviation at which a prediction is used as a start
constexpr double kappa_times_bound = 50, most_kappa = 2048;
constexpr std::uint64_t test_streams = std::uint64_t{1} << 48;  // learning never draws from these streams

}  // namespace

StagedRow learn_stage(const SampledTarget& target, const SliceDescription& slice, float a, float b, std::uint32_t paths,
                      std::uint32_t paths_before, const RibbonRow* before, const RibbonRow* parent) {
  constexpr std::uint32_t sets = HeldOutTest::sets;
  const std::uint32_t parts = target.parts(slice);
  StagedRow staged;
  if (parts < 1 || parts > SampledTarget::most_parts) return staged;
  const SampledNode node{target, slice, a, b};
  SampledSets drawn;
  if (before != nullptr && paths_before > 0) {
    drawn.draw(node, 0, 0, paths_before / sets);
    drawn.mark();
  } else {
    paths_before = 0;
  }
  drawn.draw(node, 0, paths_before / sets, (paths - paths_before) / sets);
  if (!drawn.are_exits(parts)) return staged;
  const RibbonRow* tested = before != nullptr ? before : parent;
  float kappa = 0;
  if (tested != nullptr && tested->parts() == parts && paths > paths_before) {
    staged.test = drawn.test(*tested, (paths - paths_before) / sets);
    staged.tested = true;
    const double bound = staged.test.chi2 + staged.test.deviation;
    if (before == nullptr && bound < worst_parent) {
      kappa = static_cast<float>(bound > kappa_times_bound / most_kappa ? kappa_times_bound / bound : most_kappa);
    }
  }
  std::vector<SampledExit> all;
  drawn.append_to(all);
  const RowExits exits = sort_exits(all, parts);
  PartEnergies energies;
  energies.add(exits, paths);
  if (!energies.has_mass()) return staged;
  staged.row = fitted_row(exits, energies, kappa > 0 ? parent : nullptr, RibbonFitRule::of(paths, kappa > 0, kappa));
  // The new fit may have found another optimum. If it is worse even on the paths that it was fitted to, the earlier
  // row, which was tested on them, is kept.
  if (before != nullptr && staged.tested &&
      drawn.test(staged.row, (paths - paths_before) / sets).chi2 > staged.test.chi2)
    staged.row = with_energies(*before, energies);
  staged.usable = true;
  return staged;
}

SampledTest test_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
                         const RibbonRow& row, std::uint64_t round, std::uint32_t count) {
  SampledSets batch;
  batch.draw({target, slice, a, b}, test_streams + HeldOutTest::sets * round, 0, count / HeldOutTest::sets);
  if (!batch.are_exits(row.parts())) return {HUGE_VAL, 0};
  return batch.test(row, count / HeldOutTest::sets);
}

}  // namespace tress::adaptive
