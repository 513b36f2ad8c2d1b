#include "references/learners/appendix_learner.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tress::inline v0_2::adaptive {
namespace {

// What counts as a small change of a parameter: the metric of the projection.
constexpr double weight_reach = 0.32;   // of the energy
constexpr double mode_reach = 0.32;     // radians
constexpr double scale_reach = 0.45;    // of ln s
constexpr double largest_change = 0.3;  // of mu and ln s at one sample
constexpr double damping = 0.01;        // times energy^2 q, beside the sample's own power: 1/rad
// Entry n enters the average with 9/(n + 8): it follows the last ninth of the entries. With the plain mean (0), which
// never forgets the start, 74 % of rows pass where 95 % do.
constexpr double head_start = 8;

}  // namespace

void LiteralAppendixLearner::begin(FitContext& context) {
  entry_ = starting_parameters(context, context.components, context.has_fit ? &context.fit : nullptr);
  context.publish(mixture_of(entry_, context.nodes.energy()));
}

void LiteralAppendixLearner::learn(FitContext& context) {
  const std::uint64_t draws = std::min(context.own_draws, most_replayed);
  if (draws == 0) return;
  for (std::uint64_t i = 0; i < draws; ++i) take_one(context);
  context.publish(mixture_of(entry_, context.nodes.energy()));
}

void LiteralAppendixLearner::take_one(FitContext& context) {
  const Mixture now = mixture_of(entry_, context.nodes.energy());
  const float x = now.sample(context.random.next(), context.options.uniform_share_open);
  const double target = context.g(x);
  Vector gradient;
  const double f = density_and_gradient(entry_, x, gradient);
  // Line 2, one-sided as printed. tau is not defined: epsilon, "a small, threshold parameter".
  if (!(f > 0) || !((target - f) * (target / f) >= context.options.epsilon)) return;
  // The i of lines 3 and 4: the component that the sample belongs to.
  Eigen::Index own = 0;
  for (Eigen::Index at = 0; at + 1 < entry_.size(); at += per_component) {
    if (entry_[at] * gradient[at] > entry_[own] * gradient[own]) own = at;
  }
  // Line 3: the derivative of p_i by b is 0 at the sample: its mode there (no scale makes its derivative 0 there).
  Vector made = entry_;
  made[own + offset_mu] = x;
  // Line 4: the residual under b' replaces the weight. a_d >= 0 of equation 4.
  const double residual = target - density_and_gradient(made, x, gradient);
  made[own] = std::max(0.0, residual / gradient[own]);
  // "averaging every new entry"
  const double share = 1 / static_cast<double>(++entries_);
  entry_[own] += share * (made[own] - entry_[own]);
  entry_[own + offset_mu] = wrap_near(entry_[own + offset_mu] + share * wrap_near(x - entry_[own + offset_mu]));
}

void AppendixLearner::begin(FitContext& context) {
  entry_ = starting_parameters(context, context.components, context.has_fit ? &context.fit : nullptr);
  average_ = entry_;
  context.publish(mixture_of(entry_, context.nodes.energy()));
}

void AppendixLearner::learn(FitContext& context) {
  std::vector<WeightedDraw> draws = replay(context, context.fit, context.own_draws);
  if (draws.empty()) return;
  // Neighbours one after the other would undo each other's steps.
  for (std::size_t i = draws.size(); i > 1; --i) std::swap(draws[i - 1], draws[context.random.next_bits() % i]);
  for (const WeightedDraw& draw : draws) take_one(draw, context.nodes.energy());
  context.publish(mixture_of(average_, context.nodes.energy()));
}

void AppendixLearner::take_one(const WeightedDraw& draw, double energy) {
  Vector gradient;
  const double residual = draw.g - density_and_gradient(entry_, draw.azimuth, gradient);
  Vector direction = gradient;
  for (Eigen::Index i = 0; i < direction.size(); ++i) {
    const Eigen::Index kind = i % per_component;
    const double width = kind == offset_weight ? weight_reach * energy : kind == offset_mu ? mode_reach : scale_reach;
    direction[i] *= width * width;
  }
  const double against = gradient.dot(direction) + damping * energy * energy * draw.q;
  if (!(against > 0)) return;
  const Vector step = direction * (residual / against);
  ++entries_;
  const double share = std::min(1.0, (1 + head_start) / (static_cast<double>(entries_) + head_start));
  for (Eigen::Index i = 0; i < entry_.size(); ++i) {
    const Eigen::Index kind = i % per_component;
    if (kind == offset_weight) {
      entry_[i] = std::max(entry_[i] + step[i], 0.0);
      average_[i] += share * (entry_[i] - average_[i]);
      continue;
    }
    entry_[i] += std::clamp(step[i], -largest_change, largest_change);
    if (kind == offset_mu) {
      entry_[i] = wrap_near(entry_[i]);
      average_[i] = wrap_near(average_[i] + share * wrap_near(entry_[i] - average_[i]));
    } else {
      entry_[i] = std::clamp(entry_[i], std::log(scale_min), std::log(scale_max));
      average_[i] += share * (entry_[i] - average_[i]);
    }
  }
}

std::optional<std::vector<std::uint64_t>> LiteralAppendixLearner::state() const {
  std::vector<std::uint64_t> words{entries_};
  append_vector(entry_, words);
  return words;
}

bool LiteralAppendixLearner::set_state(std::span<const std::uint64_t> words) {
  if (words.empty()) return false;
  entries_ = words[0];
  words = words.subspan(1);
  return take_vector(words, entry_) && words.empty();
}

std::optional<std::vector<std::uint64_t>> AppendixLearner::state() const {
  std::vector<std::uint64_t> words{entries_};
  append_vector(entry_, words);
  append_vector(average_, words);
  return words;
}

bool AppendixLearner::set_state(std::span<const std::uint64_t> words) {
  if (words.empty()) return false;
  entries_ = words[0];
  words = words.subspan(1);
  return take_vector(words, entry_) && take_vector(words, average_) && words.empty() &&
         entry_.size() == average_.size();
}

}  // namespace tress::inline v0_2::adaptive
