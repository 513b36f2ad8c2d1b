// Every setting of the paper's adaptive importance sampling, its default, where the paper says it and where it does
// not.
#pragma once

#include <cstdint>

#include "references/learners/ais_columns.h"

namespace tress::inline v0_2::adaptive {

/// h of step IV.
enum class AisDistance : std::uint8_t {
  l2,                ///< (g - f)^2
  relative_entropy,  ///< log(g/f) under weights proportional to g, with its mass term: g log(g/f) - g + f
};

/// What the sample of step III stands for (section 5.3, second scheme).
enum class AisWeighting : std::uint8_t {
  target,     ///< w = g/f: as if drawn from g (step III and equation 4)
  proposal,   ///< w = 1: as drawn, from f
  alternate,  ///< one after the other (5.3)
  uniform,    ///< w = 1/f: plain L2. Not in the paper; what its own measure of error in 7.1 is
};

/// Which unknowns step IV moves at a time (section 5.3, first scheme).
enum class AisSweep : std::uint8_t {
  complete,    ///< all {a_d, b_d} at once
  sequential,  ///< each d in its turn, the others kept
  alternate,   ///< one after the other (5.3)
};

/// How b moves in step IV.
enum class AisStep : std::uint8_t {
  newton,    ///< the Hessian of step IV, damped where it is not positive or the step does not pay
  gradient,  ///< steepest descent, mu in units of its own scale, the length by backtracking
};

/// Section 5.4.
enum class AisStop : std::uint8_t {
  none,      ///< only the threshold of step V, and the last iteration
  printed,   ///< the product of p-values as printed. It never stops: mu_l = mu_h makes every p-value 1
  mended,    ///< log(1 - eps) for mu_l and sigma for sigma^2; still a product of p-values, whose level is not alpha
  held_out,  ///< ends when fresh draws have found nothing better by the factor 1 - eps for `stop_window` iterations
};

/// Where the components start; the paper does not say.
enum class AisStart : std::uint8_t {
  spread,  ///< modes equally far apart, equal weights
  sample,  ///< modes at the (d + 1/2)/D quantiles of the first, uniform sample, weighted by g
};

struct AisSettings {
  int components = 5;       ///< D: 5 for TRT, 3 for GLINT (3.2); at most Mixture::max_components
  double threshold = 1e-4;  ///< epsilon of step V (table 2), here of the relative squared L2, on fresh draws
  AisDistance distance = AisDistance::l2;            ///< table 2
  AisWeighting weighting = AisWeighting::alternate;  ///< 5.3
  AisSweep sweep = AisSweep::alternate;              ///< 5.3
  AisStep step = AisStep::newton;                    ///< 5.1 prints both; Newton is the one of the pseudocode
  int steps = 10;           ///< on b, each followed by the regression for a, before it resamples (5.1: "roughly 10")
  int samples = 256;        ///< m of step II. Not printed: with 64 the tail of errors is wider, 512 win nothing
  int iterations = 100;     ///< T. Not printed: few rows get there
  double periodicity = 10;  ///< tau (5.2: ">= 10"). Nothing to do for the circular basis, whose f(-pi) = f(pi)
  AisBasis basis = AisBasis::circular;  ///< the paper: line. The mixture that comes back is circular in either case
  AisStop stop = AisStop::held_out;
  double stop_epsilon = 0.05;  ///< 5.4
  double stop_alpha = 0.01;    ///< 5.4
  int stop_window = 15;        ///< k (5.4: 15 to 20)
  AisStart start = AisStart::sample;
  bool uniform_part = true;  ///< a_0 beside the D components: stands for the scales above 0.5 that B does not have here
  double uniform_share = 0.05;  ///< of the proposal: no part of g can be missed for ever. The paper: 0
  bool revive = true;       ///< a component that the regression left without weight starts anew where f is most below g
  bool keep_energy = true;  ///< a is scaled so that the mass of f is the known one of g
};

}  // namespace tress::inline v0_2::adaptive
