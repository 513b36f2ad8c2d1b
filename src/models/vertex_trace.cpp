#include "models/vertex_trace.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "fiber/cross_section.h"
#include "fiber/ray_batch.h"
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
  // Ray counts are powers of two of at least 128: whole batches.
  const double share = 1.0 / key.rays;
  for (int first = 0; first < key.rays; first += RayBatch::lanes) {
    RayBatch batch(section, 2 * (first + static_cast<double>(key.place)) * share - 1, 2 * share);
    for (Rays& rays : lobes_) {
      batch.advance();
      std::array<float, RayBatch::lanes> azimuth;
      batch.azimuths(azimuth.data());
      for (std::size_t lane = 0; lane < azimuth.size(); ++lane) {
        if (!(batch.weight()[lane] > 0)) continue;
        rays.azimuth.push_back(adaptive::wrap_angle(azimuth[lane]));
        rays.weight.push_back(static_cast<float>(batch.weight()[lane] * share));
        rays.path.push_back(static_cast<float>(batch.path()[lane]));
      }
    }
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
