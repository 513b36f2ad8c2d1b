// The end of a pass for one row: it takes the draws that its learner wants, tests the fit and lets the learner refit.
#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <utility>

#include "fit/absorbed_error.h"
#include "fit/fit_mixture.h"
#include "table/table.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::uint64_t validation_purpose = 0;
constexpr std::uint64_t audit_purpose = 0x6175646974ull;
constexpr std::uint64_t learner_purpose = 0x6c6561726e6572ull;
constexpr std::uint32_t queries_before_validation = 8;
constexpr int audit_draws = 64;

}  // namespace

RandomStream Service::Table::stream_of(const Row& row, std::uint64_t purpose) const {
  const SliceKey& key = rows_.slice(row.slice).description.key;
  std::uint64_t mixed = mix_bits(options_.seed + purpose) ^ key.lobe;
  for (const float parameter : key.told_parameters())
    mixed = mix_bits(mixed) ^ std::bit_cast<std::uint32_t>(parameter + 0.0f);
  return RandomStream(mixed, row.node, pass_);
}

Options Service::Table::options_of(const Row& row) const {
  Options options = options_;
  options.epsilon = epsilon_of(row.slice, row.node, row.energy);
  return options;
}

FitContext Service::Table::context_of(Row& row, const Options& options) const {
  Learning& learning = *row.learning;
  return FitContext{.options = options,
                    .nodes = *learning.nodes,
                    .sketch = learning.sketch,
                    .stop = learning.stop,
                    .random = stream_of(row, learner_purpose),
                    .components = static_cast<int>(std::clamp<std::uint32_t>(
                        std::min(options_.max_components, rows_.slice(row.slice).description.max_components), 1,
                        Mixture::max_components)),
                    .fit = learning.fit,
                    .has_fit = learning.has_fit,
                    .count = learning.count};
}

double Service::Table::largest_absorbed_error(const Row& row) const {
  double largest = -1;
  const Slice& slice = rows_.slice(row.slice);
  if (slice.decay_rates.empty() || !stands_for_others(slice.description.key, row.node)) return largest;
  for (const float rate : representative_rates(slice.decay_rates)) {
    largest = std::max(largest, absorbed_error(row.learning->fit, *row.learning->nodes, rate).value_or(-1));
  }
  return largest;
}

void Service::Table::leave_unfitted(Row& row, Outcome& outcome) const {
  Learning& learning = *row.learning;
  learning.fit = Mixture{};
  learning.fit.uniform_weight = row.energy;
  assign_attributes(learning.fit, *learning.nodes);
  learning.has_fit = true;
  learning.objective = 1;  // an upper bound: integral (g - mean)^2 / L is at most 1
  outcome.absorbed_error = largest_absorbed_error(row);
  outcome.changed = outcome.converged = true;
}

void Service::Table::begin(Row& row, Outcome& outcome) const {
  const Options options = options_of(row);
  if (light_.is_driven() && options.epsilon >= 1) {
    leave_unfitted(row, outcome);
    return;
  }
  FitContext context = context_of(row, options);
  row.learning->learner->begin(context);
  conclude(row, context, outcome);
}

std::uint64_t Service::Table::draw_validation(Row& row, const Options& options) const {
  Learning& learning = *row.learning;
  const std::uint32_t queries = rows_.slot_of(row).queries.load(std::memory_order_relaxed);
  const std::uint64_t wanted = options.scores_per_test();
  const std::uint64_t have = learning.stop.scores();
  if (learning.created_pass >= pass_ || !learning.has_fit ||
      queries - learning.queries_at_creation < queries_before_validation)
    return 0;
  if (have >= wanted) return 0;
  RandomStream random = stream_of(row, validation_purpose);
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

void Service::Table::conclude(Row& row, const FitContext& context, Outcome& outcome) const {
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

Service::Table::Outcome Service::Table::update(Row& row) const {
  if (!row.learning) return audit(row);
  Outcome outcome;
  outcome.g_evaluations = row.learning->observed.exchange(0, std::memory_order_relaxed);
  row.learning->count += outcome.g_evaluations;
  const Options options = options_of(row);
  FitContext context = context_of(row, options);
  row.learning->learner->before_test(context);
  outcome.validation_draws = draw_validation(row, options);
  outcome.g_evaluations += outcome.validation_draws;
  outcome.weights = row.learning->weights.moments();
  row.learning->weights.clear();
  context.own_draws = outcome.weights.count;
  if (row.learning->has_fit) context.test();
  if (row.learning->stop.verdict() == StopTest::Verdict::undecided) row.learning->learner->learn(context);
  conclude(row, context, outcome);
  return outcome;
}

Service::Table::Outcome Service::Table::audit(Row& row) const {
  Outcome outcome;
  if (row.audit != Audit::due) return outcome;
  row.audit = Audit::none;
  const RowView view = view_of(rows_.slot_of(row));
  std::unique_ptr<const TracedNodes> nodes = trace(row.slice, row.node);
  if (!nodes) return outcome;
  RandomStream random = stream_of(row, audit_purpose);
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
