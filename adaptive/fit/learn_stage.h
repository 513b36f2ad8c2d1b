// One stage in learning a row of a sampled target: few paths at first, two to four times as many at each further stage.
#pragma once

#include <array>
#include <cstdint>

#include "convergence/held_out_test.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::inline v0_2::adaptive {

/// The number of paths of a row at each stage.
inline constexpr std::array<std::uint32_t, 5> sampled_stages{512, 2048, 8192, 16384, 65536};
/// Whether a test by the paths of this stage may declare a row converged. With fewer paths the deviation of the test is
/// too large.
constexpr bool may_converge(std::uint32_t paths) { return paths >= 2048; }

struct StagedRow {
  RibbonRow row;     ///< fitted to all paths of the stage
  SampledTest test;  ///< result for the row that was tested
  bool tested = false;
  bool usable = false;  ///< false if the target draws exits that SampledTarget does not allow, or no light
};

/// Learns the row at (a, b) from `paths` paths, a multiple of 4: the first paths/4 of streams 0 to 3, so that the paths
/// of a stage are the first ones of all later stages.
/// `before`: the row fitted to the first `paths_before` of them; the other paths test it. If the fit to all paths is
/// worse on those, `before` is kept, with the energies of all paths. `parent`: a prediction from other nodes, tested by
/// all paths if `before` is null. If its T + deviation is below 0.3, it is the prior of the fit, and counts for fewer
/// exits the larger that is (RibbonFitRule).
/// Both may be null. Pure. Any thread.
StagedRow learn_stage(const SampledTarget& target, const SliceDescription& slice, float a, float b, std::uint32_t paths,
                      std::uint32_t paths_before, const RibbonRow* before, const RibbonRow* parent);

/// Tests a row on fresh draws: `round` chooses streams that learning never uses. count: a multiple of 4.
SampledTest test_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
                         const RibbonRow& row, std::uint64_t round, std::uint32_t count);

}  // namespace tress::inline v0_2::adaptive
