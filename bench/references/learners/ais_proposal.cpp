#include "references/learners/ais_proposal.h"

#include <algorithm>
#include <cmath>

#include "base/pi.h"
#include "fit/problem.h"

namespace tress::inline v0_2::adaptive {
namespace {

double value(const AisShape& shape, AisBasis basis, double phi) {
  const double x = basis == AisBasis::circular ? wrap_near(phi - shape.mu) : phi - shape.mu;
  const double e = std::exp(-std::abs(x) / (x < 0 ? shape.left : shape.right));
  return e / ((1 + e) * (1 + e));
}

// The way from mu within which lies the share v of a side's mass: 2 s atanh(v tanh(c/2s)), with 1 - v kept exact.
double way(double v, double scale, double reach) {
  const double e = std::exp(-reach / scale), t = (1 - e) / (1 + e);
  const double below_one = std::max((1 - v) * t + 2 * e / (1 + e), 1e-300);
  return std::min(scale * std::log((1 + v * t) / below_one), reach);
}

double draw(const AisShape& shape, AisBasis basis, double u) {
  const double left = shape.left_mass(basis), right = shape.right_mass(basis);
  const double share = left / (left + right);
  const bool line = basis == AisBasis::line;
  const double x = u < share ? -way(1 - u / share, shape.left, line ? shape.mu + pi : pi)
                             : way(std::min((u - share) / (1 - share), 1.0), shape.right, line ? pi - shape.mu : pi);
  return shape.mu + x;
}

}  // namespace

AisProposal::AisProposal(const AisParts& parts, AisBasis basis, double uniform_share)
    : parts_(parts), basis_(basis), share_(std::clamp(uniform_share, 0.0, 1.0)), mass_(parts.mass(basis)) {
  if (!(mass_ > 0)) share_ = 1;
}

float AisProposal::sample(double u) const {
  const auto uniform = [](double v) { return wrap_angle(static_cast<float>((2 * v - 1) * pi)); };
  if (u < share_) return uniform(u / share_);
  double left = (u - share_) / (1 - share_) * mass_;
  for (std::size_t d = 0; d < parts_.shapes.size(); ++d) {
    const double weight = parts_.a[d] * parts_.shapes[d].mass(basis_);
    if (left < weight) return wrap_angle(static_cast<float>(draw(parts_.shapes[d], basis_, left / weight)));
    left -= weight;
  }
  return uniform(parts_.uniform > 0 ? std::min(left / parts_.uniform, 1.0) : 0.5);
}

double AisProposal::mixture(float phi) const {
  double sum = parts_.uniform / (2 * pi);
  for (std::size_t d = 0; d < parts_.shapes.size(); ++d) {
    if (parts_.a[d] > 0) sum += parts_.a[d] * value(parts_.shapes[d], basis_, phi);
  }
  return sum;
}

double AisProposal::density(float phi) const {
  return share_ / (2 * pi) + (share_ < 1 ? (1 - share_) * mixture(phi) / mass_ : 0);
}

Mixture to_mixture(const AisParts& parts, AisBasis basis, double scale) {
  Mixture mixture;
  const auto weight = [&](double mass) { return static_cast<float>(std::clamp(scale * mass, 0.0, 1e30)); };
  const auto width = [](double s) {
    return std::clamp(static_cast<float>(s), static_cast<float>(scale_min), static_cast<float>(scale_max));
  };
  for (std::size_t d = 0; d < parts.shapes.size() && d < Mixture::max_components; ++d) {
    const AisShape& shape = parts.shapes[d];
    if (!(parts.a[d] > 0)) continue;
    Component& component = mixture.components[mixture.component_count++];
    component.weight = weight(parts.a[d] * shape.mass(basis));
    component.shape = {wrap_angle(static_cast<float>(shape.mu)), width(shape.left), width(shape.right)};
  }
  mixture.uniform_weight = weight(parts.uniform);
  return mixture;
}

}  // namespace tress::inline v0_2::adaptive
