#include "fit/learn_stage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "convergence/held_out_test.h"
#include "fit/fitted_row.h"
#include "fit/part_energies.h"
#include "fit/row_exits.h"
#include "observations/heard_exits.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double worst_parent = 0.3;  ///< largest T + deviation at which a prediction is used as a start
constexpr double kappa_times_bound = 50, most_kappa = 2048;
constexpr std::uint64_t test_streams = std::uint64_t{1} << 48;  // learning never draws from these streams

/// Draws of a sampled target in four independent sets.
struct SampledSets {
  std::array<std::vector<SampledExit>, HeldOutTest::sets> all;
  std::array<std::size_t, HeldOutTest::sets> taught{};  ///< the first exits of each set, which test() leaves out

  bool are_exits(std::uint32_t parts) const {
    const auto is_one = [parts](const SampledExit& exit) { return is_exit(exit, parts); };
    return std::ranges::all_of(all, [&](const auto& set) { return std::ranges::all_of(set, is_one); });
  }
  /// paths: their number in each set, without those that taught. Parts must be below those of the row.
  SampledTest test(const RibbonRow& row, std::uint32_t paths) const {
    HeldOutTest held_out(row);
    for (std::size_t s = 0; s < all.size(); ++s) held_out.add(s, std::span(all[s]).subspan(taught[s]));
    return held_out.result(paths);
  }
};

}  // namespace

StagedRow learn_stage(const SampledTarget& target, const SliceDescription& slice, float a, float b, std::uint32_t paths,
                      std::uint32_t paths_before, const RibbonRow* before, const RibbonRow* parent) {
  constexpr std::uint32_t sets = HeldOutTest::sets;
  const std::uint32_t parts = target.parts(slice);
  StagedRow staged;
  if (parts < 1 || parts > SampledTarget::most_parts) return staged;
  SampledSets drawn;
  if (before == nullptr) paths_before = 0;
  if (paths_before > 0) target.draw_sets(slice, a, b, 0, 0, paths_before / sets, drawn.all);
  for (std::size_t s = 0; s < sets; ++s) drawn.taught[s] = drawn.all[s].size();
  target.draw_sets(slice, a, b, 0, paths_before / sets, (paths - paths_before) / sets, drawn.all);
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
  for (const std::vector<SampledExit>& set : drawn.all) all.insert(all.end(), set.begin(), set.end());
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
  target.draw_sets(slice, a, b, test_streams + HeldOutTest::sets * round, 0, count / HeldOutTest::sets, batch.all);
  if (!batch.are_exits(row.parts())) return {HUGE_VAL, 0};
  return batch.test(row, count / HeldOutTest::sets);
}

}  // namespace tress::inline v0_2::adaptive
