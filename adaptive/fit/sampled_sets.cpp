#include "fit/sampled_sets.h"

#include <algorithm>

#include "observations/heard_exits.h"

namespace tress::adaptive {

void SampledSets::draw(const SampledNode& node, std::uint64_t stream, std::uint32_t first, std::uint32_t count) {
  node.target.draw_sets(node.slice, node.a, node.b, stream, first, count, sets_);
}

void SampledSets::mark() {
  for (std::size_t s = 0; s < sets_.size(); ++s) fresh_[s] = sets_[s].size();
}

bool SampledSets::are_exits(std::uint32_t parts) const {
  const auto is_one = [parts](const SampledExit& exit) { return is_exit(exit, parts); };
  return std::ranges::all_of(sets_, [&](const auto& set) { return std::ranges::all_of(set, is_one); });
}

SampledTest SampledSets::test(const RibbonRow& row, std::uint32_t paths) const {
  HeldOutTest held_out(row);
  for (std::size_t s = 0; s < sets_.size(); ++s) held_out.add(s, std::span(sets_[s]).subspan(fresh_[s]));
  return held_out.result(paths);
}

void SampledSets::append_to(std::vector<SampledExit>& exits) const {
  for (const auto& set : sets_) exits.insert(exits.end(), set.begin(), set.end());
}

}  // namespace tress::adaptive
