// The ground truth: a rough elliptical fiber, traced stochastically at every hit, to all orders.
#pragma once

#include <memory>

#include "models/registry.h"
#include "tress/fiber/fiber_model.h"

namespace tress::inline v0_2::fiber {

/// Traces the path of fiber/rough_fiber.h at every sample, with its definition and limits: Beckmann facets on a cuticle
/// of tilted scales, exact Fresnel, absorption along the path in three dimensions. Light that a facet sends against
/// another one meets that one too, so a clear fiber returns all light. (With one facet a hit, as in ../shared/reference
/// and with ModelSettings::loses_masked_light, up to 18 % of the light is lost at alpha 0.2.) It leaves out
/// diffraction, and polarisation between events.
///
/// Near field: light enters at the offset h of begin(), and the mean over h is the far field of the other models; light
/// leaves from the point that was hit. It can only be sampled: sample() gives one path, its throughput as S in the lobe
/// of its order (R, TT, TRT, TRRT, the residual from p = 4 on) over a pdf of 1; evaluate() gives 0. A path that was
/// absorbed has the weight 0.
///
/// It uses these FiberParameters: eta, eccentricity, roughness (alpha, of every event), tilt, sigma_a, the medulla and
/// gain. It ignores those without a meaning for it: azimuthal_sigma, longitudinal_lambda, longitudinal_shape,
/// reflection_fresnel. If the fiber splits off its glint, TRT paths are divided by the share that the smooth fiber has
/// at this h.
///
/// FiberEvent::energy and selection are those of the smooth fiber, for the albedo layer only. Deterministic: the path
/// depends on the event's numbers and the four uniforms of sample() only.
std::unique_ptr<FiberModel> make_fiber3d(const ModelSettings& settings);

}  // namespace tress::inline v0_2::fiber
