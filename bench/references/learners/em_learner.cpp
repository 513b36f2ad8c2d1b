#include "references/learners/em_learner.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "base/pi.h"
#include "fit/own_eigen.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double kappa = 0.7;                // of the step (t + 2)^-kappa
constexpr std::uint64_t burn_in_draws = 64;  // teach the statistics before the first M step
constexpr int most_bins = 256;
constexpr int newton_steps = 3;      // a generalised EM: the likelihood grows, the maximum may wait
constexpr double least_mass = 1e-6;  // of a component whose shape is worth a step

double bin_centre(int bin, int bins) { return -pi + (bin + 0.5) * 2 * pi / bins; }

struct LogLikelihood {
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();   ///< by mu, ln s_left, ln s_right
  Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();  ///< minus the Hessian
};

/// Sum of S_b ln p(x_b) over the bins, `mass` the sum of S_b.
LogLikelihood log_likelihood(const Eigen::Vector3d& at, const float* statistic, int bins, double mass) {
  const Shape shape(at[0], std::exp(at[1]), std::exp(at[2]));
  LogLikelihood result;
  for (int b = 0; b < bins; ++b) {
    const double s_b = statistic[b];
    if (!(s_b > 0)) continue;
    const double x = wrap_near(bin_centre(b, bins) - shape.mu);
    const int side = x < 0 ? 1 : 2;
    const double s = x < 0 ? shape.left : shape.right;
    const double sign = x < 0 ? -1 : 1;
    const double y = std::abs(x) / s;
    const double e = std::exp(-y);
    const double t = (1 - e) / (1 + e);
    const double k = 2 * e / ((1 + e) * (1 + e));  // dt/dy
    result.value += s_b * (-y - 2 * std::log1p(e));
    result.gradient[0] += sign * s_b * t / s;
    result.gradient[side] += s_b * y * t;
    result.curvature(0, 0) += s_b * k / (s * s);
    result.curvature(side, side) += s_b * (y * t + y * y * k);
    result.curvature(0, side) += sign * s_b * (t + k * y) / s;
  }
  result.value += mass * std::log(shape.inverse_z);
  const double l = shape.log_z_left, r = shape.log_z_right;
  result.gradient[1] -= mass * l;
  result.gradient[2] -= mass * r;
  result.curvature(1, 1) += mass * l * (1 - l);
  result.curvature(2, 2) += mass * r * (1 - r);
  result.curvature(1, 2) -= mass * l * r;
  result.curvature.triangularView<Eigen::StrictlyLower>() = result.curvature.transpose();
  return result;
}

}  // namespace

std::size_t EmLearner::bytes() const {
  return sizeof(*this) + sizeof(float) * most_bins * (Mixture::max_components + 1);
}

void EmLearner::begin(FitContext& context) {
  const int components = context.components;
  bins_ = std::min<int>(static_cast<int>(Sketch::bin_count(context.nodes.blur_rad())), most_bins);
  parameters_ = starting_parameters(context, components, context.has_fit ? &context.fit : nullptr);
  statistics_.assign(static_cast<std::size_t>(components + 1) * static_cast<std::size_t>(bins_), 0.0f);
  const Mixture start = mixture_of(parameters_, context.nodes.energy());
  expect(replay(context, start, burn_in_draws), 1);
  maximise(context.nodes.energy());
  context.publish(mixture_of(parameters_, context.nodes.energy()));
}

void EmLearner::learn(FitContext& context) {
  if (context.own_draws == 0) return;
  expect(replay(context, context.fit, context.own_draws), std::pow(static_cast<double>(++batches_) + 2, -kappa));
  maximise(context.nodes.energy());
  context.publish(mixture_of(parameters_, context.nodes.energy()));
}

void EmLearner::expect(const std::vector<WeightedDraw>& draws, double step) {
  if (draws.empty()) return;
  for (float& value : statistics_) value *= static_cast<float>(1 - step);
  Vector gradient;
  const auto last = parameters_.size() - 1;
  for (const WeightedDraw& draw : draws) {
    const double f = density_and_gradient(parameters_, draw.azimuth, gradient);
    if (!(f > 0) || !(draw.q > 0)) continue;
    const double weight = step * draw.g / draw.q / static_cast<double>(draws.size()) / f;
    const int bin =
        std::clamp(static_cast<int>((static_cast<double>(draw.azimuth) + pi) / (2 * pi) * bins_), 0, bins_ - 1);
    for (Eigen::Index at = 0; at <= last; at += per_component) {
      const std::size_t row = static_cast<std::size_t>(at / per_component) * static_cast<std::size_t>(bins_);
      statistics_[row + static_cast<std::size_t>(bin)] += static_cast<float>(weight * parameters_[at] * gradient[at]);
    }
  }
}

void EmLearner::maximise(double energy) {
  double sum = 0;
  const auto last = parameters_.size() - 1;
  for (Eigen::Index at = 0; at <= last; at += per_component) {
    const float* statistic =
        statistics_.data() + static_cast<std::size_t>(at / per_component) * static_cast<std::size_t>(bins_);
    double mass = 0;
    for (int b = 0; b < bins_; ++b) mass += statistic[b];
    parameters_[at] = mass;
    sum += mass;
    if (at < last && mass > least_mass * energy) maximise_shape(at, mass);
  }
  if (sum > 0) {
    for (Eigen::Index at = 0; at <= last; at += per_component) parameters_[at] *= energy / sum;
  }
}

void EmLearner::maximise_shape(Eigen::Index at, double mass) {
  const float* statistic =
      statistics_.data() + static_cast<std::size_t>(at / per_component) * static_cast<std::size_t>(bins_);
  // No narrower than half a bin, whose azimuths are rounded.
  const double least = std::log(std::max(scale_min, pi / bins_));
  Eigen::Vector3d shape = parameters_.segment<3>(at + offset_mu);
  LogLikelihood here = log_likelihood(shape, statistic, bins_, mass);
  double damping = 1e-3;
  for (int i = 0; i < newton_steps; ++i) {
    bool better = false;
    for (int tries = 0; tries < 6 && !better; ++tries, damping *= 8) {
      Eigen::Matrix3d damped = here.curvature;
      damped.diagonal() += damping * here.curvature.diagonal().cwiseAbs() + Eigen::Vector3d::Constant(1e-9 * mass);
      const Eigen::LLT<Eigen::Matrix3d> factors(damped);
      if (factors.info() != Eigen::Success) continue;
      const Eigen::Vector3d step = factors.solve(here.gradient);
      Eigen::Vector3d trial = shape;
      trial[0] = wrap_near(shape[0] + std::clamp(step[0], -0.6, 0.6));
      for (int side = 1; side < 3; ++side) {
        trial[side] = std::clamp(shape[side] + std::clamp(step[side], -0.7, 0.7), least, std::log(scale_max));
      }
      const LogLikelihood there = log_likelihood(trial, statistic, bins_, mass);
      if (there.value > here.value) {
        shape = trial;
        here = there;
        better = true;
      }
    }
    if (!better) break;
    damping = std::max(damping / 64, 1e-6);
  }
  parameters_.segment<3>(at + offset_mu) = shape;
}

std::optional<std::vector<std::uint64_t>> EmLearner::state() const {
  std::vector<std::uint64_t> words{batches_, static_cast<std::uint64_t>(bins_)};
  append_vector(parameters_, words);
  for (const float statistic : statistics_) words.push_back(std::bit_cast<std::uint32_t>(statistic));
  return words;
}

bool EmLearner::set_state(std::span<const std::uint64_t> words) {
  if (words.size() < 2 || words[1] == 0 || words[1] > most_bins) return false;
  batches_ = words[0];
  bins_ = static_cast<int>(words[1]);
  words = words.subspan(2);
  if (!take_vector(words, parameters_)) return false;
  const auto components = static_cast<std::size_t>(parameters_.size() / per_component);
  if (words.size() != (components + 1) * static_cast<std::size_t>(bins_)) return false;
  statistics_.clear();
  for (const std::uint64_t word : words) {
    const auto statistic = std::bit_cast<float>(static_cast<std::uint32_t>(word));
    if (word >> 32 != 0 || !std::isfinite(statistic)) return false;
    statistics_.push_back(statistic);
  }
  return true;
}

}  // namespace tress::inline v0_2::adaptive
