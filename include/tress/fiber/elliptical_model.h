// The elliptical fiber of Pekelis et al. 2015, learned by the adaptive service, under three estimators.
#pragma once

#include <memory>
#include <string>

#include "tress/adaptive/service.h"
#include "tress/adaptive/target.h"
#include "tress/fiber/fiber_model.h"
#include "tress/fiber/lobes.h"

namespace tress::inline v0_2::fiber {

enum class Estimator {
  fitted,  ///< converged rows answer by their fit, with weight 1; other rows by g at the node
  exact,   ///< always g at the vertex, without rows
  /// The answer of `fitted` plus, with probability 1/16, 16 times the difference between g at the vertex and that
  /// answer: in the mean this is `exact`, at nearly the cost of `fitted`. Values may be negative and must not be
  /// clamped.
  corrected,
};

/// The name that the command line, telemetry and pictures use.
const char* estimator_name(Estimator estimator);

/// The target that the service learns for this model: rays through the elliptical cross-section of clear hair at a node
/// (phi_r, |theta_d|); the attribute is the internal path length in major semi-axes. It must outlive the service.
std::unique_ptr<adaptive::Target> make_elliptical_target();

/// `service` must have been built on make_elliptical_target() and outlive the model; `exact` does not read it. Error if
/// it was built on another target, or if it is null and the estimator is not `exact`.
Result<std::unique_ptr<FiberModel>> make_elliptical_model(Estimator estimator, adaptive::Service* service);

/// The values of SliceKey::lobe besides 1 (TT), 2 (the whole of TRT) and 3 (TRRT): the two parts of TRT for fibers that
/// split off the glint.
constexpr int glint_slice = 5;
constexpr int trt_rest_slice = 6;

/// Internal order p of a slice's rays: 1, 2, 3.
constexpr int slice_order(int slice_lobe) { return slice_lobe > 3 ? 2 : slice_lobe; }
/// The lobe whose energy the rows of a slice have.
constexpr Lobe lobe_of_slice(int slice_lobe) {
  return slice_lobe == trt_rest_slice ? Lobe::trt : static_cast<Lobe>(slice_lobe);
}

/// The row axes of one slice. slice_lobe: 1, 2, 3, glint_slice or trt_rest_slice.
adaptive::SliceDescription elliptical_slice(int slice_lobe, float eta, float eccentricity, float sigma_rad);

}  // namespace tress::inline v0_2::fiber
