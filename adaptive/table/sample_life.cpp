#include "table/sample_life.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "convergence/held_out_test.h"
#include "fit/learn_stage.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// Largest number of paths of a row whose paths follow its events. A row that learns until it passes may have more.
constexpr std::uint32_t most_by_events = 16384, most_of_coarse = 2048;
constexpr double events_of_own = 512;  ///< after which a node has a row of its own
constexpr double events_per_path = 2;
constexpr std::uint32_t audit_paths = 1024;

/// Stages, in paths, of a row that learns from the paths of the host.
constexpr std::array<std::uint32_t, 3> heard_stages{64, 256, 1024};

/// Draws the host's paths at one node. Each stream has every fourth path, in their order.
class HeardTarget final : public SampledTarget {
 public:
  HeardTarget(const SampledTarget& target, std::span<const SampledExit> heard) : target_(target), heard_(heard) {}
  std::uint32_t parts(const SliceDescription& slice) const override { return target_.parts(slice); }
  std::string model_name() const override { return target_.model_name(); }
  void draw(const SliceDescription&, float, float, std::uint64_t stream, std::uint32_t first, std::uint32_t count,
            std::vector<SampledExit>& out) const override {
    for (std::uint32_t i = first; i < first + count; ++i) out.push_back(heard_[i * HeldOutTest::sets + stream]);
  }

 private:
  const SampledTarget& target_;
  std::span<const SampledExit> heard_;
};

std::uint32_t stage_after(std::uint32_t paths) {
  const auto next = std::ranges::upper_bound(sampled_stages, paths);
  return next == sampled_stages.end() ? 0 : *next;
}

/// The stage of a row with this many events: one path for two events, rounded up to a stage.
std::uint32_t stage_for(double events, std::uint32_t most) {
  std::uint32_t stage = sampled_stages.front();
  while (stage < most && static_cast<double>(stage) * events_per_path <= events) stage = stage_after(stage);
  return std::min(stage, most);
}

}  // namespace

std::uint32_t SampleLife::most_paths() const { return learns_to_epsilon() ? sampled_stages.back() : most_by_events; }

double SampleLife::asked_of_coarse(const Slice& slice, std::uint32_t node) const {
  auto asked = static_cast<double>(slice.asked(node));
  for (const Slice* other : slice.answers_for) asked += static_cast<double>(other->asked(node));
  return asked;
}

std::vector<double> SampleLife::gathered_events(const Slice& slice, bool is_coarse) const {
  std::vector<double> events(slice.description.node_count(), 0.0);
  for (std::uint32_t n = 0; n < events.size(); ++n) {
    if (!is_coarse) {
      events[n] = static_cast<double>(slice.asked(n));
    } else if (const double asked = asked_of_coarse(slice, n); asked > 0) {
      for (const CoarseGrid::Corner& corner : slice.grid.around(n))
        events[corner.node] += asked * static_cast<double>(corner.weight);
    }
  }
  return events;
}

std::uint32_t SampleLife::wanted_paths(SliceId id, bool is_coarse, double events) const {
  const Slice& slice = rows_.slice(id);
  if (!options_.own_paths || (is_coarse && slice.coarse_rows != nullptr)) return 0;
  if (is_coarse) return stage_for(events, most_of_coarse);
  const bool waits = !slice.grid.empty() && !learns_to_epsilon();  // coarse rows answer meanwhile
  if (events < (waits ? events_of_own : std::max<double>(options_.queries_before_creation, 1))) return 0;
  return stage_for(events, learns_to_epsilon() ? sampled_stages.front() : most_by_events);
}

std::vector<SampleLife::Growth> SampleLife::growths(SliceId id, bool is_coarse,
                                                    const std::vector<std::uint32_t>& again) const {
  const Slice& slice = rows_.slice(id);
  const std::vector<double> events = gathered_events(slice, is_coarse);
  std::vector<Growth> growths;
  // What was made of a coarse row for the nodes around it is freed when it grows. So coarse rows grow together, once
  // one of them has twice the events that it needs.
  const bool to_epsilon = !is_coarse && learns_to_epsilon();
  bool is_time = !is_coarse;
  for (std::uint32_t n = 0; n < slice.description.node_count(); ++n) {
    if (is_coarse && !slice.grid.has(n)) continue;
    const Slot& slot = slice.slots[n];
    if (slot.is_refused()) continue;
    const RibbonAnswer* answer = slot.ribbons();
    std::uint32_t wanted = wanted_paths(id, is_coarse, events[n]);
    if (!options_.own_paths && !is_coarse) {
      for (const std::uint32_t stage : heard_stages) wanted = slice.heard.at(n).size() >= stage ? stage : wanted;
    }
    if (to_epsilon && answer != nullptr && wanted != 0) wanted = stage_after(answer->paths);
    const std::uint32_t restart = again.empty() ? 0 : again[n];
    if (restart != 0 && answer == nullptr) wanted = to_epsilon ? sampled_stages.front() : std::max(wanted, restart);
    const bool may_grow = answer == nullptr || !to_epsilon || !answer->has_converged;
    const std::uint32_t had = answer != nullptr ? answer->paths : 0;
    if (!may_grow || wanted <= had) continue;
    is_time = is_time || restart != 0 || wanted_paths(id, is_coarse, events[n] / 2) > had;
    growths.push_back({n, wanted, slice.light_at(n), events[n]});
  }
  if (!is_time) return {};
  std::ranges::sort(growths, [](const Growth& x, const Growth& y) {
    if (x.light != y.light) return x.light > y.light;
    return x.events != y.events ? x.events > y.events : x.node < y.node;
  });
  return growths;
}

bool SampleLife::pays(SliceId id, double share) const {
  if (!options_.own_paths) return true;  // rows grow by what was heard
  const Slice& slice = rows_.slice(id);
  if (!slice.grid.empty() && !growths(id, true, {}).empty()) return true;
  double asked = 0, waiting = 0;
  for (std::uint32_t n = 0; n < slice.description.node_count(); ++n)
    asked += slice.slots[n].is_refused() ? 0 : static_cast<double>(slice.asked(n));
  for (const Growth& one : growths(id, false, {})) waiting += one.events;
  return waiting > 0 && waiting >= share * asked;
}

RowOutcome SampleLife::learn(const Row& row, std::uint32_t paths, bool is_coarse, const RibbonAnswer* parent) const {
  const Slice& of = rows_.slice(row.slice);
  const SliceDescription& slice = of.description;
  const float a = of.a_of(row.node), b = of.b_of(row.node);
  const RibbonAnswer* before = rows_.slot_of(row).ribbons();
  const double epsilon = light_.epsilon_of(rows_.slice(row.slice), row.node, row.energy);
  const bool to_epsilon = !is_coarse && learns_to_epsilon();
  const HeardTarget heard(*target_, of.heard.at(row.node));
  const SampledTarget& teacher = options_.own_paths ? static_cast<const SampledTarget&>(*target_) : heard;
  RowOutcome outcome;
  auto answer = std::make_unique<RibbonAnswer>();
  answer->objective = 1;
  if (before != nullptr) *answer = *before;
  std::uint32_t had = before != nullptr ? before->paths : 0;
  for (;;) {
    const bool was_converged = answer->has_converged, is_tested = had > 0 && !was_converged;
    const StagedRow staged = learn_stage(teacher, slice, a, b, paths, had, had > 0 ? &answer->row : nullptr,
                                         had == 0 && parent != nullptr ? &parent->row : nullptr);
    outcome.g_evaluations += paths - had;
    ++outcome.refits;
    if (!staged.usable) {
      outcome.refused = true;
      return outcome;
    }
    SampledTest test = staged.test;
    if (!staged.tested && had == 0 && options_.own_paths) {  // fresh draws test the first fit
      test = test_samples(*target_, slice, a, b, staged.row, 0, paths);
      outcome.g_evaluations += paths;
    }
    // The fit that answered was made with the paths of the test before, so that its own test comes only now.
    const bool is_found_wrong = was_converged && staged.tested && may_converge(paths) && test.lower() > epsilon;
    if (is_found_wrong) answer->has_converged = false;
    if (is_tested || is_found_wrong || (had == 0 && options_.own_paths))
      answer->objective = static_cast<float>(std::max(test.bound(), 0.0));
    const bool passes = is_tested && may_converge(paths) && static_cast<double>(answer->objective) <= epsilon;
    outcome.failed += is_found_wrong || (is_tested && may_converge(paths) && !passes) ? 1 : 0;
    outcome.converged = outcome.converged || passes;
    answer->has_converged = answer->has_converged || passes;
    answer->row = staged.row;
    answer->paths = had = paths;
    paths = stage_after(paths);
    if (!to_epsilon || answer->has_converged || paths == 0) break;
  }
  outcome.ribbons = std::move(answer);
  return outcome;
}

RowOutcome SampleLife::audit(const Row& row, std::uint32_t pass) const {
  const Slice& slice = rows_.slice(row.slice);
  const RibbonAnswer& answer = *rows_.slot_of(row).ribbons();
  const SampledTest test = test_samples(*target_, slice.description, slice.a_of(row.node), slice.b_of(row.node),
                                        answer.row, pass, audit_paths);
  RowOutcome outcome;
  outcome.g_evaluations = audit_paths;
  // The error that the row was accepted with: epsilon, or the bound of its own test.
  const double claimed =
      std::max(light_.epsilon_of(rows_.slice(row.slice), row.node, row.energy), static_cast<double>(answer.objective));
  outcome.audit_failed = test.chi2 - 2 * test.deviation > claimed;
  return outcome;
}

std::optional<Error> SampleLife::invalid_exits(const Row& row, std::uint64_t paths) const {
  const Slice& of = rows_.slice(row.slice);
  std::vector<SampledExit> exits;
  target_->draw(of.description, of.a_of(row.node), of.b_of(row.node), 0, 0, static_cast<std::uint32_t>(paths), exits);
  const std::uint32_t parts = target_->parts(of.description);
  if (std::ranges::all_of(exits, [parts](const SampledExit& exit) { return is_exit(exit, parts); }))
    return std::nullopt;
  return Error{
      "", "SampledTarget::draw",
      "exits that are finite, of a weight and attribute of 0 or more and a part below " + std::to_string(parts),
      "another at node " + std::to_string(row.node) + " of slice " + std::to_string(row.slice)};
}

}  // namespace tress::inline v0_2::adaptive
