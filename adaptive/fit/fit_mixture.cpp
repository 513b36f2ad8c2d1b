#include "fit/fit_mixture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/pi.h"
#include "fit/problem.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr int warm_iterations = 8;
constexpr int grown_iterations = 12;
constexpr double least_weight = 2e-4;     // components of less weight are removed
constexpr double growth_must_pay = 0.85;  // factor on o/(N-4D-1)^2 that a new component must reach
constexpr double split_must_pay = 0.95;
constexpr int most_splits = 2;
constexpr int candidates = 6;
constexpr std::array candidate_scales{.04, .08, .16, .32, .5};

int component_count(const Vector& v) { return static_cast<int>(v.size() / per_component); }

Vector with_component(const Vector& v, double weight, double mu, double left, double right) {
  const auto last = v.size() - 1;
  Vector grown(v.size() + per_component);
  grown.head(last) = v.head(last);
  grown.segment<per_component>(last) << weight, mu, std::log(left), std::log(right);
  grown[last + per_component] = v[last];
  return grown;
}

Vector without_component(const Vector& v, Eigen::Index at) {
  Vector kept(v.size() - per_component);
  kept << v.head(at), v.tail(v.size() - at - per_component);
  return kept;
}

Mixture to_mixture(const Vector& v) {
  return mixture_from(v, [](double a) { return static_cast<float>(std::clamp(a, 0.0, 1e30)); });
}

// The current state of a fit: its parameters and their objective o.
struct State {
  Vector parameters;
  double o = 0;
};

class MixtureFitter {
 public:
  MixtureFitter(const Problem& problem, double variation, const FitSettings& settings)
      : problem_(problem),
        variation_(std::max(std::isfinite(variation) ? variation : 0.0, 1e-3 / (2 * pi))),
        settings_(settings),
        most_components_(std::clamp(settings.max_components, 0, Mixture::max_components)) {}

  State run(const Mixture* warm) {
    State state;
    state.parameters = Vector::Constant(1, problem_.energy());
    state.o = problem_.objective(state.parameters, f_);
    if (warm != nullptr) {
      State started = from_mixture(*warm);
      optimise(started, warm_iterations);
      if (criterion(started) < criterion(state)) state = started;
    }
    for (int splits = 0; grow(state) && splits < most_splits; ++splits) {
      if (!replace_if_it_pays(state, split(state), split_must_pay)) break;
    }
    return state;
  }

  // Returns R: the objective expected on fresh samples (generalised cross validation), relative to the variation.
  double relative(const State& state) const {
    if (problem_.size() == 0) return std::numeric_limits<double>::infinity();
    return criterion(state) * problem_.size() * problem_.size() / variation_;
  }

  bool reached(const State& state) const { return relative(state) <= settings_.epsilon / 4; }

  // Scales the weights to the known energy and removes components that are too small.
  void finish(State& state) {
    const double sum = weight_sum(state.parameters);
    if (sum > 0 && std::isfinite(sum)) {
      for (Eigen::Index at = 0; at < state.parameters.size(); at += per_component) {
        state.parameters[at] *= problem_.energy() / sum;
      }
    } else {
      state.parameters = Vector::Constant(1, problem_.energy());
    }
    state.o = problem_.objective(state.parameters, f_);
  }

 private:
  // The index of a_0 is a multiple of per_component too, so the sum includes it.
  static double weight_sum(const Vector& v) {
    double sum = 0;
    for (Eigen::Index at = 0; at < v.size(); at += per_component) sum += v[at];
    return sum;
  }

  double criterion(const State& state) const {
    const double freedom = std::max(problem_.size() - 4.0 * component_count(state.parameters) - 1, 1.0);
    return state.o / (freedom * freedom);
  }

  bool room_for_one_more(const State& state) const {
    const int next = component_count(state.parameters) + 1;
    return next <= most_components_ && problem_.size() >= 2 * (4 * next + 1);
  }

  State from_mixture(const Mixture& mixture) const {
    State state;
    state.parameters = Vector::Constant(1, std::max(0.0f, mixture.uniform_weight));
    for (const Component& part : mixture.parts()) {
      if (component_count(state.parameters) == most_components_) break;
      if (!(part.weight > 0)) continue;
      const auto scale = [](float s) { return std::clamp(static_cast<double>(s), scale_min, scale_max); };
      state.parameters = with_component(state.parameters, part.weight, wrap_angle(part.shape.mu),
                                        scale(part.shape.s_left), scale(part.shape.s_right));
    }
    return state;
  }

  // Drops components that have faded, so that the criterion no longer counts their parameters.
  void optimise(State& state, int iterations) {
    state.o = levenberg_marquardt(problem_, state.parameters, iterations, work_);
    const auto before = state.parameters.size();
    for (Eigen::Index at = state.parameters.size() - 1 - per_component; at >= 0; at -= per_component) {
      if (state.parameters[at + offset_weight] >= least_weight) continue;
      state.parameters[state.parameters.size() - 1] += state.parameters[at + offset_weight];
      state.parameters = without_component(state.parameters, at);
    }
    if (state.parameters.size() != before) state.o = problem_.objective(state.parameters, f_);
  }

  bool replace_if_it_pays(State& state, State trial, double factor) {
    if (trial.parameters.size() == 0) return false;
    optimise(trial, grown_iterations);
    if (!(criterion(trial) < factor * criterion(state))) return false;
    state = std::move(trial);
    return true;
  }

  // Adds components while they pay. True if there is still error and room for one more.
  bool grow(State& state) {
    while (!reached(state)) {
      if (!room_for_one_more(state)) return false;
      if (!replace_if_it_pays(state, pursue(state), growth_must_pay)) return true;
    }
    return false;
  }

  // Matching pursuit: adds the symmetric component that explains most, at one of the largest positive residuals. Empty
  // without such a residual.
  State pursue(const State& state) {
    problem_.objective(state.parameters, f_);
    const auto n = static_cast<std::size_t>(problem_.size());
    order_.resize(n);
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    const auto residual = [&](std::size_t i) { return problem_.g()[i] - f_[i]; };
    const auto tried = std::min<std::size_t>(candidates, n);
    std::partial_sort(
        order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(tried), order_.end(),
        [&](std::size_t a, std::size_t b) { return residual(a) != residual(b) ? residual(a) > residual(b) : a < b; });
    double best_gain = 0;
    State best;
    for (const double scale : candidate_scales) {
      for (std::size_t c = 0; c < tried && residual(order_[c]) > 0; ++c) {
        const double mu = problem_.azimuth()[order_[c]];
        const auto [explained, power] = problem_.project(Shape(mu, scale, scale), f_);
        if (!(explained > 0 && power > 0) || explained * explained / power <= best_gain) continue;
        best_gain = explained * explained / power;
        best.parameters = with_component(state.parameters, explained / power, mu, scale, scale);
      }
    }
    return best;
  }

  // Splits the component that contributes most of the squared error. Empty if no component can be split.
  State split(const State& state) {
    problem_.objective(state.parameters, f_);
    double worst_error = 0;
    Eigen::Index worst = -1;
    for (Eigen::Index at = 0; at + 1 < state.parameters.size(); at += per_component) {
      p_.assign(problem_.padded(), 0);
      add_density(shape_at(state.parameters, at), state.parameters[at + offset_weight], problem_.azimuth().data(),
                  problem_.padded(), p_.data());
      double error = 0;
      for (std::size_t i = 0; i < problem_.azimuth().size(); ++i) {
        if (!(f_[i] > 0)) continue;
        const double r = problem_.g()[i] - f_[i];
        error += problem_.cell()[i] * r * r * p_[i] / f_[i];
      }
      if (error > worst_error) {
        worst_error = error;
        worst = at;
      }
    }
    State result;
    if (worst < 0) return result;
    const double weight = state.parameters[worst + offset_weight] / 2;
    const double mu = state.parameters[worst + offset_mu];
    const double left = std::exp(state.parameters[worst + offset_log_left]);
    const double right = std::exp(state.parameters[worst + offset_log_right]);
    const double narrower = std::exp(-0.2);
    const auto child = [&](const Vector& v, double at) {
      return with_component(v, weight, wrap_near(at), std::max(left * narrower, scale_min),
                            std::max(right * narrower, scale_min));
    };
    result.parameters = child(child(without_component(state.parameters, worst), mu - left), mu + right);
    return result;
  }

  const Problem& problem_;
  double variation_;
  FitSettings settings_;
  int most_components_;
  std::vector<double> f_, p_;
  Problem::Linearisation work_;
  std::vector<std::size_t> order_;
};

}  // namespace

Fit fit_mixture(std::span<const ObservedPair> pairs, double energy, double variation, const Mixture* warm,
                const FitSettings& settings) {
  const Problem problem(pairs, energy);
  MixtureFitter fitter(problem, variation, settings);
  State state = fitter.run(warm);
  fitter.finish(state);
  if (warm != nullptr && settings.restart && !fitter.reached(state)) {
    State cold = fitter.run(nullptr);
    fitter.finish(cold);
    if (fitter.relative(cold) < fitter.relative(state)) state = std::move(cold);
  }
  return {to_mixture(state.parameters), fitter.relative(state)};
}

}  // namespace tress::inline v0_2::adaptive
