// The rays of TT, TRT, TRRT and GLINT at a vertex's own (phi_r, |theta_d|), with all orders from one trace.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "models/elliptical/ray_shape.h"

namespace tress::inline v0_2::fiber {

/// The arguments of a trace. phi_r in [0, pi/2] (folded), theta_d in [0, pi/2], radians.
struct VertexKey {
  float eta = 0, eccentricity = 0, phi_r = 0, theta_d = 0;
  int rays = 0;
  glm::vec3 sigma_a{0.0f};
  float place = 0.5f;     ///< place of each ray in its share of h, [0, 1); 0.5: midpoints; random: unbiased
  float glint_sigma = 0;  ///< blur of TRT, radians, if GLINT is split off it; else 0
  friend bool operator==(const VertexKey&, const VertexKey&) = default;
};

class VertexTrace {
 public:
  /// The trace for `key`: this thread's last one if it has the same key, else a new one that replaces it. A pure
  /// function of the key; valid until this thread's next call.
  static const VertexTrace& at(VertexKey key);

  /// TT, TRT (or its rest), TRRT, GLINT: azimuths relative to phi_r, in [-pi, pi).
  RayShape shape(std::size_t row_lobe, float blur_rad) const;
  const ClearAndAbsorbed& mass(std::size_t row_lobe) const { return mass_[row_lobe]; }

 private:
  void trace(const VertexKey& key);
  struct Rays {
    std::vector<float> azimuth, weight, path;
    void add(float at, double mass, double length);
  };
  VertexKey key_;
  std::array<Rays, 4> lobes_;
  std::array<ClearAndAbsorbed, 4> mass_{};
};

/// The number of rays that resolve a blur at a vertex: the node rule 128 max(1, 20/sigma_deg), a power of two, at least
/// 256.
int vertex_ray_count(float blur_rad);

}  // namespace tress::inline v0_2::fiber
