#include "fit/learn_stage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "convergence/held_out_test.h"
#include "fit/fitted_row.h"
#include "fit/part_energies.h"
#include "fit/row_exits.h"
#include "observations/heard_exits.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double worst_parent = 0.3;  ///< largest T + deviation at which a prediction is used as a start
constexpr double kappa_times_bound = 50, most_kappa = 2048;
constexpr std::uint64_t test_streams = std::uint64_t{1} << 48;  // learning never draws from these streams

constexpr std::size_t most_kept = std::size_t{1} << 17;  // number of exits for which a thread keeps the memory

/// Draws of a sampled target in four independent sets.
struct SampledSets {
  std::array<std::vector<SampledExit>, HeldOutTest::sets> all;

  bool are_exits(std::uint32_t parts) const {
    const auto is_one = [parts](const SampledExit& exit) { return is_exit(exit, parts); };
    return std::ranges::all_of(all, [&](const auto& set) { return std::ranges::all_of(set, is_one); });
  }
};

/// Memory of a stage. A thread uses it again: new pages cost more time than the work on them.
class StageMemory {
 public:
  StageMemory() : data_(std::move(spare())) {
    if (data_ == nullptr) data_ = std::make_unique<Data>();
    for (std::vector<SampledExit>& set : data_->drawn.all) set.clear();
  }
  ~StageMemory() {
    std::size_t size = 0;
    for (const std::vector<SampledExit>& set : data_->drawn.all) size += set.capacity();
    if (size <= most_kept) spare() = std::move(data_);
  }
  StageMemory(const StageMemory&) = delete;
  StageMemory& operator=(const StageMemory&) = delete;

  SampledSets& drawn() { return data_->drawn; }
  RowExits& exits() { return data_->exits; }

 private:
  struct Data {
    SampledSets drawn;
    RowExits exits;
  };
  static std::unique_ptr<Data>& spare() {
    thread_local std::unique_ptr<Data> data;
    return data;
  }
  std::unique_ptr<Data> data_;
};

/// Tests a row of as many parts by the exits that taught none. paths: their number in each set.
SampledTest test_by(const RowExits& exits, const RibbonRow& row, std::uint32_t paths) {
  HeldOutTest held_out(row);
  for (std::uint32_t p = 0; p < exits.parts; ++p) {
    const RowExits::Part& part = exits.part[p];
    if (!(part.count > 0)) continue;
    const std::size_t first = part.begin.front(), n = part.begin.back() - first;
    const auto of_part = [&](const auto& column) { return std::span(column).subspan(first, n); };
    held_out.add(p,
                 {of_part(exits.x), of_part(exits.t), of_part(exits.w), of_part(exits.set), part.light / part.count});
  }
  return held_out.result(paths);
}

}  // namespace

StagedRow learn_stage(const SampledTarget& target, const SliceDescription& slice, float a, float b, std::uint32_t paths,
                      std::uint32_t paths_before, const RibbonRow* before, const RibbonRow* parent) {
  constexpr std::uint32_t sets = HeldOutTest::sets;
  const std::uint32_t parts = target.parts(slice);
  StagedRow staged;
  if (parts < 1 || parts > SampledTarget::most_parts) return staged;
  StageMemory memory;
  SampledSets& drawn = memory.drawn();
  if (before == nullptr) paths_before = 0;
  if (paths_before > 0) target.draw_sets(slice, a, b, 0, 0, paths_before / sets, drawn.all);
  std::array<ExitSet, sets> all;
  for (std::size_t s = 0; s < sets; ++s) all[s].taught = drawn.all[s].size();
  target.draw_sets(slice, a, b, 0, paths_before / sets, (paths - paths_before) / sets, drawn.all);
  if (!drawn.are_exits(parts)) return staged;
  for (std::size_t s = 0; s < sets; ++s) all[s].exits = drawn.all[s];
  RowExits& exits = memory.exits();
  sort_exits(all, parts, exits);
  const RibbonRow* tested = before != nullptr ? before : parent;
  float kappa = 0;
  if (tested != nullptr && tested->parts() == parts && paths > paths_before) {
    staged.test = test_by(exits, *tested, (paths - paths_before) / sets);
    staged.tested = true;
    const double bound = staged.test.chi2 + staged.test.deviation;
    if (before == nullptr && bound < worst_parent) {
      kappa = static_cast<float>(bound > kappa_times_bound / most_kappa ? kappa_times_bound / bound : most_kappa);
    }
  }
  PartEnergies energies;
  energies.add(exits, paths);
  if (!energies.has_mass()) return staged;
  staged.row = fitted_row(exits, energies, kappa > 0 ? parent : nullptr, RibbonFitRule::of(paths, kappa > 0, kappa));
  // The new fit may have found another optimum. If it is worse even on the paths that it was fitted to, the earlier
  // row, which was tested on them, is kept.
  if (before != nullptr && staged.tested &&
      test_by(exits, staged.row, (paths - paths_before) / sets).chi2 > staged.test.chi2)
    staged.row = with_energies(*before, energies);
  staged.usable = true;
  return staged;
}

SampledTest test_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
                         const RibbonRow& row, std::uint64_t round, std::uint32_t count) {
  StageMemory memory;
  SampledSets& batch = memory.drawn();
  target.draw_sets(slice, a, b, test_streams + HeldOutTest::sets * round, 0, count / HeldOutTest::sets, batch.all);
  if (!batch.are_exits(row.parts())) return {HUGE_VAL, 0};
  HeldOutTest held_out(row);
  for (std::size_t s = 0; s < batch.all.size(); ++s) held_out.add(s, batch.all[s]);
  return held_out.result(count / HeldOutTest::sets);
}

}  // namespace tress::inline v0_2::adaptive
