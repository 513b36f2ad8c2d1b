// Traces one path from the camera: hits, light, scattering, roulette. Radiance is by the layer of the first hit.
#pragma once

#include <cstdint>
#include <vector>

#include "integrate/camera_rays.h"
#include "integrate/deeper_light.h"
#include "integrate/frame_motion.h"
#include "integrate/light_sampler.h"
#include "integrate/near_rule.h"
#include "integrate/path_sums.h"
#include "integrate/pixel_sampler.h"
#include "integrate/renderer.h"
#include "integrate/scattering.h"

namespace tress::integrate {

/// Thread-safe during a pass. All references must outlive it. deeper: used by later hits
/// (RenderOptions::roulette), which add notes to it; null if nothing is learned.
///
/// A hit has n_l light samples and n_b BCSDF samples. The balance heuristic turns both estimates of one light into the
/// same expression, S L / (n_l p_light c + n_b Q). Q is the density of the BCSDF sampler in the vertex's own measure
/// (dtheta dphi on a fiber, solid angle on a surface), and c is the solid angle per unit of it (cos theta_i, 1).
/// p_light is the density in solid angle of drawing that light and the direction by it. Light samples add the
/// expression once; BCSDF samples add it for every light that they meet. At a vertex that can only be sampled, n_l is
/// 0.
class PathTracer {
 public:
  PathTracer(const scene::Scene& scene, const geometry::FiberScene& fibers, const fiber::FiberModel& model,
             const std::vector<fiber::FiberId>& fiber_ids, const RenderOptions& options,
             const DeeperLight* deeper = nullptr);

  /// Traces one sample of pixel (x, y). Its only side effects are notes of the model's service and of `deeper`. The
  /// result may be infinite where fibers return more light than falls on them (`gain` above 1).
  PathSums trace(int x, int y, std::uint32_t sample) const {
    PathSums sums = carried(x, y, sample);
    if (scene_.integrator.spectral) sums.take_rgb();
    return sums;
  }

  /// Returns a tracer with roulette of shadow rays: of the light samples that bring less than 1.6 times `brightness`,
  /// only a share is traced. brightness: mean of hair and surfaces in the picture, over channels; with 0 all are
  /// traced.
  PathTracer at_brightness(float brightness) const;

  /// Sets the mean luminance of hair and surfaces in the picture, as far as it is known. It decides for which light the
  /// excess of rows is evaluated; any value leaves every mean as it is. Call it between passes.
  void set_brightness(double luminance) { brightness_ = static_cast<float>(luminance); }

 private:
  /// The path's sums, with light as paths carry it (LightSampler); the background is RGB.
  PathSums carried(int x, int y, std::uint32_t sample) const;
  /// Light of one light sample by layer, and an estimate of its excess by the errors of rows.
  struct Lit {
    ScatteredLayers layers{};
    glm::vec3 excess{0.0f};
    std::size_t group = 0;  ///< group of the light that was drawn
  };
  /// Whether anything hides the point of a light that LightSampler::sample() drew from the hit's axis.
  bool is_shadowed(const geometry::Hit& hit, const LightSampler::Arrival& light, const fiber::FiberExit& exit) const;
  /// Takes one light sample of the vertex. weight: that of the vertex in the picture, for the roulette of shadow rays.
  /// Counts its queries in `sums`.
  Lit light(const Vertex& vertex, float u_light, const std::array<float, 2>& u, const glm::vec3& weight,
            RandomStream& random, PathSums& sums) const;
  /// The chance of evaluating the excess of rows for light that brings this luminance to the picture.
  float chance_of_light(float luminance) const;
  /// Light that a BCSDF sample of the vertex meets within distance_cm, weighted against light samples. Adds it, times
  /// the throughput, to `groups`.
  glm::vec3 met_light(const Vertex& vertex, const Scattering::Sample& sample, float distance_cm,
                      const glm::vec3& throughput, GroupLight& groups) const;
  /// Adds the light of one BCSDF sample of the first vertex, followed to its end.
  void follow(const Vertex& vertex, const Scattering::Sample& sample, RandomStream& random, PathSums& sums) const;
  struct Worth;
  struct Departure;
  /// Follows a drawn direction of a vertex with this worth to the next hit.
  Departure depart(const Vertex& vertex, const Scattering::Sample& sample, const Worth& worth, PathSums& sums) const;
  struct Arrival;
  /// The hits of the path whose copies are not all done; each was met by a copy from the one before.
  using Tree = std::vector<Arrival>;
  /// Makes an Arrival for a hit that was met along `direction`, with an answer if possible. is_check: whether an
  /// earlier hit of the path has an answer.
  Arrival arrive(const geometry::Hit& hit, const glm::vec3& direction, int depth, const Worth& worth,
                 bool is_check) const;
  /// Decides whether a path goes on from a hit, and by how many copies. If so, returns true and appends the hit to
  /// `tree`.
  bool go_on(Arrival at, RandomStream& random, PathSums& sums, Tree& tree) const;
  /// Starts the next copy at the last hit of `tree`. Returns true if the copy met a hit that it goes on from, which is
  /// now the last.
  bool step(Tree& tree, RandomStream& random, PathSums& sums) const;
  void end_copy(Arrival& hit) const;
  /// Whether hits can have answers. Constant during a pass.
  bool answers() const { return deeper_ && deeper_->can_answer(); }

  /// A ray of the camera at a time of the shutter, [0, 1].
  geometry::Ray camera_ray(int x, int y, const PixelSampler& stratified, std::uint32_t in_half, float time) const;
  /// Motion of what the ray met until the next frame. hit: null if it met nothing.
  glm::vec2 motion_of(const geometry::Ray& ray, const geometry::Hit* hit, const LightSampler::Arrival& seen) const;

  const scene::Scene& scene_;
  const geometry::FiberScene& fibers_;
  const RenderOptions& options_;
  CameraRays camera_;
  FrameMotion motion_;
  LightSampler lights_;
  float brightness_ = 0;
  std::size_t group_count_;  ///< 0 if no light is kept by group
  Scattering scattering_;
  NearRule near_;
  float surely_traced_ = 0;  ///< light samples that bring at least this are always traced; 0: all are
  const DeeperLight* deeper_;
};

}  // namespace tress::integrate
