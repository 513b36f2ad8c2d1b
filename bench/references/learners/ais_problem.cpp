#include "references/learners/ais_problem.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/pi.h"
#include "fit/kernels.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double inverse_two_pi = 0.5 * std::numbers::inv_pi;
constexpr double least_f = 1e-30;  // a logarithm's argument

double dot(const double* a, const double* b, std::size_t n) {
  const auto size = static_cast<Eigen::Index>(n);
  return Eigen::Map<const Eigen::VectorXd>(a, size).dot(Eigen::Map<const Eigen::VectorXd>(b, size));
}

}  // namespace

double AisParts::mass(AisBasis basis) const {
  double sum = uniform;
  for (std::size_t d = 0; d < shapes.size(); ++d) sum += a[d] * shapes[d].mass(basis);
  return sum;
}

void AisProblem::set_sample(const std::vector<double>& azimuth, const std::vector<double>& g,
                            const std::vector<double>& cells, double g_end) {
  samples_ = azimuth.size();
  end_weight_ = basis_ == AisBasis::line ? tau_ * g_end : 0;
  stride_ = padded_size(samples_ + 3);
  const auto copy = [&](std::vector<double>& to, const std::vector<double>& from) {
    to.assign(stride_, 0.0);
    std::ranges::copy(from, to.begin());
  };
  copy(azimuth_, azimuth);
  copy(g_, g);
  copy(cells_, cells);
  azimuth_[samples_] = -pi;
  azimuth_[samples_ + 1] = pi;
  slope_.assign(stride_, 0.0);
  curvature_.assign(stride_, 0.0);
  if (!parts_.shapes.empty()) set_parts(AisParts(parts_));
}

void AisProblem::fill(Place& place, std::size_t d, const AisShape& shape) const {
  double* p = place.p.data() + d * stride_;
  double* first = place.first.data() + ais_first * d * stride_;
  ais_columns(shape, basis_, azimuth_.data(), stride_, p, first, place.second.data() + ais_second * d * stride_,
              stride_);
  // The difference of the ends has a row of its own: no second derivatives, but all of the curvature.
  const auto difference = [&](double* column) { column[samples_ + 2] = column[samples_ + 1] - column[samples_]; };
  difference(p);
  for (std::size_t j = 0; j < ais_first; ++j) difference(first + j * stride_);
}

double AisProblem::sum_up(Place& place, const AisParts& parts) const {
  const auto n = static_cast<Eigen::Index>(stride_);
  place.f.resize(stride_);
  Eigen::Map<Eigen::VectorXd> f(place.f.data(), n);
  f = parts.uniform * Eigen::Map<const Eigen::VectorXd>(p_column(place, count()), n);
  for (std::size_t d = 0; d < count(); ++d) {
    if (parts.a[d] > 0) f += parts.a[d] * Eigen::Map<const Eigen::VectorXd>(p_column(place, d), n);
  }
  const double difference = place.f[samples_ + 2];
  double sum = end_weight_ * difference * difference;
  if (distance_ == AisDistance::l2) return sum + squared_error(cells_.data(), place.f.data(), g_.data(), stride_);
  for (std::size_t i = 0; i < samples_; ++i) {
    const double at = std::max(place.f[i], least_f);
    sum += cells_[i] * ((g_[i] > 0 ? g_[i] * std::log(g_[i] / at) : 0.0) - g_[i] + at);
  }
  return sum;
}

void AisProblem::set_parts(const AisParts& parts) {
  parts_ = parts;
  for (Place* place : {&here_, &there_}) {
    place->p.assign((count() + 1) * stride_, 0.0);
    place->first.resize(ais_first * count() * stride_);
    place->second.resize(ais_second * count() * stride_);
    double* uniform = place->p.data() + count() * stride_;
    std::fill_n(uniform, samples_ + 2, inverse_two_pi);
  }
  for (std::size_t d = 0; d < count(); ++d) fill(here_, d, parts_.shapes[d]);
  there_ = here_;
  objective_ = sum_up(here_, parts_);
  differentiate();
}

void AisProblem::differentiate() {
  for (std::size_t i = 0; i < samples_; ++i) {
    if (distance_ == AisDistance::l2) {
      slope_[i] = 2 * cells_[i] * (here_.f[i] - g_[i]);
      curvature_[i] = 2 * cells_[i];
    } else {
      const double ratio = g_[i] / std::max(here_.f[i], least_f);
      slope_[i] = cells_[i] * (1 - ratio);
      curvature_[i] = cells_[i] * ratio / std::max(here_.f[i], least_f);
    }
  }
  const double difference = here_.f[samples_ + 2];
  slope_[samples_] = -2 * end_weight_ * difference;
  slope_[samples_ + 1] = 2 * end_weight_ * difference;
  curvature_[samples_ + 2] = 2 * end_weight_;
}

Eigen::MatrixXd AisProblem::gram(const double* columns, std::size_t columns_count) const {
  const auto n = static_cast<Eigen::Index>(columns_count);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd unused(n);
  scratch_.resize(2 * stride_);
  normal_equations(columns, stride_, columns_count, curvature_.data(), g_.data(), g_.data(), stride_, scratch_.data(),
                   matrix.data(), columns_count, unused.data());
  return matrix.selfadjointView<Eigen::Lower>();
}

Eigen::VectorXd AisProblem::shape_gradient(AisRange range) const {
  Eigen::VectorXd gradient(static_cast<Eigen::Index>(ais_first * (range.last - range.first)));
  Eigen::Index out = 0;
  for (std::size_t d = range.first; d < range.last; ++d) {
    for (std::size_t j = 0; j < ais_first; ++j) {
      const double* column = here_.first.data() + (ais_first * d + j) * stride_;
      gradient[out++] = parts_.a[d] * dot(slope_.data(), column, stride_);
    }
  }
  return gradient;
}

Eigen::MatrixXd AisProblem::shape_hessian(AisRange range, bool exact) const {
  const std::size_t size = range.last - range.first;
  Eigen::MatrixXd hessian = gram(here_.first.data() + ais_first * range.first * stride_, ais_first * size);
  for (std::size_t d = 0; d < size; ++d) {
    const double a = parts_.a[range.first + d];
    const auto at = static_cast<Eigen::Index>(ais_first * d);
    hessian.middleRows<3>(at) *= a;
    hessian.middleCols<3>(at) *= a;
    if (!exact) continue;
    constexpr Eigen::Index place[ais_second][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {2, 2}};
    for (std::size_t j = 0; j < ais_second; ++j) {
      const double* column = here_.second.data() + (ais_second * (range.first + d) + j) * stride_;
      const double bend = a * dot(slope_.data(), column, stride_);
      hessian(at + place[j][0], at + place[j][1]) += bend;
      if (place[j][0] != place[j][1]) hessian(at + place[j][1], at + place[j][0]) += bend;
    }
  }
  return hessian;
}

Eigen::VectorXd AisProblem::shape_curvature(AisRange range) const {
  Eigen::VectorXd diagonal(static_cast<Eigen::Index>(ais_first * (range.last - range.first)));
  const auto n = static_cast<Eigen::Index>(stride_);
  const Eigen::Map<const Eigen::VectorXd> curvature(curvature_.data(), n);
  Eigen::Index out = 0;
  for (std::size_t d = range.first; d < range.last; ++d) {
    for (std::size_t j = 0; j < ais_first; ++j) {
      const Eigen::Map<const Eigen::VectorXd> column(here_.first.data() + (ais_first * d + j) * stride_, n);
      diagonal[out++] = parts_.a[d] * parts_.a[d] * column.cwiseAbs2().dot(curvature);
    }
  }
  return diagonal;
}

Eigen::VectorXd AisProblem::weight_gradient(AisRange range) const {
  Eigen::VectorXd gradient(static_cast<Eigen::Index>(range.last - range.first + (range.uniform ? 1 : 0)));
  Eigen::Index out = 0;
  for (std::size_t d = range.first; d < range.last; ++d)
    gradient[out++] = dot(slope_.data(), p_column(here_, d), stride_);
  if (range.uniform) gradient[out] = dot(slope_.data(), p_column(here_, count()), stride_);
  return gradient;
}

Eigen::MatrixXd AisProblem::weight_hessian(AisRange range) const {
  const std::size_t size = range.last - range.first;
  if (!range.uniform || range.last == count())
    return gram(p_column(here_, range.first), size + (range.uniform ? 1 : 0));
  return gram(p_column(here_, count()), 1);  // a_0 alone
}

bool AisProblem::try_shapes(AisRange range, const std::vector<AisShape>& shapes) {
  AisParts trial = parts_;
  for (std::size_t d = range.first; d < range.last; ++d) {
    trial.shapes[d] = shapes[d - range.first];
    fill(there_, d, trial.shapes[d]);
  }
  const double reached = sum_up(there_, trial);
  const bool better = reached < objective_;
  Place& from = better ? there_ : here_;
  Place& to = better ? here_ : there_;
  const auto copy = [&](std::vector<double> Place::* member, std::size_t columns) {
    const auto begin = static_cast<std::ptrdiff_t>(columns * range.first * stride_);
    const auto end = static_cast<std::ptrdiff_t>(columns * range.last * stride_);
    std::copy((from.*member).begin() + begin, (from.*member).begin() + end, (to.*member).begin() + begin);
  };
  copy(&Place::p, 1);
  copy(&Place::first, ais_first);
  copy(&Place::second, ais_second);
  if (!better) return false;
  here_.f = there_.f;
  parts_ = std::move(trial);
  objective_ = reached;
  differentiate();
  return true;
}

bool AisProblem::try_weights(AisRange range, const Eigen::VectorXd& a) {
  AisParts trial = parts_;
  Eigen::Index in = 0;
  for (std::size_t d = range.first; d < range.last; ++d) trial.a[d] = a[in++];
  if (range.uniform) trial.uniform = a[in];
  const double reached = sum_up(there_, trial);
  if (!(reached <= objective_)) return false;
  std::swap(here_.f, there_.f);
  parts_ = std::move(trial);
  objective_ = reached;
  differentiate();
  return true;
}

std::size_t AisProblem::largest_shortfall() const {
  std::size_t best = 0;
  double largest = -1;
  for (std::size_t i = 0; i < samples_; ++i) {
    const double shortfall = cells_[i] * (g_[i] - here_.f[i]);
    if (shortfall > largest) {
      largest = shortfall;
      best = i;
    }
  }
  return best;
}

}  // namespace tress::inline v0_2::adaptive
