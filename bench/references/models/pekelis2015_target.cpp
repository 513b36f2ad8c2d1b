#include "references/models/pekelis2015_target.h"

#include <algorithm>
#include <cmath>

#include "base/pi.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr double angle_step = 2 * degree;
constexpr std::uint32_t nodes = 46;
constexpr float blur = static_cast<float>(1 * degree);
constexpr int rays = 720;
constexpr std::array<float, 4> eccentricities{0.85f, 0.9f, 0.95f, 1.0f};
constexpr std::array<float, 4> sigmas_deg{10, 15, 20, 25};
constexpr std::array<std::uint32_t, 2> slice_lobes{2, 5};  // TRT, GLINT

float nearest(const std::array<float, 4>& values, float x) {
  return *std::ranges::min_element(values, {}, [x](float value) { return std::abs(value - x); });
}

}  // namespace

float nearest_pekelis_eccentricity(float eccentricity) { return nearest(eccentricities, eccentricity); }

float nearest_pekelis_sigma(float sigma_rad) {
  return nearest(sigmas_deg, sigma_rad / static_cast<float>(degree)) * static_cast<float>(degree);
}

adaptive::SliceDescription pekelis_slice(MarschnerLobe lobe, float eta, float eccentricity, float sigma_rad) {
  adaptive::SliceDescription slice;
  slice.key = {slice_lobes[lobe == MarschnerLobe::glint ? 1 : 0], {eta, eccentricity, sigma_rad}};
  const bool round = eccentricity >= 1;
  for (std::uint32_t i = 0; i < (round ? 1 : nodes); ++i) slice.axis_a.push_back(static_cast<float>(i * angle_step));
  for (std::uint32_t i = 0; i < (round ? nodes - 1 : nodes); ++i) {
    slice.axis_b.push_back(static_cast<float>(i * angle_step));
  }
  slice.blur_rad = blur;
  slice.max_components = lobe == MarschnerLobe::glint ? 3 : 5;
  return slice;
}

PekelisNode nearest_pekelis_node(const adaptive::SliceDescription& slice, float folded_phi_r, float theta_d) {
  const auto on = [](const std::vector<float>& axis, float x) {
    const auto i = static_cast<std::uint32_t>(std::lround(std::abs(x) / static_cast<float>(angle_step)));
    return std::min(i, static_cast<std::uint32_t>(axis.size()) - 1);
  };
  return {on(slice.axis_a, folded_phi_r), on(slice.axis_b, theta_d)};
}

double pekelis_curve(const adaptive::SliceKey& slice, double phi_r, double theta_d, double phi) {
  MarschnerShape shape{static_cast<double>(slice.parameters[0]), static_cast<double>(slice.parameters[1]), {}};
  shape.caustics.width = static_cast<double>(slice.parameters[2]);
  const MarschnerLobe lobe = slice.lobe == slice_lobes[1] ? MarschnerLobe::glint : MarschnerLobe::trt;
  const MarschnerPaths paths = marschner_paths(shape, lobe, phi_r, theta_d, phi);
  double density = 0;
  for (std::size_t k = 0; k < paths.count; ++k) density += paths.path[k].density;
  return density;
}

void PekelisTarget::trace(const adaptive::SliceDescription& slice, float a, float b,
                          std::vector<adaptive::TracedRay>& out) const {
  constexpr double step = 2 * pi / rays;
  for (int i = 0; i < rays; ++i) {
    const double phi = -pi + (i + 0.5) * step;
    const double density = pekelis_curve(slice.key, static_cast<double>(a), static_cast<double>(b), phi);
    if (density > 0) out.push_back({static_cast<float>(phi), static_cast<float>(density * step), 0});
  }
}

}  // namespace tress::inline v0_2::fiber
