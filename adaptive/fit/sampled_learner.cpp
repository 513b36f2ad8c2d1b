#include "fit/sampled_learner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "convergence/held_out_test.h"
#include "fit/exit_columns.h"
#include "fit/fit_ribbon.h"
#include "fit/part_energies.h"

namespace tress::adaptive {
namespace {

constexpr std::uint64_t energy_streams = std::uint64_t{1} << 47;  // of energies alone
constexpr std::uint64_t test_streams = std::uint64_t{1} << 48;    // from here on no learning draws

/// Where a row is learned.
struct Node {
  const SampledTarget& target;
  const SliceDescription& slice;
  float a, b;
};

bool is_exit(const SampledExit& exit, std::uint32_t parts) {
  return std::isfinite(exit.azimuth) && std::isfinite(exit.height) && exit.part < parts && exit.weight >= 0 &&
         std::isfinite(exit.weight) && exit.attribute >= 0 && std::isfinite(exit.attribute);
}

/// Draws of one batch: its sets one after another.
struct Batch {
  std::vector<SampledExit> exits;
  std::array<std::size_t, HeldOutTest::sets + 1> begin{};

  std::span<const SampledExit> set(std::size_t s) const {
    return std::span(exits).subspan(begin[s], begin[s + 1] - begin[s]);
  }
};

/// Four streams from `stream` on, of count/4 paths each; nothing if an exit is none.
std::optional<Batch> draw(const Node& node, std::uint32_t parts, std::uint64_t stream, std::uint32_t count) {
  Batch batch;
  for (std::size_t s = 0; s < HeldOutTest::sets; ++s) {
    batch.begin[s] = batch.exits.size();
    node.target.draw(node.slice, node.a, node.b, stream + s, 0, count / HeldOutTest::sets, batch.exits);
  }
  batch.begin.back() = batch.exits.size();
  for (const SampledExit& exit : batch.exits) {
    if (!is_exit(exit, parts)) return std::nullopt;
  }
  return batch;
}

SampledTest test(const RibbonRow& row, const Batch& batch, std::uint32_t count) {
  HeldOutTest held_out(row);
  for (std::size_t s = 0; s < HeldOutTest::sets; ++s) held_out.add(s, batch.set(s));
  return held_out.result(count / HeldOutTest::sets);
}

/// What is known of a row.
class Learned {
 public:
  explicit Learned(std::uint32_t parts) : ribbons_(parts) {}

  std::uint64_t paths() const { return paths_; }
  std::uint64_t energy_paths() const { return energies_.paths() - paths_; }
  const RibbonRow& row() const { return row_; }

  void join(const Batch& batch, std::uint32_t count) {
    exits_.insert(exits_.end(), batch.exits.begin(), batch.exits.end());
    energies_.add(batch.exits, count);
    paths_ += count;
  }
  /// Tells energies alone.
  void tell(const Batch& batch, std::uint32_t count) { energies_.add(batch.exits, count); }

  /// Whether there is light, and no more than a float holds.
  bool has_mass() const {
    const auto all = static_cast<float>(energies_.total_mass());
    return all > 0 && std::isfinite(all);
  }

  /// `last`: with decays. `tested`: the fit before has passed, and keeps its laws.
  void fit(bool last, bool tested) {
    RibbonFitRule rule;
    rule.keep_law = tested;
    std::vector<RibbonRow::Part> parts(ribbons_.size());
    for (std::uint32_t p = 0; p < ribbons_.size(); ++p) {
      const ExitColumns exits = sort_exits(exits_, p);
      if (std::ranges::none_of(exits.w, [](float weight) { return weight > 0; })) continue;
      parts[p].mass = static_cast<float>(energies_.mass(p));
      std::optional<Ribbon>& known = ribbons_[p];
      known = fit_ribbon(exits, known ? &*known : nullptr, last, rule).ribbon;
      parts[p].ribbon = last ? energies_.mended(*known, p) : *known;
    }
    row_ = RibbonRow(parts);
  }

 private:
  std::vector<SampledExit> exits_;
  std::vector<std::optional<Ribbon>> ribbons_;  ///< as they were fitted
  PartEnergies energies_;
  std::uint64_t paths_ = 0;
  RibbonRow row_;
};

}  // namespace

std::uint32_t SampledLimits::energy_paths() const {
  constexpr double whole = 256 * HeldOutTest::sets;
  const double asked = std::floor(energy_paths_times_epsilon / epsilon / whole) * whole;
  return static_cast<std::uint32_t>(std::clamp(asked, 0.0, static_cast<double>(most_paths)));
}

SampledRow learn_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
                         const SampledLimits& limits) {
  const Node node{target, slice, a, b};
  const std::uint32_t parts = target.parts(slice);
  SampledRow learned;
  learned.verdict = SampledRow::Verdict::unusable;
  if (parts < 1 || parts > SampledTarget::most_parts) return learned;
  Learned known(parts);
  std::uint32_t count = limits.first_paths;
  for (std::uint64_t stream = 0;; stream += HeldOutTest::sets) {
    const std::optional<Batch> batch = draw(node, parts, stream, count);
    if (!batch) return learned;
    bool passed = false;
    if (stream > 0) {
      learned.objective = static_cast<float>(std::max(test(known.row(), *batch, count).bound(), 0.0));
      passed = learned.objective <= limits.epsilon;
    }
    known.join(*batch, count);
    if (passed && limits.energy_paths() > known.paths()) {
      const auto more = static_cast<std::uint32_t>(limits.energy_paths() - known.paths());
      const std::optional<Batch> for_energies = draw(node, parts, energy_streams, more);
      if (!for_energies) return learned;
      known.tell(*for_energies, more);
    }
    if (!known.has_mass()) return learned;
    const bool is_last = passed || 2 * known.paths() > limits.most_paths;
    known.fit(is_last, passed);
    if (is_last) {
      learned.row = known.row();
      learned.paths = known.paths();
      learned.energy_paths = known.energy_paths();
      learned.verdict = passed ? SampledRow::Verdict::converged : SampledRow::Verdict::refused;
      return learned;
    }
    count = static_cast<std::uint32_t>(known.paths());
  }
}

SampledTest test_samples(const SampledTarget& target, const SliceDescription& slice, float a, float b,
                         const RibbonRow& row, std::uint64_t round, std::uint32_t count) {
  const std::optional<Batch> batch =
      draw({target, slice, a, b}, row.parts(), test_streams + HeldOutTest::sets * round, count);
  if (!batch) return {HUGE_VAL, 0};
  return test(row, *batch, count);
}

}  // namespace tress::adaptive
