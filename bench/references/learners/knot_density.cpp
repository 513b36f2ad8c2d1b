#include "references/learners/knot_density.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <utility>
#include <vector>

#include "base/pi.h"
#include "density/invert_line.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr float below_one = 0.99999994f;

}  // namespace

KnotDensity::KnotDensity(std::vector<Knot> knots) : knots_(std::move(knots)) {
  assert(is_size(knots_.size()));
  double sum = 0;
  for (const Knot& knot : knots_) sum += static_cast<double>(knot.density);
  energy_ = static_cast<float>(sum * 2 * std::numbers::pi / static_cast<double>(knots_.size()));
  below_.reserve(knots_.size());
  double before = 0;
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    below_.push_back(sum > 0 ? static_cast<float>(before / sum) : 0.0f);
    before += 0.5 * (static_cast<double>(knots_[k].density) + knots_[(k + 1) % knots_.size()].density);
  }
}

float KnotDensity::density(float phi) const {
  if (knots_.empty()) return 0;
  const std::size_t count = knots_.size();
  const float at = (wrap_angle(phi) + pi_f) * (static_cast<float>(count) * inverse_two_pi_f);
  const std::size_t k = std::min(static_cast<std::size_t>(at), count - 1);  // rounding may reach the last end
  const float from = knots_[k].density, to = knots_[(k + 1) & (count - 1)].density;
  return from + (at - static_cast<float>(k)) * (to - from);
}

float KnotDensity::proposal_density(float phi, float u_share) const {
  if (!(energy_ > 0)) return inverse_two_pi_f;
  return (1 - u_share) * density(phi) / energy_ + u_share * inverse_two_pi_f;
}

float KnotDensity::sample(float u, float u_share) const {
  if (!(energy_ > 0)) return wrap_angle(pi_f * (2 * u - 1));
  if (u < u_share) return wrap_angle(pi_f * (2 * u / u_share - 1));
  const float v = (u - u_share) / (1 - u_share);
  const std::size_t count = knots_.size();
  const auto above = std::upper_bound(below_.begin() + 1, below_.end(), v);
  const auto k = static_cast<std::size_t>(std::distance(below_.begin(), above)) - 1;
  const float end = k + 1 < count ? below_[k + 1] : 1.0f;
  const float r = end > below_[k] ? std::clamp((v - below_[k]) / (end - below_[k]), 0.0f, below_one) : 0.5f;
  const float s = invert_line(knots_[k].density, knots_[(k + 1) & (count - 1)].density, r);
  const float x = -pi_f + (static_cast<float>(k) + s) * (2 * pi_f / static_cast<float>(count));
  return wrap_angle(x);
}

}  // namespace tress::inline v0_2::adaptive
