#include "table/density_life.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "base/pi.h"
#include "fit/absorbed_error.h"
#include "fit/fit_mixture.h"
#include "table/row_stream.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::uint64_t validation_purpose = 0;
constexpr std::uint64_t audit_purpose = 0x6175646974ull;
constexpr std::uint64_t learner_purpose = 0x6c6561726e6572ull;
constexpr std::uint32_t queries_before_validation = 8;
constexpr int audit_draws = 64;

}  // namespace

RandomStream DensityLife::stream_of(const Row& row, std::uint64_t purpose, std::uint32_t pass) const {
  return row_stream(options_.seed + purpose, rows_.slice(row.slice).description.key, row.node, pass);
}

Options DensityLife::options_of(const Row& row) const {
  Options options = options_;
  options.epsilon = light_.epsilon_of(rows_.slice(row.slice), row.node, row.energy);
  return options;
}

FitContext DensityLife::context_of(Row& row, const Options& options, std::uint32_t pass) const {
  Learning& learning = *row.learning;
  return FitContext{.options = options,
                    .nodes = *learning.nodes,
                    .sketch = learning.sketch,
                    .stop = learning.stop,
                    .random = stream_of(row, learner_purpose, pass),
                    .components = static_cast<int>(std::clamp<std::uint32_t>(
                        std::min(options_.max_components, rows_.slice(row.slice).description.max_components), 1,
                        Mixture::max_components)),
                    .fit = learning.fit,
                    .has_fit = learning.has_fit,
                    .count = learning.count};
}

double DensityLife::largest_absorbed_error(const Row& row) const {
  double largest = -1;
  const Slice& slice = rows_.slice(row.slice);
  if (slice.decay_rates.empty() || !stands_for_others(slice.description.key, row.node)) return largest;
  for (const float rate : representative_rates(slice.decay_rates)) {
    largest = std::max(largest, absorbed_error(row.learning->fit, *row.learning->nodes, rate).value_or(-1));
  }
  return largest;
}

void DensityLife::leave_unfitted(Row& row, RowOutcome& outcome) const {
  Learning& learning = *row.learning;
  learning.fit = Mixture{};
  learning.fit.uniform_weight = row.energy;
  assign_attributes(learning.fit, *learning.nodes);
  learning.has_fit = true;
  learning.objective = 1;  // an upper bound: integral (g - mean)^2 / L is at most 1
  outcome.absorbed_error = largest_absorbed_error(row);
  outcome.changed = outcome.converged = true;
}

void DensityLife::begin(Row& row, std::uint32_t pass, RowOutcome& outcome) const {
  const Options options = options_of(row);
  if (light_.is_driven() && options.epsilon >= 1) {
    leave_unfitted(row, outcome);
    return;
  }
  FitContext context = context_of(row, options, pass);
  row.learning->learner->begin(context);
  conclude(row, context, outcome);
}

bool DensityLife::outdated(const Row& row) const {
  const std::vector<ObservedPair> pairs = row.learning->sketch.pairs();
  double sum = 0;
  for (const ObservedPair& pair : pairs) {
    const double change = static_cast<double>(row.learning->nodes->density(pair.azimuth)) - pair.g;
    sum += change * change;
  }
  const double objective =
      pairs.empty() ? 0 : sum * two_pi / (static_cast<double>(pairs.size()) * row.learning->nodes->variation());
  // A fit must reach a fourth of epsilon on its pairs.
  return objective > light_.epsilon_of(rows_.slice(row.slice), row.node, row.energy) / 4;
}

RowOutcome DensityLife::open(Row& row, const CachedRow* cached, std::uint32_t pass) const {
  RowOutcome outcome;
  Learning& learning = *row.learning;
  row.energy = learning.nodes->energy();
  if (cached != nullptr) {
    const CachedDensity& learned = *cached->density();
    learning.count = cached->count;
    if (cached->state == RowState::converged) {
      learning.fit = learned.fit;
      learning.has_fit = true;
      learning.objective = cached->objective;
      learning.earlier = std::make_unique<const CachedRow>(*cached);
    }
    learning.sketch.merge(learned.sketch);
    if (outdated(row)) {
      learning.sketch.clear();
      learning.count = 0;
      row.raise_generation();
      outcome.reopened = true;
    }
  }
  begin(row, pass, outcome);
  return outcome;
}

std::uint64_t DensityLife::draw_validation(Row& row, const Options& options, std::uint32_t pass) const {
  Learning& learning = *row.learning;
  const std::uint32_t queries = rows_.slot_of(row).queries.load(std::memory_order_relaxed);
  const std::uint64_t wanted = options.scores_per_test();
  const std::uint64_t have = learning.stop.scores();
  if (learning.created_pass >= pass || !learning.has_fit ||
      queries - learning.queries_at_creation < queries_before_validation)
    return 0;
  if (have >= wanted) return 0;
  RandomStream random = stream_of(row, validation_purpose, pass);
  for (std::uint64_t i = have; i < wanted; ++i) {
    const float x = learning.fit.sample(random.next(), options_.uniform_share_open);
    const float q = learning.fit.proposal_density(x, options_.uniform_share_open);
    const float g = learning.nodes->density(x);
    learning.add_score(x, g, q);
    learning.sketch.offer(x, g);
  }
  learning.count += wanted - have;
  return wanted - have;
}

void DensityLife::conclude(Row& row, const FitContext& context, RowOutcome& outcome) const {
  outcome.g_evaluations += context.g_evaluations;
  outcome.refits += context.fits;
  outcome.bad_fits += context.bad_fits;
  outcome.changed = outcome.changed || context.fits > 0;
  Learning& learning = *row.learning;
  if (learning.stop.bound() >= 0) learning.objective = learning.stop.bound();
  if (learning.stop.verdict() == StopTest::Verdict::undecided) return;
  outcome.changed = true;
  if (learning.stop.verdict() == StopTest::Verdict::refused) return;
  assign_attributes(learning.fit, *learning.nodes);
  outcome.absorbed_error = largest_absorbed_error(row);
  outcome.converged = true;
}

RowOutcome DensityLife::update(Row& row, std::uint32_t pass) const {
  RowOutcome outcome;
  outcome.g_evaluations = row.learning->observed.exchange(0, std::memory_order_relaxed);
  row.learning->count += outcome.g_evaluations;
  const Options options = options_of(row);
  FitContext context = context_of(row, options, pass);
  row.learning->learner->before_test(context);
  outcome.validation_draws = draw_validation(row, options, pass);
  outcome.g_evaluations += outcome.validation_draws;
  outcome.weights = row.learning->weights.moments();
  row.learning->weights.clear();
  context.own_draws = outcome.weights.count;
  if (row.learning->has_fit) context.test();
  if (row.learning->stop.verdict() == StopTest::Verdict::undecided) row.learning->learner->learn(context);
  conclude(row, context, outcome);
  return outcome;
}

RowOutcome DensityLife::audit(Row& row, std::uint32_t pass) const {
  RowOutcome outcome;
  row.audit = Audit::none;
  const RowView view = view_of(rows_.slot_of(row));
  const Slice& slice = rows_.slice(row.slice);
  std::unique_ptr<const TracedNodes> nodes =
      target_->trace(slice.description, slice.a_of(row.node), slice.b_of(row.node));
  if (!nodes) return outcome;
  RandomStream random = stream_of(row, audit_purpose, pass);
  FixedMoments<2> scores;
  for (int i = 0; i < audit_draws; ++i) {
    const float x = view.sample(random.next(), options_.uniform_share_open);
    const double q = view.proposal_density(x, options_.uniform_share_open);
    const double r = static_cast<double>(nodes->density(x)) - view.density(x);
    scores.add(r * r / (q * nodes->variation()));
  }
  outcome.traces = 1;
  outcome.g_evaluations = audit_draws;
  const Moments moments = scores.moments();
  // The error that the row was accepted with: epsilon, or its own bound if it carries little light.
  const double claimed = std::max(options_.epsilon, static_cast<double>(view.objective));
  if (moments.mean - 2 * standard_error(moments) <= claimed) return outcome;
  outcome.nodes = std::move(nodes);
  outcome.audit_failed = true;
  return outcome;
}

}  // namespace tress::inline v0_2::adaptive
