// A row of a sampled target at one stage of its learning: few paths first, four times as many at each further stage.
#pragma once

#include <array>
#include <cstdint>

#include "convergence/held_out_test.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::adaptive {

/// Paths of a row by stages.
inline constexpr std::array<std::uint32_t, 5> sampled_stages{512, 2048, 8192, 16384, 65536};
/// Whether a test by the paths of this stage may say that a row has converged: of fewer its deviation is too large.
constexpr bool may_converge(std::uint32_t paths) { return paths >= 2048; }

struct StagedRow {
  RibbonRow row;     ///< of all paths of the stage
  SampledTest test;  ///< of what was tested
  bool tested = false;
  bool usable = false;  ///< false: the target draws what SampledTarget does not allow, or no light
};

/// The row at (a, b) by `paths` paths, a multiple of 4: the first paths/4 of streams 0 to 3, so that those of a stage
/// are the first of all later ones. `before`: the row that `paths_before` of them taught, is tested by the others.
/// It stays, with the energies of all paths, where the fit to all paths is worse on those.
/// Where it is null, `parent`, a prediction by other nodes, is tested by all; where its T + deviation is below 0.3 the
/// fit is held to it, by the fewer exits the larger that is (RibbonFitRule). Both may be null. Pure. Any thread.
StagedRow learn_stage(const SampledTarget& target, const SliceDescription& slice, float a, float b, std::uint32_t paths,
                      std::uint32_t paths_before, const RibbonRow* before, const RibbonRow* parent);

}  // namespace tress::adaptive
