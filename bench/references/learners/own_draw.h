// The draws of methods that run to the end when a row opens.
#pragma once

#include "fit/row_learner.h"

namespace tress::inline v0_2::adaptive {

/// Draws an azimuth from the proposal of the context's fit, with its g, counted and scored. The learner may use the
/// pair after the test, but never for the fit that it scored. Needs has_fit.
inline ObservedPair draw_own(FitContext& context) {
  const float share = context.options.uniform_share_open;
  const float x = context.fit.sample(context.random.next(), share);
  const float value = context.g(x);
  context.stop.add(static_cast<double>(value) - context.fit.density(x), context.fit.proposal_density(x, share),
                   context.nodes.variation());
  return {x, value};
}

}  // namespace tress::inline v0_2::adaptive
