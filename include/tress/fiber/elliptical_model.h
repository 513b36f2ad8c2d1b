// The elliptical fiber of Pekelis et al. 2015, learned by the adaptive service, under three estimators.
#pragma once

#include <memory>
#include <string>

#include "tress/adaptive/service.h"
#include "tress/adaptive/target.h"
#include "tress/fiber/fiber_model.h"

namespace tress::fiber {

enum class Estimator {
  fitted,  ///< converged rows are answered by their fit, weight 1; others by g at the node
  exact,   ///< g at the vertex, always; no rows
  /// What `fitted` answers, plus, with probability 1/16, 16 times what g at the vertex has more: `exact` in the mean
  /// at nearly the cost of `fitted`. Values may be negative, and are not to be clamped.
  corrected,
};

/// As the command line, telemetry and pictures call it.
const char* estimator_name(Estimator estimator);

/// The target that the service learns for this model: rays through the elliptical cross-section at a node
/// (phi_r, |theta_d|) of clear hair, attribute = internal path length in major semi-axes. Lives as long as you like.
std::unique_ptr<adaptive::Target> make_elliptical_target();

/// `service` must have been built on make_elliptical_target() and outlive the model; null only for `exact`.
std::unique_ptr<FiberModel> make_elliptical_model(Estimator estimator, adaptive::Service* service);

/// The row axes of one lobe's page (p = 1, 2, 3).
adaptive::PageDescription elliptical_page(int p, float eta, float eccentricity, float sigma_rad);

}  // namespace tress::fiber
