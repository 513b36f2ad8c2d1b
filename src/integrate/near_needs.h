// What decides how much light a scene loses where rows answer hits: they are the mean over a fiber's width.
#pragma once

#include <vector>

#include "geometry/fiber_scene.h"
#include "scene/model/scene.h"

namespace tress::integrate {

/// The same for every camera, seed and number of threads.
struct NearNeeds {
  /// By groom. Of the light that leaves a fiber in any direction, the share that meets another within close_widths
  /// widths.
  std::vector<float> closeness;
  /// By groom. About the share of its brightness in even light that rows lose, [0, 1], in two factors. The first is the
  /// share that rows lose of the light that a fiber reflects and that then meets no other fiber: they reflect it as
  /// from anywhere across the width. The second is the share of reflected light in the luminance that a fiber returns,
  /// since the place where refracted light leaves hardly depends on where it came. 0 if it was not measured.
  std::vector<float> lost;
  /// The share of the scene's light, [0, 1], that comes from directions in which lights are sampled with less than
  /// FiberModel::drawn_near_density, or from surfaces: what drawn directions bring to an event that begins with
  /// begin_drawn_near(). It is 1 in a constant environment and 0 under a small lamp in an open scene.
  float even = 1;
};
inline constexpr float close_widths = 2;

struct AskedNeeds {
  float close;                  ///< the loss is measured of grooms whose closeness is above this; 1: of none
  float least_gain, sure_gain;  ///< the loss times `even` is measured until it is clear of these, or known between them
  bool roughly = false;         ///< only closeness, by a sixteenth of the rays
};

/// Measures a scene by rays from outside and their next hits, in the calling thread: 0.1 s of CPU, and where fibers are
/// close 0.03 to 0.5 s more.
NearNeeds measured_needs(const scene::Scene& scene, const geometry::FiberScene& fibers, const AskedNeeds& asked);

}  // namespace tress::integrate
