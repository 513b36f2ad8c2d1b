// The elliptical fiber of Pekelis et al. 2015, learned by the adaptive service, under three estimators.
#pragma once

#include <memory>
#include <string>

#include "tress/adaptive/service.h"
#include "tress/adaptive/target.h"
#include "tress/fiber/fiber_model.h"
#include "tress/fiber/lobes.h"

namespace tress::fiber {

enum class Estimator {
  fitted,  ///< converged rows are answered by their fit, weight 1; others by g at the node
  exact,   ///< g at the vertex, always; no rows
  /// What `fitted` answers, plus, with probability 1/16, 16 times what g at the vertex has more: `exact` in the mean
  /// at nearly the cost of `fitted`. Values may be negative, and are not to be clamped.
  corrected,
};

/// The name that the command line, telemetry and pictures use.
const char* estimator_name(Estimator estimator);

/// The target that the service learns for this model: rays through the elliptical cross-section at a node
/// (phi_r, |theta_d|) of clear hair, attribute = internal path length in major semi-axes. Lives as long as you like.
std::unique_ptr<adaptive::Target> make_elliptical_target();

/// `service` must have been built on make_elliptical_target() and outlive the model; it is not read by `exact`. Error
/// where it was built on another target, or is null and not for `exact`.
Result<std::unique_ptr<FiberModel>> make_elliptical_model(Estimator estimator, adaptive::Service* service);

/// What SliceKey::lobe says beside 1 (TT), 2 (the whole of TRT) and 3 (TRRT): the two parts of TRT of fibers that split
/// off the glint.
constexpr int glint_slice = 5;
constexpr int trt_rest_slice = 6;

/// Internal order p of a slice's rays: 1, 2, 3.
constexpr int slice_order(int slice_lobe) { return slice_lobe > 3 ? 2 : slice_lobe; }
/// The lobe whose energy a slice's rows have.
constexpr Lobe lobe_of_slice(int slice_lobe) {
  return slice_lobe == trt_rest_slice ? Lobe::trt : static_cast<Lobe>(slice_lobe);
}

/// The row axes of one slice. slice_lobe: 1, 2, 3, glint_slice or trt_rest_slice.
adaptive::SliceDescription elliptical_slice(int slice_lobe, float eta, float eccentricity, float sigma_rad);

}  // namespace tress::fiber
