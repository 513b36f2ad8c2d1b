#include "fiber/row_axes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "fiber/quarter_sine.h"
#include "tress/adaptive/mixture.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::fiber {
namespace {

constexpr double quarter_turn = std::numbers::pi / 2;

}  // namespace

float FoldedAzimuth::relative(float phi_i, float phi_r) const { return adaptive::wrap_angle(sign * (phi_i - phi_r)); }

float FoldedAzimuth::absolute(float x, float phi_r) const { return adaptive::wrap_angle(phi_r + sign * x); }

FoldedAzimuth fold_azimuth(float phi_r) {
  constexpr float pi = std::numbers::pi_v<float>;
  float a = adaptive::wrap_angle(phi_r), sign = 1;
  if (a < 0) {
    a = -a;
    sign = -sign;
  }
  if (a > pi / 2) {
    a = pi - a;
    sign = -sign;
  }
  return {std::clamp(a, 0.0f, pi / 2), sign};
}

std::vector<float> azimuth_axis(float eccentricity, float sigma_rad) {
  if (eccentricity >= 1) return {0.0f};
  const double step = std::max(sigma_rad, smallest_grid_sigma) / 3.0;
  // A sigma of whole degrees divides the quarter turn up to rounding: no extra node for that.
  const int steps = std::max(1, static_cast<int>(std::ceil(quarter_turn / step - 1e-3)));
  std::vector<float> axis;
  for (int i = 0; i <= steps; ++i) axis.push_back(static_cast<float>(quarter_turn * i / steps));
  return axis;
}

std::vector<float> inclination_axis() {
  constexpr int uniform_nodes = 26;
  constexpr double last_uniform = 0.04;
  std::vector<double> cosine;
  for (int i = 0; i < uniform_nodes; ++i) cosine.push_back(1 - (1 - last_uniform) * i / (uniform_nodes - 1));
  for (const double c : {0.02, 0.01, std::cos(89.9 * std::numbers::pi / 180)}) cosine.push_back(c);
  std::vector<float> axis;
  for (const double c : cosine) axis.push_back(static_cast<float>(std::acos(c)));
  return axis;
}

adaptive::PageDescription elliptical_page(int page_lobe, float eta, float eccentricity, float sigma_rad) {
  adaptive::PageDescription page;
  page.key.lobe = static_cast<std::uint32_t>(page_lobe);
  page.key.parameters = {eta, eccentricity, sigma_rad};
  page.axis_a = azimuth_axis(eccentricity, sigma_rad);
  page.axis_b = inclination_axis();
  page.blur_rad = sigma_rad;
  return page;
}

RowGrid::RowGrid(const adaptive::PageDescription& page)
    : last_a_(static_cast<std::uint32_t>(page.axis_a.size() - 1)),
      last_b_(static_cast<std::uint32_t>(page.axis_b.size() - 1)),
      steps_per_radian_(static_cast<float>(last_a_ / quarter_turn)) {
  for (const float theta : page.axis_b) cosine_.push_back(quarter_cosine(theta));
  for (std::size_t i = 0; i + 1 < cosine_.size(); ++i) inverse_gap_.push_back(1 / (cosine_[i] - cosine_[i + 1]));
  first_gap_inverse_ = inverse_gap_.empty() ? 0.0f : inverse_gap_.front();
}

std::uint32_t RowGrid::choose_azimuth(float folded_phi, float xi1) const {
  const float at = std::max(folded_phi * steps_per_radian_ + xi1, 0.0f);
  return std::min(static_cast<std::uint32_t>(at), last_a_);
}

std::uint32_t RowGrid::choose_inclination(float theta_d, float xi2) const {
  const float c = quarter_cosine(theta_d);
  // The last node whose cosine is larger than c (0 if none is): a guess by the even part of the axis, then steps.
  const float* cosine = cosine_.data();
  const float guess = (1 - c) * first_gap_inverse_;
  std::uint32_t b = guess > 0 ? std::min(static_cast<std::uint32_t>(static_cast<std::int32_t>(guess)), last_b_) : 0;
  while (b < last_b_ && cosine[b + 1] > c) ++b;
  while (b > 0 && !(cosine[b] > c)) --b;
  if (b == last_b_) return last_b_;
  const float fraction = std::min((cosine[b] - c) * inverse_gap_[b], 1.0f);
  return b + (fraction + xi2 >= 1 ? 1 : 0);
}

}  // namespace tress::fiber
