// The light that could reach a picture before any path has found it, so that the noise of a picture includes light that
// its paths have not met yet.
#pragma once

#include <vector>

#include "geometry/fiber_scene.h"
#include "integrate/film.h"
#include "scene/model/scene.h"
#include "tress/fiber/fiber_model.h"

namespace tress::integrate {

struct PassProgress;

/// The mean M of a path's radiance, and K, its second moment over M^2. Both are estimated from light drawn at the first
/// hits of the camera, as if there were no shadows and all objects were white and scattered evenly. Light samples and
/// sampled directions balance each other as in the render (FiberModel::balance()). About one path in K meets the light:
/// K is 1 where light is sampled and fibers are wide, and the sphere over a light's solid angle where only chance meets
/// the light.
///
/// The sample variance of n paths includes only light that they have met. Light that they may have missed is assumed to
/// be met by one path in n + K: the mean of a rate that was 1/K before, after n paths that have not met it. Such a path
/// brings K M.
struct PossibleLight {
  double mean = 0;    ///< M, mean over channels; 0 if the scene has no light
  double spread = 1;  ///< K, at least 1

  /// Mean radiance of the light that n paths may not have met.
  double unmet(double paths) const { return mean * spread / (paths + spread); }
  /// Variance of one path's radiance by that light.
  double unmet_variance(double paths) const { return mean * spread * unmet(paths); }
};

/// Sets `noise`, `unmet_noise` and `light_paths` of the progress. Noise is relative to the brightness of the picture,
/// or to that of the light that its paths may not have met if this is more; so a black picture has a noise above 1.
void set_noise(const Film& film, const PossibleLight& possible, PassProgress& progress);

/// Estimates PossibleLight for the whole image by 1,024 draws. It traces camera rays and queries no row. The result
/// depends only on the scene, the model and the number of light samples at the first hit.
PossibleLight possible_light(const scene::Scene& scene, const geometry::FiberScene& fibers,
                             const fiber::FiberModel& model, const std::vector<fiber::FiberId>& fiber_ids,
                             int light_samples);

}  // namespace tress::integrate
