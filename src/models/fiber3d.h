// The ground truth: a rough elliptical fiber, traced stochastically at every hit, to all orders.
#pragma once

#include <memory>

#include "models/registry.h"
#include "tress/fiber/fiber_model.h"

namespace tress::fiber {

/// The path of fiber/rough_fiber.h at every sample, whose definition and limits it has: Beckmann facets on a cuticle of
/// tilted scales, exact Fresnel, absorption along the way in three dimensions. Light that a facet sends against another
/// one meets that one too, so that a clear fiber returns all light. (With one facet a hit, as ../shared/reference has
/// it and ModelSettings::loses_masked_light asks for, up to 18 % of the light is lost at alpha 0.2.) It leaves out
/// diffraction, and polarisation between events.
///
/// Near field: light enters at the offset h of begin(), and its mean over h is the far field that the other models
/// have; light leaves from the point that was hit. It can only be sampled: sample() gives one path, its throughput as S
/// in the lobe of its order (R, TT, TRT, TRRT, the residual from p = 4 on) over a pdf of 1; evaluate() gives 0. A path
/// that was absorbed has the weight 0.
///
/// Of FiberParameters it reads eta, eccentricity, roughness (alpha, of every event), tilt, sigma_a, the medulla and
/// gain. What has no meaning for it is ignored: azimuthal_sigma, longitudinal_lambda, longitudinal_shape,
/// reflection_fresnel. A fiber that splits off its glint has TRT paths parted by the share that the smooth fiber has at
/// this h.
///
/// FiberEvent::energy and selection are those of the smooth fiber: for the albedo layer only.
/// Deterministic: the path follows from the event's numbers and the four uniforms of sample().
std::unique_ptr<FiberModel> make_fiber3d(const ModelSettings& settings);

}  // namespace tress::fiber
