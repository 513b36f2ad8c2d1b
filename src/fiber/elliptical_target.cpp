#include "fiber/elliptical_target.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "fiber/cross_section.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::fiber {
namespace {

/// Appends n midpoint rays of order p; returns their mass.
double trace_midpoints(const CrossSection& section, int p, int n, std::vector<adaptive::TracedRay>& out) {
  const double cos_phi = std::cos(section.phi_r), sin_phi = std::sin(section.phi_r);
  const double share = 1.0 / n;
  double mass = 0, path_left;
  for (int i = 0; i < n; ++i) {
    const double h = (2 * i + 1) * share - 1;
    section.follow(h, p, 0, &path_left, [&](int order, double weight, double x, double y, double path) {
      if (order != p) return;
      // The exit seen from the known direction: one atan2 a ray.
      const double across = cos_phi * y - sin_phi * x, along = cos_phi * x + sin_phi * y;
      mass += weight * share;
      out.push_back({std::atan2(static_cast<float>(across), static_cast<float>(along)),
                     static_cast<float>(weight * share), static_cast<float>(path)});
    });
  }
  return mass;
}

}  // namespace

int traced_node_count(float sigma_rad) {
  const double wanted = 128 * std::max(1.0, 20 * std::numbers::pi / 180 / sigma_rad);
  int n = 128;
  while (n < wanted * (1 - 1e-5)) n *= 2;  // 10 degrees in float is 10 degrees
  return n;
}

void EllipticalTarget::trace(const adaptive::PageDescription& page, float a, float b,
                             std::vector<adaptive::TracedRay>& out) const {
  const auto p = static_cast<int>(page.key.lobe);
  const CrossSection section(page.key.parameters[0], page.key.parameters[1], a, b);
  const int n = traced_node_count(page.key.parameters[2]);
  const std::size_t first = out.size();
  if (trace_midpoints(section, p, n, out) >= 0.05) return;
  out.resize(first);
  trace_midpoints(section, p, 4 * n, out);
}

std::string EllipticalTarget::model_name() const { return "elliptical-1"; }

std::unique_ptr<adaptive::Target> make_elliptical_target() { return std::make_unique<EllipticalTarget>(); }

}  // namespace tress::fiber
