#include "learner/problem.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace tress::adaptive {
namespace {

constexpr double pi = std::numbers::pi;

// exp(x), x <= 0, relative error 1e-11, no call; stays at exp(-700) below.
inline double exp_negative(double x) {
  x = x < -700 ? -700 : x;
  const auto n = static_cast<std::int64_t>(x * std::numbers::log2e - 0.5);
  const double r = x - static_cast<double>(n) * std::numbers::ln2;
  const double low = 1 + r * (1 + r * (1. / 2 + r * (1. / 6 + r * (1. / 24))));
  const double r2 = r * r;
  const double high = 1. / 120 + r * (1. / 720 + r * (1. / 5040 + r * (1. / 40320 + r * (1. / 362880))));
  return (low + r2 * r2 * r * high) * std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52);
}

}  // namespace

double wrap_near(double x) {
  if (x >= pi) return x - 2 * pi;
  if (x < -pi) return x + 2 * pi;
  return x;
}

Shape::Shape(double scale_left, double scale_right) : left(scale_left), right(scale_right) {
  const double t_left = std::tanh(pi / (2 * left));
  const double t_right = std::tanh(pi / (2 * right));
  const double twice_z = left * t_left + right * t_right;
  inverse_z = 2 / twice_z;
  log_z_left = (left * t_left - (1 - t_left * t_left) * pi / 2) / twice_z;
  log_z_right = (right * t_right - (1 - t_right * t_right) * pi / 2) / twice_z;
}

Shape::Value Shape::value(double x) const {
  const bool on_left = x < 0;
  const double s = on_left ? left : right;
  const double y = std::abs(x) / s;
  const double e = exp_negative(-y);
  const double inverse = 1 / (1 + e);
  const double t = (1 - e) * inverse;
  const double p = e * inverse * inverse * inverse_z;
  const double slope = p * t / s;
  const double widening = p * y * t;
  return {p, on_left ? -slope : slope, (on_left ? widening : 0) - p * log_z_left,
          (on_left ? 0 : widening) - p * log_z_right};
}

double Shape::density(double x) const {
  const double e = exp_negative(-std::abs(x) / (x < 0 ? left : right));
  return e / ((1 + e) * (1 + e)) * inverse_z;
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
    std::ranges::stable_sort(usable, {}, &ObservedPair::azimuth);
  }
  const std::size_t n = usable.size();
  azimuth_.resize(n);
  g_.resize(n);
  cell_.resize(n);
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
  f.assign(azimuth_.size(), parameters[last] / (2 * pi));
  for (Eigen::Index at = 0; at < last; at += per_component) {
    const Shape shape(std::exp(parameters[at + offset_log_left]), std::exp(parameters[at + offset_log_right]));
    const double weight = parameters[at + offset_weight];
    const double mu = parameters[at + offset_mu];
    missing -= weight;
    for (std::size_t i = 0; i < f.size(); ++i) f[i] += weight * shape.density(wrap_near(azimuth_[i] - mu));
  }
  double sum = missing * missing / (2 * pi);
  for (std::size_t i = 0; i < f.size(); ++i) sum += cell_[i] * (f[i] - g_[i]) * (f[i] - g_[i]);
  return sum;
}

double Problem::linearise(const Vector& parameters, Square& normal, Vector& gradient) const {
  const auto count = parameters.size();
  const auto last = count - 1;
  std::vector<Shape> shapes;
  shapes.reserve(Mixture::max_components);
  double missing = energy_ - parameters[last];
  for (Eigen::Index at = 0; at < last; at += per_component) {
    shapes.emplace_back(std::exp(parameters[at + offset_log_left]), std::exp(parameters[at + offset_log_right]));
    missing -= parameters[at + offset_weight];
  }
  normal.setZero(count, count);
  gradient.setZero(count);
  double sum = missing * missing / (2 * pi);
  std::array<double, max_parameters> row;
  row[static_cast<std::size_t>(last)] = 1 / (2 * pi);
  const auto add_row = [&](double weight, double residual) {
    for (Eigen::Index j = 0; j < count; ++j) {
      const double scaled = weight * row[static_cast<std::size_t>(j)];
      gradient[j] += scaled * residual;
      double* column = &normal(0, j);
      for (Eigen::Index i = j; i < count; ++i) column[i] += scaled * row[static_cast<std::size_t>(i)];
    }
  };
  for (std::size_t i = 0; i < azimuth_.size(); ++i) {
    double f = parameters[last] / (2 * pi);
    for (std::size_t d = 0; d < shapes.size(); ++d) {
      const auto at = static_cast<Eigen::Index>(per_component * d);
      const double weight = parameters[at + offset_weight];
      const Shape::Value v = shapes[d].value(wrap_near(azimuth_[i] - parameters[at + offset_mu]));
      double* entry = row.data() + per_component * d;
      entry[offset_weight] = v.p;
      entry[offset_mu] = weight * v.d_mu;
      entry[offset_log_left] = weight * v.d_log_left;
      entry[offset_log_right] = weight * v.d_log_right;
      f += weight * v.p;
    }
    const double residual = f - g_[i];
    sum += cell_[i] * residual * residual;
    add_row(cell_[i], residual);
  }
  // The known energy: one more residual, sum a - E, of weight 1/2 pi.
  row.fill(0);
  for (std::size_t d = 0; d < shapes.size(); ++d) row[per_component * d + offset_weight] = 1;
  row[static_cast<std::size_t>(last)] = 1;
  add_row(1 / (2 * pi), -missing);
  return sum;
}

std::array<double, 2> Problem::scale_floors(double mu) const {
  const std::size_t n = azimuth_.size();
  if (n < 2) return {scale_max, scale_max};
  const auto right = static_cast<std::size_t>(std::ranges::lower_bound(azimuth_, mu) - azimuth_.begin());
  const auto distance = [&](std::size_t index) { return std::abs(wrap_near(azimuth_[index % n] - mu)); };
  const auto bounded = [](double d) { return std::clamp(d / 4, scale_min, scale_max); };
  return {bounded(distance(right + 2 * n - 2)), bounded(distance(right + 1))};
}

}  // namespace tress::adaptive
