// When a render that is filtered has as little noise as was asked.
#pragma once

#include "integrate/renderer.h"

namespace tress::integrate {

/// Of a render that is to end by the noise that is left once its picture is filtered (denoise/half_filter.h).
class FilteredNoise {
 public:
  /// target: relative; scene: outlives it.
  FilteredNoise(double target, const scene::Scene& scene) : target_(target), scene_(scene) {}

  /// After each pass: the noise once filtered, if this pass is one of those after which it is looked at, which depends
  /// on the pass alone; else a noise above the target.
  double after(const PassProgress& pass);

 private:
  double target_;
  const scene::Scene& scene_;
  double last_ = 0;  ///< 0: not looked at yet
};

}  // namespace tress::integrate
