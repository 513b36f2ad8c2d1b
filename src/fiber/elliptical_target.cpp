#include "fiber/elliptical_target.h"

#include <algorithm>
#include <memory>
#include <numbers>

#include "fiber/cross_section.h"
#include "fiber/ray_batch.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::inline v0_2::fiber {
namespace {

/// Appends n midpoint rays of a slice (n a multiple of the lanes) and returns their mass.
double trace_midpoints(const CrossSection& section, const adaptive::SliceKey& slice, int n,
                       std::vector<adaptive::TracedRay>& out) {
  const auto lobe = static_cast<int>(slice.lobe), p = slice_order(lobe);
  const bool part = lobe == glint_slice || lobe == trt_rest_slice;
  const double share = 1.0 / n;
  double mass = 0;
  float azimuth[RayBatch::lanes];
  for (int first = 0; first < n; first += RayBatch::lanes) {
    RayBatch rays(section, (2 * first + 1) * share - 1, 2 * share, part);
    for (int order = 0; order < p; ++order) rays.advance();
    rays.azimuths(azimuth);
    double kept[RayBatch::lanes];
    std::fill_n(kept, RayBatch::lanes, 1.0);
    if (part) rays.glint_shares(static_cast<double>(slice.parameters[2]), kept);
    for (int i = 0; i < RayBatch::lanes; ++i) {
      if (lobe == trt_rest_slice) kept[i] = 1 - kept[i];
      const double weight = rays.weight()[i] * share * kept[i];
      if (weight <= 0) continue;
      mass += weight;
      out.push_back({azimuth[i], static_cast<float>(weight), static_cast<float>(rays.path()[i])});
    }
  }
  return mass;
}

}  // namespace

int traced_node_count(float sigma_rad) {
  const double wanted = 128 * std::max(1.0, 20 * std::numbers::pi / 180 / sigma_rad);
  int n = 128;
  while (n < wanted * (1 - 1e-5)) n *= 2;  // 10 degrees in float must count as 10 degrees
  return n;
}

void EllipticalTarget::trace(const adaptive::SliceDescription& slice, float a, float b,
                             std::vector<adaptive::TracedRay>& out) const {
  const CrossSection section(slice.key.parameters[0], slice.key.parameters[1], a, b);
  const int n = traced_node_count(slice.key.parameters[2]);
  const std::size_t first = out.size();
  out.reserve(first + static_cast<std::size_t>(n));
  if (trace_midpoints(section, slice.key, n, out) >= 0.05) return;
  out.resize(first);
  trace_midpoints(section, slice.key, 4 * n, out);
}

std::string EllipticalTarget::model_name() const { return "elliptical-1"; }

std::unique_ptr<adaptive::Target> make_elliptical_target() { return std::make_unique<EllipticalTarget>(); }

}  // namespace tress::inline v0_2::fiber
