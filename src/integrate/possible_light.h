// What light could bring to a picture, before any path has found it: so that no noise is told of paths that have not
// met the light.
#pragma once

#include <vector>

#include "geometry/fiber_scene.h"
#include "integrate/film.h"
#include "scene/model/scene.h"
#include "tress/fiber/fiber_model.h"

namespace tress::integrate {

struct PassProgress;

/// By light that is drawn at what the camera sees first, as if nothing stood before it and all were white and scattered
/// evenly: the mean M of a path's radiance, and its second moment over M^2, K, as light samples and sampled directions
/// balance each other (FiberModel::balance()). K is about the number of paths of which one meets the light: 1 where
/// light is sampled and fibers are wide; the sphere over a light's solid angle where it is met by chance alone.
///
/// Of n paths the sample variance knows what they have met. What they may have missed is met by one in n + K, as in the
/// mean of a rate of which n paths have seen nothing and which was 1/K before; a meeting brings K M.
struct PossibleLight {
  double mean = 0;    ///< M, of the channels; 0: the scene has no light
  double spread = 1;  ///< K, 1 at least

  /// Mean radiance of what n paths may not have met.
  double unmet(double paths) const { return mean * spread / (paths + spread); }
  /// Variance of one path's radiance by it.
  double unmet_variance(double paths) const { return mean * spread * unmet(paths); }
};

/// The noise of a picture, as far as it is told: `noise`, `unmet_noise`, `light_paths`. Relative to what the picture
/// shows, at least to what its paths may not have met, so that a black picture has a noise of more than 1.
void tell_noise(const Film& film, const PossibleLight& possible, PassProgress& progress);

/// Of the whole image, by 1,024 draws. Traces camera rays, asks no row, and is the same for the same scene, model and
/// number of light samples at the first hit.
PossibleLight possible_light(const scene::Scene& scene, const geometry::FiberScene& fibers,
                             const fiber::FiberModel& model, const std::vector<fiber::FiberId>& fiber_ids,
                             int light_samples);

}  // namespace tress::integrate
