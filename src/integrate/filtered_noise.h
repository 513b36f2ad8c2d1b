// Ends a render when the noise of the filtered picture is at its target.
#pragma once

#include "integrate/renderer.h"

namespace tress::integrate {

/// The noise that is left once the picture is filtered (denoise/half_filter.h), for a render that ends by it.
class FilteredNoise {
 public:
  /// target: relative noise. scene: must outlive this object.
  FilteredNoise(double target, const scene::Scene& scene) : target_(target), scene_(scene) {}

  /// Call it after each pass. Returns the noise of the filtered picture if this pass is one at which it is measured,
  /// otherwise a noise above the target. Which passes these are depends only on the pass.
  double after(const PassProgress& pass);

 private:
  double target_;
  const scene::Scene& scene_;
  double last_ = 0;  ///< last measured noise; 0 before the first
};

}  // namespace tress::integrate
