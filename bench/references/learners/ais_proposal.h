// Steps I and II of the paper's fit: drawing from the mixture.
#pragma once

#include "references/learners/ais_problem.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {

/// pi_d p_d/P_d with pi_d ~ a_d P_d, a_0 among them, and a share that is uniform. Uniform where a has no mass.
class AisProposal {
 public:
  AisProposal(const AisParts& parts, AisBasis basis, double uniform_share);

  /// Radians in [-pi, pi).
  float sample(double u) const;
  /// f, the mixture itself; and the density that is drawn from, 1/rad.
  double mixture(float phi) const;
  double density(float phi) const;

 private:
  AisParts parts_;
  AisBasis basis_;
  double share_, mass_;
};

/// The same mixture in this project's form: a_d P_d as weights, mass `energy`.
Mixture to_mixture(const AisParts& parts, AisBasis basis, double scale);

}  // namespace tress::inline v0_2::adaptive
