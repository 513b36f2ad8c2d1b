#include "models/elliptical/vertex_trace.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "fiber/cross_section.h"
#include "fiber/ray_batch.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {

const VertexTrace& VertexTrace::at(VertexKey key) {
  thread_local VertexTrace last;
  if (last.key_ != key) last.trace(key);
  return last;
}

RayShape VertexTrace::shape(std::size_t row_lobe, float blur_rad) const {
  const Rays& rays = lobes_[row_lobe];
  return {rays.azimuth, rays.weight, rays.path, blur_rad, false};
}

void VertexTrace::Rays::add(float at, double mass, double length) {
  if (!(mass > 0)) return;
  azimuth.push_back(adaptive::wrap_angle(at));
  weight.push_back(static_cast<float>(mass));
  path.push_back(static_cast<float>(length));
}

void VertexTrace::trace(const VertexKey& key) {
  const CrossSection section(key.eta, key.eccentricity, key.phi_r, key.theta_d);
  for (Rays& rays : lobes_) {
    rays.azimuth.clear();
    rays.weight.clear();
    rays.path.clear();
  }
  // Ray counts are powers of two of at least 128, so batches are always full.
  constexpr std::size_t trt = 1, glint = 3;
  const bool split = key.glint_sigma > 0;
  const double share = 1.0 / key.rays;
  for (int first = 0; first < key.rays; first += RayBatch::lanes) {
    RayBatch batch(section, 2 * (first + static_cast<double>(key.place)) * share - 1, 2 * share, split);
    for (std::size_t order = 0; order < 3; ++order) {
      batch.advance();
      std::array<float, RayBatch::lanes> azimuth;
      std::array<double, RayBatch::lanes> in_glint{};
      batch.azimuths(azimuth.data());
      if (split && order == trt) batch.glint_shares(static_cast<double>(key.glint_sigma), in_glint.data());
      for (std::size_t lane = 0; lane < azimuth.size(); ++lane) {
        const double weight = batch.weight()[lane] * share, path = batch.path()[lane];
        lobes_[order].add(azimuth[lane], weight * (1 - in_glint[lane]), path);
        lobes_[glint].add(azimuth[lane], weight * in_glint[lane], path);
      }
    }
  }
  for (std::size_t i = 0; i < lobes_.size(); ++i) mass_[i] = ray_mass(shape(i, 1.0f), key.sigma_a);
  key_ = key;
}

int vertex_ray_count(float blur_rad) {
  const double degrees = blur_rad * 180 / std::numbers::pi;
  const double rays = std::max(256.0, 128 * std::max(1.0, 20 / std::max(degrees, 0.01)));
  return static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::ceil(rays - 1e-3))));
}

}  // namespace tress::inline v0_2::fiber
