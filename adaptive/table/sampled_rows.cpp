// Rows of slices of samples: learned whole at the end of a pass, or of a cache and audited by fresh draws. They are
// never open: what has not converged is answered by the host's own target.
#include <algorithm>
#include <bit>
#include <memory>

#include "fit/sampled_learner.h"
#include "table/cached_form.h"
#include "table/table.h"

namespace tress::adaptive {
namespace {

constexpr std::uint32_t audit_paths = 1024;
/// A row of a cache is learned anew where its light asks for an epsilon this many times as small as its bound: light is
/// known by the paths of a few passes, and a cache that is used again shall not be learned again.
constexpr double too_coarse = 2;

}  // namespace

std::size_t Service::Table::sampled_bytes_needed(const CachedRow* stored) {
  const std::size_t kept = stored != nullptr && stored->ribbons ? cached_row_bytes(*stored) : 0;
  return std::max(sizeof(RibbonAnswer), sizeof(SampledRefusal) + kept);
}

Service::Table::Outcome Service::Table::learn(Row& row, const CachedRow* cached) const {
  const SliceDescription& slice = slices_[row.slice]->description;
  const auto width = static_cast<std::uint32_t>(slice.axis_b.size());
  SampledLimits limits;
  limits.epsilon = epsilon_of(row.slice, row.node, 0);
  const SampledRow learned =
      learn_samples(*samples_, slice, slice.axis_a[row.node / width], slice.axis_b[row.node % width], limits);
  // The first paths are fitted; each doubling is a test, and a fit.
  const auto fits = static_cast<std::uint32_t>(std::bit_width(learned.paths / limits.first_paths));
  Outcome outcome;
  outcome.g_evaluations = learned.paths + learned.energy_paths;
  outcome.refits = fits;
  outcome.converged = learned.verdict == SampledRow::Verdict::converged;
  row.set_count(learned.paths);
  row.set_failed(std::max(fits, 1u) - 1 - (outcome.converged && fits > 1 ? 1 : 0));
  if (outcome.converged) {
    row.energy = learned.row.total_mass();
    outcome.ribbons.reset(new RibbonAnswer{learned.row, learned.objective});
    return outcome;
  }
  row.energy = 0;
  const bool unusable = learned.verdict == SampledRow::Verdict::unusable;
  outcome.refusal.reset(
      new SampledRefusal{unusable ? -1 : learned.objective, unusable,
                         cached != nullptr && cached->ribbons ? std::make_unique<const CachedRow>(*cached) : nullptr});
  return outcome;
}

bool Service::Table::is_well_asked(const Row& row) const {
  return slot_of(row).queries.load(std::memory_order_relaxed) >= queries_to_creation(*slices_[row.slice]);
}

Service::Table::Outcome Service::Table::refine_samples(Row& row) const {
  row.is_coarse = false;
  const double objective = objective_of(row);
  if (objective <= too_coarse * epsilon_of(row.slice, row.node, row.energy)) return audit(row);
  row.audit = Audit::none;
  const CachedRow cached = cached_form(row, slot_of(row));
  Outcome outcome = learn(row, &cached);
  outcome.refined = true;
  return outcome;
}

Service::Table::Outcome Service::Table::audit_samples(Row& row) const {
  const SliceDescription& slice = slices_[row.slice]->description;
  const auto width = static_cast<std::uint32_t>(slice.axis_b.size());
  const RibbonAnswer& answer = *slot_of(row).ribbons();
  const SampledTest test = test_samples(*samples_, slice, slice.axis_a[row.node / width],
                                        slice.axis_b[row.node % width], answer.row, pass_, audit_paths);
  // What it was taken for: within epsilon, or, of a row that carries little light, within its own bound.
  const double claimed = std::max(epsilon_of(row.slice, row.node, row.energy), static_cast<double>(answer.objective));
  Outcome outcome;
  if (test.chi2 - 2 * test.deviation > claimed) {
    row.raise_generation();
    outcome = learn(row, nullptr);
    outcome.audit_failed = true;
  }
  outcome.g_evaluations += audit_paths;
  return outcome;
}

}  // namespace tress::adaptive
