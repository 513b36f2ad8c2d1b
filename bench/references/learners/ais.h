// The paper's fit of a mixture: adaptive importance sampling (Pekelis et al. 2015, section 5), steps I to V.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "references/learners/ais_settings.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {

/// What is fitted: g on the circle.
struct AisTarget {
  std::function<double(float)> density;  ///< g(x), 1/rad, x in [-pi, pi)
  double energy = 0;                     ///< its mass
  double variation = 0;                  ///< max(integral (g - mean)^2, 1e-3/2pi), 1/rad
};

/// The target of a row. `nodes` must outlive it.
AisTarget ais_target(const TracedNodes& nodes);

enum class AisEnd : std::uint8_t {
  reached,    ///< two sets of fresh draws found the relative objective below the threshold
  stopped,    ///< early stopping
  exhausted,  ///< the last iteration
  refused,    ///< g is not finite, negative or without mass: the mixture is flat, of g's mass if that is a number
};

struct AisFit {
  Mixture mixture;  ///< within the constraints of mixture.h; attributes zero
  /// Estimate of integral (g - f)^2/variation on draws not used for anything else: unbiased, but where they are what
  /// ended it (reached: they were below the threshold).
  double objective = 0;
  double standard_error = 0;        ///< of it
  std::uint64_t g_evaluations = 0;  ///< all of them, the last test's too
  int iterations = 0;               ///< samples that were drawn for fitting
  AisEnd end = AisEnd::refused;
  std::vector<double> history;  ///< the relative objective before each iteration, on the sample drawn for it: unbiased
};

/// I. P_d and pi_d ~ a_d P_d. II. A sample of m azimuths from the mixture of pi_d p_d/P_d (the first: uniform).
/// III. Weights, which stand for g, for f, or for either by turns. IV. Some steps on b by Newton or gradient, each
/// followed by the regression for a >= 0; all components at once or one after the other. V. Again, until fresh draws
/// (the next sample, before it is used) find the objective below the threshold, or nothing is won any more. The fit
/// that comes back is the best by those draws. Pure, deterministic, never fails: see AisEnd. Any thread.
AisFit fit_ais(const AisTarget& target, RandomStream random, const AisSettings& settings = {});

}  // namespace tress::inline v0_2::adaptive
