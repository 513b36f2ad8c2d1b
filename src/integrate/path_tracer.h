// One path from the camera: hits, light, scattering, roulette; radiance by the layer of the first hit.
#pragma once

#include <cstdint>
#include <vector>

#include "integrate/camera_rays.h"
#include "integrate/deeper_light.h"
#include "integrate/frame_motion.h"
#include "integrate/light_sampler.h"
#include "integrate/path_sums.h"
#include "integrate/pixel_sampler.h"
#include "integrate/renderer.h"
#include "integrate/scattering.h"

namespace tress::integrate {

/// Immutable; any thread. All references must outlive it. `deeper`: what later hits go by (RenderOptions::roulette),
/// and what they tell; null: nothing is learned.
///
/// With n_l light and n_b BCSDF samples at a hit, the balance heuristic turns both estimates of one light into the same
/// expression, S L / (n_l p_light c + n_b Q): Q is the density of the BCSDF sampler in the vertex's own measure (dtheta
/// dphi on a fiber, solid angle on a surface), c the solid angle per unit of it (cos theta_i, 1), and p_light the
/// density in solid angle of drawing that light and the direction by it. Light samples add it; BCSDF samples add it for
/// every light that they meet. At a vertex that can only be sampled n_l is 0.
class PathTracer {
 public:
  PathTracer(const scene::Scene& scene, const geometry::FiberScene& fibers, const fiber::FiberModel& model,
             const std::vector<fiber::FiberId>& fiber_ids, const RenderOptions& options,
             const DeeperLight* deeper = nullptr);

  /// One sample of pixel (x, y). Pure up to what the model's service notes. Not finite where fibers return more light
  /// than falls on them (`gain` above 1) until floats end.
  PathSums trace(int x, int y, std::uint32_t sample) const;

  /// The same, with shadow rays by roulette: of a light sample that brings the picture less than 1.6 times its
  /// `brightness` (mean of the channels, of what hair and surfaces show) only a share is traced. 0: all are traced.
  PathTracer at_brightness(float brightness) const;

  /// The mean luminance of what is seen of hair and surfaces, as far as it is known: what light is worth looking at
  /// is measured by it. Between passes; any value leaves every mean as it is.
  void tell_brightness(double luminance) { brightness_ = static_cast<float>(luminance); }

 private:
  /// What one light sample brings, by layer, and what of it is too much by the rows, in the mean.
  struct Lit {
    ScatteredLayers layers{};
    glm::vec3 excess{0.0f};
    std::size_t group = 0;  ///< of the light that was drawn
  };
  /// Whether anything is met on the way to what LightSampler::sample() drew from the hit's axis.
  bool is_shadowed(const geometry::Hit& hit, const LightSampler::Arrival& light) const;
  /// Of the vertex. weight: of it in the picture, which its roulette goes by. Counts its queries in `sums`.
  Lit light(const Vertex& vertex, float u_light, const std::array<float, 2>& u, const glm::vec3& weight,
            RandomStream& random, PathSums& sums) const;
  /// The chance of asking what the rows have too much of light that brings so much luminance to the picture.
  float chance_of_light(float luminance) const;
  /// Light that a BCSDF sample of the vertex meets on its way of distance_cm, weighed against light samples; `groups`
  /// get it times the throughput.
  glm::vec3 met_light(const Vertex& vertex, const Scattering::Sample& sample, float distance_cm,
                      const glm::vec3& throughput, GroupLight& groups) const;
  /// Adds what one BCSDF sample of the first vertex brings, followed to its end (path_tree.cpp).
  void follow(const Vertex& vertex, const Scattering::Sample& sample, RandomStream& random, PathSums& sums) const;
  struct Worth;
  struct Departure;
  /// Where a drawn direction of a vertex of this worth leads.
  Departure depart(const Vertex& vertex, const Scattering::Sample& sample, const Worth& worth, PathSums& sums) const;
  struct Arrival;
  /// Hits that copies of the path still leave, each met by a copy of the one before.
  using Tree = std::vector<Arrival>;
  /// At a hit that is met along `direction`; answered, where it can be. is_check: an earlier hit of the path has been.
  Arrival arrive(const geometry::Hit& hit, const glm::vec3& direction, int depth, const Worth& worth,
                 bool is_check) const;
  /// Whether and by how many copies a path goes on from a hit; the hit is then the last of `tree`.
  bool go_on(Arrival at, RandomStream& random, PathSums& sums, Tree& tree) const;
  /// Starts the next copy at the last hit of `tree`. True: it goes on from a hit that is now the last.
  bool step(Tree& tree, RandomStream& random, PathSums& sums) const;
  void end_copy(Arrival& hit) const;
  /// Whether hits can be answered: constant during a pass.
  bool answers() const { return deeper_ && deeper_->can_answer(); }

  /// Of the camera as it is at a time of the shutter.
  geometry::Ray camera_ray(int x, int y, const PixelSampler& stratified, std::uint32_t in_half, float time) const;
  /// Where what the ray has met goes until the next frame; `hit`: null where it met nothing.
  glm::vec2 motion_of(const geometry::Ray& ray, const geometry::Hit* hit, const LightSampler::Arrival& seen) const;

  const scene::Scene& scene_;
  const geometry::FiberScene& fibers_;
  const RenderOptions& options_;
  CameraRays camera_;
  FrameMotion motion_;
  LightSampler lights_;
  float brightness_ = 0;
  std::size_t group_count_;  ///< 0: no light is kept by group
  Scattering scattering_;
  float surely_traced_ = 0;  ///< what a light sample has to bring; 0: nothing
  const DeeperLight* deeper_;
};

}  // namespace tress::integrate
