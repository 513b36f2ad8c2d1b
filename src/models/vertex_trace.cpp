#include "models/vertex_trace.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "fiber/cross_section.h"
#include "tress/adaptive/mixture.h"

namespace tress::fiber {

const VertexTrace& VertexTrace::at(const VertexKey& key) {
  thread_local VertexTrace last;
  if (last.key_ != key) last.trace(key);
  return last;
}

RayShape VertexTrace::shape(int p, float blur_rad) const {
  const Rays& rays = lobes_[static_cast<std::size_t>(p - 1)];
  return {rays.azimuth, rays.weight, rays.path, blur_rad, false};
}

void VertexTrace::trace(const VertexKey& key) {
  const CrossSection section(key.eta, key.eccentricity, key.phi_r, key.theta_d);
  for (Rays& rays : lobes_) {
    rays.azimuth.clear();
    rays.weight.clear();
    rays.path.clear();
  }
  const double cos_phi = std::cos(section.phi_r), sin_phi = std::sin(section.phi_r);
  const double share = 1.0 / key.rays;
  double path_left;
  for (int i = 0; i < key.rays; ++i) {
    section.follow((2 * i + 1) * share - 1, 3, 0, &path_left,
                   [&](int order, double weight, double x, double y, double path) {
                     if (order == 0 || !(weight > 0)) return;
                     Rays& rays = lobes_[static_cast<std::size_t>(order - 1)];
                     const double across = cos_phi * y - sin_phi * x, along = cos_phi * x + sin_phi * y;
                     const float azimuth = std::atan2(static_cast<float>(across), static_cast<float>(along));
                     rays.azimuth.push_back(adaptive::wrap_angle(azimuth));
                     rays.weight.push_back(static_cast<float>(weight * share));
                     rays.path.push_back(static_cast<float>(path));
                   });
  }
  for (int p = 1; p <= 3; ++p) mass_[static_cast<std::size_t>(p - 1)] = ray_mass(shape(p, 1.0f), key.sigma_a);
  key_ = key;
}

int vertex_ray_count(float blur_rad) {
  const double degrees = blur_rad * 180 / std::numbers::pi;
  const double rays = std::max(256.0, 128 * std::max(1.0, 20 / std::max(degrees, 0.01)));
  return static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::ceil(rays - 1e-3))));
}

}  // namespace tress::fiber
