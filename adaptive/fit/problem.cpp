#include "fit/problem.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

#include "base/pi.h"

namespace tress::inline v0_2::adaptive {
double wrap_near(double x) {
  if (x >= pi) return x - 2 * pi;
  if (x < -pi) return x + 2 * pi;
  return x;
}

Shape shape_at(const Vector& parameters, Eigen::Index at) {
  return {parameters[at + offset_mu], std::exp(parameters[at + offset_log_left]),
          std::exp(parameters[at + offset_log_right])};
}

Problem::Problem(std::span<const ObservedPair> pairs, double energy)
    : energy_(std::isfinite(energy) && energy > 0 ? energy : 0) {
  std::vector<ObservedPair> usable;
  usable.reserve(pairs.size());
  for (const ObservedPair& pair : pairs) {
    if (std::isfinite(pair.azimuth) && std::isfinite(pair.g) && pair.g >= 0) {
      usable.push_back({wrap_angle(pair.azimuth), pair.g});
    }
  }
  if (!std::ranges::is_sorted(usable, {}, &ObservedPair::azimuth)) {
    std::ranges::sort(usable, {}, [](const ObservedPair& pair) { return std::pair(pair.azimuth, pair.g); });
  }
  const std::size_t n = size_ = usable.size();
  azimuth_.resize(padded_size(n));
  g_.resize(padded_size(n));
  cell_.resize(padded_size(n));
  for (std::size_t i = 0; i < n; ++i) {
    azimuth_[i] = usable[i].azimuth;
    g_[i] = usable[i].g;
    const double before = i > 0 ? usable[i - 1].azimuth : usable[n - 1].azimuth - 2 * pi;
    const double after = i + 1 < n ? usable[i + 1].azimuth : usable[0].azimuth + 2 * pi;
    cell_[i] = 0.5 * (after - before);
  }
}

double Problem::objective(const Vector& parameters, std::vector<double>& f) const {
  const auto last = parameters.size() - 1;
  double missing = energy_ - parameters[last];
  f.assign(padded(), parameters[last] / (2 * pi));
  for (Eigen::Index at = 0; at < last; at += per_component) {
    missing -= parameters[at + offset_weight];
    add_density(shape_at(parameters, at), parameters[at + offset_weight], azimuth_.data(), padded(), f.data());
  }
  return missing * missing / (2 * pi) + squared_error(cell_.data(), f.data(), g_.data(), padded());
}

double Problem::linearise(const Vector& parameters, Linearisation& at) const {
  const auto last = parameters.size() - 1;
  at.missing = energy_ - parameters[last];
  at.f.assign(padded(), parameters[last] / (2 * pi));
  at.columns.resize(static_cast<std::size_t>(parameters.size()) * padded());
  for (Eigen::Index c = 0; c < last; c += per_component) {
    at.missing -= parameters[c + offset_weight];
    add_density_and_columns(shape_at(parameters, c), parameters[c + offset_weight], azimuth_.data(), padded(),
                            at.f.data(), at.columns.data() + static_cast<std::size_t>(c) * padded(), padded());
  }
  std::fill_n(at.columns.data() + static_cast<std::size_t>(last) * padded(), padded(), 1 / (2 * pi));
  return at.missing * at.missing / (2 * pi) + squared_error(cell_.data(), at.f.data(), g_.data(), padded());
}

void Problem::normal_equations(Linearisation& at, Eigen::Index count, Square& normal, Vector& gradient) const {
  normal.resize(count, count);
  gradient.resize(count);
  at.scratch.resize(2 * padded());
  adaptive::normal_equations(at.columns.data(), padded(), static_cast<std::size_t>(count), cell_.data(), at.f.data(),
                             g_.data(), padded(), at.scratch.data(), normal.data(), static_cast<std::size_t>(count),
                             gradient.data());
  // The known energy is one more residual, sum a - E, of weight 1/2 pi. The index of a_0 is a multiple of per_component
  // too.
  for (Eigen::Index j = 0; j < count; j += per_component) {
    gradient[j] -= at.missing / (2 * pi);
    for (Eigen::Index i = j; i < count; i += per_component) normal(i, j) += 1 / (2 * pi);
  }
}

Projection Problem::project(const Shape& shape, const std::vector<double>& f) const {
  return adaptive::project(shape, azimuth_.data(), cell_.data(), f.data(), g_.data(), padded());
}

std::array<double, 2> Problem::scale_floors(double mu) const {
  const std::size_t n = size_;
  if (n < 2) return {scale_max, scale_max};
  const auto right = static_cast<std::size_t>(std::ranges::lower_bound(azimuth(), mu) - azimuth().begin());
  const auto distance = [&](std::size_t index) { return std::abs(wrap_near(azimuth_[index % n] - mu)); };
  const auto bounded = [](double d) { return std::clamp(d / 4, scale_min, scale_max); };
  return {bounded(distance(right + 2 * n - 2)), bounded(distance(right + 1))};
}

}  // namespace tress::inline v0_2::adaptive
