// The rough elliptical fiber, traced in three dimensions and learned from its samples by the adaptive service.
#pragma once

#include <memory>

#include "tress/adaptive/sampled_target.h"
#include "tress/adaptive/service.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/fiber_model.h"

namespace tress::inline v0_2::fiber {

/// The target that the service learns for this model: paths through the rough fiber of clear hair at a node (theta_r,
/// phi_r). Its model name is that of make_elliptical_target(), so one service and one cache file can have both kinds of
/// rows. It must outlive the service.
std::unique_ptr<adaptive::SampledTarget> make_rough_target();

/// One row answers a whole event. It has a density over the sphere for each of R, TT, TRT and all that leaves later,
/// under the absorption of the fiber and with the energy of the traced fiber. If no row answers, the event is one
/// traced path, which is estimated (FiberModel::estimates).
///
/// That is the estimator `fitted`. `exact` traces at every vertex and uses no row: it is the reference fiber3d with
/// light samples. There is no `corrected`, because a target that is known by samples only has no cheap correction.
/// `service` must have been built on make_rough_target(), with or without make_elliptical_target(), and outlive the
/// model; `exact` does not read it. Error for `corrected`, if the service was built on other targets, or if it is null
/// and the estimator is not `exact`.
///
/// It uses these FiberParameters: eta, eccentricity, roughness, tilt, sigma_a, the medulla, gain and split_glint.
/// Widths and shapes of lobes have no meaning for a traced fiber.
Result<std::unique_ptr<FiberModel>> make_rough_model(Estimator estimator, adaptive::Service* service);

}  // namespace tress::inline v0_2::fiber
