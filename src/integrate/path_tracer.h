// One path from the camera: hits, light, scattering, roulette; radiance by the lobe of the first hit.
#pragma once

#include <cstdint>
#include <vector>

#include "integrate/camera_rays.h"
#include "integrate/path_sums.h"
#include "integrate/pixel_sampler.h"
#include "integrate/renderer.h"

namespace tress::integrate {

/// Immutable; any thread. All references must outlive it.
///
/// With n_l light and n_b BCSDF samples at a hit, the balance heuristic turns both estimates into the same
/// expression, S L / (n_l p_light cos theta_i + n_b Q), Q the density of the BCSDF sampler in dtheta dphi and p_light
/// that of the environment in solid angle: light samples add it, BCSDF samples that escape add it.
class PathTracer {
 public:
  PathTracer(const scene::Scene& scene, const intersect::FiberScene& fibers, const fiber::FiberModel& model,
             const std::vector<fiber::FiberId>& fiber_ids, const RenderOptions& options);

  /// One sample of pixel (x, y). Pure up to what the model's service notes.
  PathSums trace(int x, int y, std::uint32_t sample) const;

 private:
  struct Vertex {
    intersect::Hit hit;
    fiber::FiberEvent event;
    int light_samples, bcsdf_samples;
  };
  Vertex begin(const intersect::Hit& hit, const glm::vec3& ray_direction, float xi1, float xi2, bool first) const;
  /// What one light sample of the vertex brings, by lobe. Counts its queries in `sums`.
  fiber::LobeColors light(const Vertex& vertex, const std::array<float, 2>& u, PathSums& sums) const;
  /// Adds what one BCSDF sample of the first vertex brings, followed to its end.
  void follow(Vertex vertex, fiber::FiberSample sample, RandomStream& random, PathSums& sums) const;

  const scene::Scene& scene_;
  const intersect::FiberScene& fibers_;
  const fiber::FiberModel& model_;
  const std::vector<fiber::FiberId>& fiber_ids_;
  const RenderOptions& options_;
  CameraRays camera_;
};

}  // namespace tress::integrate
