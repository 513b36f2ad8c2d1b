// The rough elliptical fiber, traced in three dimensions and learned from its samples by the adaptive service.
#pragma once

#include <memory>

#include "tress/adaptive/sampled_target.h"
#include "tress/adaptive/service.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/fiber_model.h"

namespace tress::fiber {

/// What the service learns for this model: paths through the rough fiber at a node (theta_r, phi_r) of clear hair. Its
/// model name is that of make_elliptical_target(): one service and one cache file have both kinds of rows. Lives as
/// long as you like.
std::unique_ptr<adaptive::SampledTarget> make_rough_target();

/// One row answers all of an event: for R, TT, TRT and all that leaves later, a density over the sphere of its own,
/// under the absorption of the fiber and of the energy that fiber3d has. Where no row answers the event is one traced
/// path, which is estimated (FiberModel::estimates).
///
/// Estimator `fitted` does that; `exact` traces at every vertex and asks no row: it is fiber3d, with light samples.
/// There is no `corrected`: a target that is known by samples only has no cheap correction.
/// `service` must have been built on make_rough_target(), with make_elliptical_target() or without, and outlive the
/// model; it is not read by `exact`. Error for `corrected`, and where the service was built on other targets, or is
/// null and not for `exact`.
///
/// Of FiberParameters it reads what fiber3d reads (src/models/fiber3d.h): widths of lobes have no meaning for a traced
/// fiber.
Result<std::unique_ptr<FiberModel>> make_rough_model(Estimator estimator, adaptive::Service* service);

}  // namespace tress::fiber
