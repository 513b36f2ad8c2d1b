// The end of a pass for one row: coverage, top-up, test, refit.
#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "table/table.h"
#include "tress/adaptive/random.h"

namespace tress::adaptive {
namespace {

constexpr std::uint64_t top_up_purpose = 0;
constexpr std::uint64_t audit_purpose = 0x6175646974ull;
constexpr std::uint32_t queries_before_top_up = 8;
constexpr std::uint64_t count_before_restart = 64;
constexpr int audit_draws = 64;

double standard_error(const Moments& m) { return std::sqrt(m.variance() / static_cast<double>(m.count)); }

}  // namespace

RandomStream Service::Table::stream_of(const Row& row, std::uint64_t purpose) const {
  const PageKey& key = pages_[row.page]->description.key;
  std::uint64_t mixed = mix_bits(options_.seed + purpose) ^ key.lobe;
  for (const float parameter : key.parameters) mixed = mix_bits(mixed) ^ std::bit_cast<std::uint32_t>(parameter);
  return RandomStream(mixed, row.node, pass_);
}

std::uint64_t Service::Table::cover(Row& row) const {
  const std::vector<float> missing =
      coverage_azimuths(row.learning->sketch.pairs(), pages_[row.page]->description.blur_rad);
  for (const float x : missing) row.learning->sketch.offer(x, row.learning->nodes->density(x));
  row.count += missing.size();
  return missing.size();
}

std::uint64_t Service::Table::top_up(Row& row) const {
  const std::uint32_t touches = pages_[row.page]->slots[row.node].touches.load(std::memory_order_relaxed);
  const std::uint64_t wanted = options_.scores_per_test();
  const std::uint64_t have = row.learning->scores.count();
  if (row.learning->born_pass >= pass_ || !row.has_fit ||
      touches - row.learning->touches_at_birth < queries_before_top_up)
    return 0;
  if (have >= wanted) return 0;
  RandomStream random = stream_of(row, top_up_purpose);
  for (std::uint64_t i = have; i < wanted; ++i) {
    const float x = row.fit.sample(random.next(), options_.uniform_share_open);
    const float q = row.fit.proposal_density(x, options_.uniform_share_open);
    const float g = row.learning->nodes->density(x);
    row.add_score(x, g, q);
    row.learning->sketch.offer(x, g);
  }
  row.count += wanted - have;
  return wanted - have;
}

void Service::Table::test(Row& row, Outcome& outcome) const {
  const Moments scores = row.learning->scores.moments();
  if (!row.has_fit || scores.count < options_.scores_per_test()) return;
  row.learning->scores.clear();
  // Rounded to what a cache stores, so that the stored bound passes wherever this one does.
  row.objective = static_cast<float>(scores.mean + 2 * standard_error(scores));
  row.learning->last_test_failed = !(row.objective <= options_.epsilon);
  if (row.learning->last_test_failed) {
    row.learning->passed = 0;
    row.learning->largest_passed = 0;
    if (++row.failed >= options_.tests_before_refusal) {
      row.state = RowState::refused;
      outcome.changed = true;
    }
    return;
  }
  row.learning->largest_passed = std::max(row.learning->largest_passed, row.objective);
  if (++row.learning->passed < options_.tests_to_converge()) return;
  row.state = RowState::converged;
  row.objective = row.learning->largest_passed;
  assign_attributes(row.fit, *row.learning->nodes);
  row.learning.reset();
  outcome.converged = outcome.changed = true;
}

bool Service::Table::refit_due(const Row& row, std::uint32_t occupied) const {
  if (!row.has_fit) return true;
  return occupied * 20ull >= row.learning->bins_at_fit * 21ull || row.count >= 2 * row.learning->count_at_fit;
}

void Service::Table::refit(Row& row, Outcome& outcome) const {
  const std::vector<ObservedPair> pairs = row.learning->sketch.pairs();
  const auto occupied = static_cast<std::uint32_t>(pairs.size());
  if (pairs.empty() || !refit_due(row, occupied)) return;
  const auto components = std::min<std::uint32_t>(options_.max_components, Mixture::max_components);
  const bool restart = row.count >= count_before_restart && row.learning->last_test_failed;
  const LearnerSettings settings{options_.epsilon, static_cast<int>(components), restart};
  row.fit = fit_mixture(pairs, row.learning->nodes->energy(), row.learning->nodes->variation(),
                        row.has_fit ? &row.fit : nullptr, settings)
                .mixture;
  row.has_fit = true;
  row.learning->bins_at_fit = occupied;
  row.learning->count_at_fit = row.count;
  ++outcome.refits;
  outcome.changed = true;
}

Service::Table::Outcome Service::Table::update(Row& row) const {
  if (row.state == RowState::converged) return audit(row);
  Outcome outcome;
  outcome.g_evaluations = row.learning->observed.exchange(0, std::memory_order_relaxed);
  row.count += outcome.g_evaluations;
  outcome.g_evaluations += cover(row);
  outcome.top_ups = top_up(row);
  outcome.g_evaluations += outcome.top_ups;
  outcome.weights = row.learning->weights.moments();
  row.learning->weights.clear();
  test(row, outcome);
  if (row.state == RowState::open) refit(row, outcome);
  return outcome;
}

Service::Table::Outcome Service::Table::audit(Row& row) const {
  Outcome outcome;
  row.audit = Audit::none;
  std::unique_ptr<const TracedNodes> nodes = trace(row.page, row.node);
  RandomStream random = stream_of(row, audit_purpose);
  FixedMoments<2> scores;
  for (int i = 0; i < audit_draws; ++i) {
    const float x = row.fit.sample(random.next(), options_.uniform_share_open);
    const double q = row.fit.proposal_density(x, options_.uniform_share_open);
    const double r = static_cast<double>(nodes->density(x)) - row.fit.density(x);
    scores.add(r * r / (q * nodes->variation()));
  }
  outcome.traces = 1;
  outcome.g_evaluations = audit_draws;
  const Moments moments = scores.moments();
  if (moments.mean - 2 * standard_error(moments) <= options_.epsilon) return outcome;
  outcome.nodes = std::move(nodes);
  outcome.audit_failed = true;
  return outcome;
}

Service::Table::Outcome Service::Table::reopen(Row& row, std::unique_ptr<const TracedNodes> nodes) const {
  Outcome outcome;
  row.learning = std::make_unique<Learning>(std::move(nodes));
  row.state = RowState::open;
  ++row.generation;
  row.energy = row.learning->nodes->energy();
  row.has_fit = false;
  row.count = 0;
  row.objective = -1;
  row.learning->born_pass = pass_;
  row.learning->touches_at_birth = pages_[row.page]->slots[row.node].touches.load(std::memory_order_relaxed);
  outcome.g_evaluations = cover(row);
  refit(row, outcome);
  return outcome;
}

}  // namespace tress::adaptive
