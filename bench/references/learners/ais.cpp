#include "references/learners/ais.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/pi.h"
#include "fit/problem.h"
#include "references/learners/ais_problem.h"
#include "references/learners/ais_proposal.h"
#include "references/learners/ais_regression.h"
#include "references/learners/ais_step.h"
#include "references/learners/ais_stop.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double start_spread = 0.5;  // of the way between modes that are equally far apart: the first scale

struct Score {
  double mean = std::numeric_limits<double>::infinity(), standard_error = 0;
  double bound() const { return mean + 2 * standard_error; }
};

// g of mass 1, the mixture likewise: a row's weak light is fitted as its strong one.
class AisLoop {
 public:
  AisLoop(const AisTarget& target, RandomStream random, const AisSettings& settings)
      : target_(target),
        random_(random),
        settings_(settings),
        components_(static_cast<std::size_t>(std::clamp(settings.components, 1, Mixture::max_components))),
        samples_(static_cast<std::size_t>(std::clamp(settings.samples, 8, 1 << 16))),
        problem_(settings.distance, settings.basis, settings.periodicity),
        stepper_(settings.step, components_) {}

  AisFit run() {
    AisFit fit;
    AisParts best;
    Score best_score;
    int since_best = 0;
    fit.end = AisEnd::exhausted;
    for (int t = 0; t < std::max(settings_.iterations, 1); ++t) {
      sample(parts_);
      if (t == 0) start();
      if (t > 0) {
        const Score score = score_sample(parts_);
        fit.history.push_back(score.mean);
        ++since_best;
        if (score.mean < best_score.mean * (1 - settings_.stop_epsilon)) since_best = 0;
        if (score.bound() < best_score.bound()) {
          best = parts_;
          best_score = score;
        }
        if (score.bound() <= settings_.threshold && final_score(parts_).bound() <= settings_.threshold) {
          best = parts_;
          fit.end = AisEnd::reached;
          break;
        }
        if (stalled(fit.history, since_best)) {
          fit.end = AisEnd::stopped;
          break;
        }
      }
      if (broken_) break;
      improve(t);
      ++fit.iterations;
    }
    if (!broken_ && fit.end != AisEnd::reached) {
      if (best.shapes.empty()) best = parts_;
      final_score(best);
    }
    fit.g_evaluations = evaluations_;
    if (broken_) {
      fit.end = AisEnd::refused;
      return fit;
    }
    fit.mixture = to_mixture(best, settings_.basis, target_.energy);
    fit.objective = final_.mean;
    fit.standard_error = final_.standard_error;
    return fit;
  }

 private:
  // Step II; g comes with it.
  void sample(const AisParts& from) {
    const AisProposal proposal(from, settings_.basis, from.shapes.empty() ? 1 : settings_.uniform_share);
    azimuth_.resize(samples_);
    g_.resize(samples_);
    f_.resize(samples_);
    q_.resize(samples_);
    for (std::size_t i = 0; i < samples_; ++i) {
      const float phi = proposal.sample(static_cast<double>(random_.next_bits() >> 11) * 0x1p-53);
      azimuth_[i] = phi;
      g_[i] = target_.density(phi) / target_.energy;
      f_[i] = proposal.mixture(phi);
      q_[i] = proposal.density(phi);
      broken_ = broken_ || !(g_[i] >= 0) || !std::isfinite(g_[i]);
    }
    evaluations_ += samples_;
  }

  // The mean of (g - f)^2/(q L) over the sample, which must have been drawn from `parts` since they were fitted. f is
  // what comes back in the end: circular, whatever the basis was.
  Score score_sample(const AisParts& parts) const {
    const Mixture mixture = to_mixture(parts, settings_.basis, 1);
    const double scale = target_.energy * target_.energy / target_.variation;
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < samples_; ++i) {
      const double r = g_[i] - static_cast<double>(mixture.density(static_cast<float>(azimuth_[i])));
      const double x = scale * r * r / q_[i];
      sum += x;
      squares += x * x;
    }
    const auto n = static_cast<double>(samples_);
    const double mean = sum / n;
    return {mean, std::sqrt(std::max(squares / n - mean * mean, 0.0) / (n - 1))};
  }

  Score final_score(const AisParts& parts) {
    sample(parts);
    return final_ = score_sample(parts);
  }

  void start() {
    const double apart = 2 * pi / static_cast<double>(components_);
    const double scale = std::clamp(start_spread * apart, scale_min, scale_max);
    parts_.uniform = settings_.uniform_part ? 0.1 : 0;
    for (std::size_t d = 0; d < components_; ++d) {
      const double even = wrap_near(-pi + (static_cast<double>(d) + 0.5) * apart);
      parts_.shapes.push_back({settings_.start == AisStart::sample ? resampled(d) : even, scale, scale});
      parts_.a.push_back(1 / (static_cast<double>(components_) * parts_.shapes[d].mass(settings_.basis)));
    }
    rescale();
    const AisProposal proposal(parts_, settings_.basis, settings_.uniform_share);
    for (std::size_t i = 0; i < samples_; ++i) f_[i] = proposal.mixture(static_cast<float>(azimuth_[i]));
  }

  // Systematic resampling by g: mode d is at the (d + 1/2)/D quantile of the first sample.
  double resampled(std::size_t d) const {
    std::vector<std::pair<double, double>> sorted;
    double sum = 0;
    for (std::size_t i = 0; i < samples_; ++i) {
      sorted.emplace_back(azimuth_[i], g_[i]);
      sum += g_[i];
    }
    std::ranges::sort(sorted);
    double left = (static_cast<double>(d) + 0.5) / static_cast<double>(components_) * sum;
    for (const auto& [azimuth, weight] : sorted) {
      left -= weight;
      if (left <= 0) return azimuth;
    }
    return sorted.back().first;
  }

  // Step III, both schemes of section 5.3 by the number of the iteration, and step IV.
  void improve(int t) {
    AisWeighting weighting = settings_.weighting;
    if (weighting == AisWeighting::alternate) weighting = t % 2 == 0 ? AisWeighting::target : AisWeighting::proposal;
    const bool sequential =
        settings_.sweep == AisSweep::sequential || (settings_.sweep == AisSweep::alternate && t / 2 % 2 == 0);
    weigh(weighting);
    if (t == 0 && settings_.basis == AisBasis::line && settings_.periodicity > 0) {
      g_end_ = std::max(target_.density(-std::numbers::pi_v<float>), 0.0) / target_.energy;
      ++evaluations_;
    }
    problem_.set_sample(azimuth_, g_, cells_, std::isfinite(g_end_) ? g_end_ : 0);
    problem_.set_parts(parts_);
    const AisRange all{0, components_, settings_.uniform_part};
    regress_weights(problem_, all);
    if (settings_.revive) revive();
    for (int i = 0; i < settings_.steps; ++i) {
      bool moved = false;
      if (sequential) {
        for (std::size_t d = 0; d < components_; ++d) {
          const AisRange one{d, d + 1, false};
          if (problem_.parts().a[d] > 0) moved |= stepper_.step(problem_, one);
          regress_weights(problem_, one);
        }
        if (settings_.uniform_part) regress_weights(problem_, {components_, components_, true});
      } else {
        moved = stepper_.step(problem_, all);
        regress_weights(problem_, all);
      }
      if (!moved) break;
    }
    // A sample that has met nothing of g teaches nothing.
    if (problem_.parts().mass(settings_.basis) > 0) parts_ = problem_.parts();
    rescale();
  }

  void weigh(AisWeighting weighting) {
    // w_i = (what the sample stands for)/q, self-normalised. Relative entropy is that of g, log(g/f), so that its
    // g log(g/f) - g + f has w/g for the target, which is 1/q.
    cells_.resize(samples_);
    const bool entropy = settings_.distance == AisDistance::relative_entropy;
    double sum = 0;
    for (std::size_t i = 0; i < samples_; ++i) {
      const bool of_g = weighting == AisWeighting::target;
      const double density = of_g ? g_[i] : weighting == AisWeighting::proposal ? f_[i] : 1 / (2 * pi);
      sum += density / q_[i];
      cells_[i] = (of_g && entropy ? 1 : density) / q_[i];
    }
    for (double& cell : cells_) cell /= sum > 0 ? sum : 1;
  }

  // A component without weight has no gradient and would stay so for ever.
  void revive() {
    AisParts parts = problem_.parts();
    for (std::size_t d = 0; d < components_; ++d) {
      if (parts.a[d] * parts.shapes[d].mass(settings_.basis) > 1e-4) continue;
      const double scale = std::max(scale_min, 0.5 * std::min(parts.shapes[d].left, parts.shapes[d].right));
      parts.shapes[d] = {wrap_near(problem_.azimuth(problem_.largest_shortfall())), std::max(scale, 0.04),
                         std::max(scale, 0.04)};
      parts.a[d] = 0;
      problem_.set_parts(parts);
      regress_weights(problem_, {0, components_, settings_.uniform_part});
      parts = problem_.parts();
    }
  }

  void rescale() {
    const double mass = parts_.mass(settings_.basis);
    if (!settings_.keep_energy || !(mass > 0)) return;
    for (double& a : parts_.a) a /= mass;
    parts_.uniform /= mass;
  }

  bool stalled(const std::vector<double>& history, int since_best) const {
    const auto k = static_cast<std::size_t>(std::max(settings_.stop_window, 2));
    switch (settings_.stop) {
      case AisStop::none:
        return false;
      case AisStop::held_out:
        return since_best >= settings_.stop_window;
      case AisStop::printed:
      case AisStop::mended: {
        if (history.size() % k != 1 || history.size() < k + 1) return false;
        std::vector<double> x;
        for (const double o : history) x.push_back(std::log(std::max(o, 1e-300)));
        return ais_p_product(x, k, settings_.stop_epsilon, settings_.stop) < settings_.stop_alpha;
      }
    }
    return false;
  }

  const AisTarget& target_;
  RandomStream random_;
  AisSettings settings_;
  std::size_t components_, samples_;
  AisProblem problem_;
  AisStepper stepper_;
  AisParts parts_;
  std::vector<double> azimuth_, g_, f_, q_, cells_;
  Score final_;
  double g_end_ = 0;  ///< g(pi) of section 5.2
  std::uint64_t evaluations_ = 0;
  bool broken_ = false;
};

}  // namespace

AisTarget ais_target(const TracedNodes& nodes) {
  return {[&nodes](float x) { return static_cast<double>(nodes.density(x)); }, nodes.energy(), nodes.variation()};
}

AisFit fit_ais(const AisTarget& target, RandomStream random, const AisSettings& settings) {
  AisFit fit;
  const bool usable = std::isfinite(target.energy) && target.energy > 0 && target.variation > 0 &&
                      std::isfinite(target.variation) && target.density;
  if (usable) fit = AisLoop(target, random, settings).run();
  if (fit.end == AisEnd::refused) {
    fit.mixture = {};
    fit.mixture.uniform_weight =
        std::isfinite(target.energy) ? static_cast<float>(std::clamp(target.energy, 0.0, 1e30)) : 0;
    fit.objective = std::numeric_limits<double>::infinity();
  }
  return fit;
}

}  // namespace tress::inline v0_2::adaptive
