#include "observations/heard_exits.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "tress/adaptive/mixture.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

std::uint64_t hash_of(const SampledExit& exit) {
  return mix_bits(bits_of(exit.azimuth, exit.height) + mix_bits(bits_of(exit.weight, exit.attribute) + exit.part));
}

}  // namespace

bool is_exit(const SampledExit& exit, std::uint32_t parts) {
  return std::isfinite(exit.azimuth) && std::isfinite(exit.height) && exit.weight >= 0 &&
         exit.weight <= largest_weight && std::isfinite(exit.attribute) && exit.attribute >= 0 && exit.part < parts;
}

void HeardExits::add(std::uint32_t node, const SampledExit& exit) const {
  if (!is_exit(exit, SampledTarget::most_parts)) return;
  // Adding 0 removes negative zeros, so that what compares equal has the same bits.
  added_.local().push_back(
      {node,
       {wrap_angle(exit.azimuth) + 0.0f, exit.height + 0.0f, exit.part, exit.weight + 0.0f, exit.attribute + 0.0f}});
}

std::size_t HeardExits::take_in(std::uint32_t nodes, std::size_t room) {
  std::vector<AddedExit> all;
  for (std::vector<AddedExit>& of_thread : added_) {
    all.insert(all.end(), of_thread.begin(), of_thread.end());
    of_thread.clear();
  }
  std::erase_if(all, [&](const AddedExit& one) { return one.node >= nodes; });
  if (all.empty()) return 0;
  std::ranges::sort(
      all, {}, [](const AddedExit& one) {  // random order within a node, so that every fourth exit makes a fair set
        const SampledExit& exit = one.exit;
        return std::tuple(one.node, hash_of(exit), exit.azimuth, exit.height, exit.part, exit.weight, exit.attribute);
      });
  paths_ += all.size();
  nodes_.resize(nodes);
  std::size_t grown = 0;
  for (const AddedExit& one : all) {
    std::vector<SampledExit>& exits = nodes_[one.node];
    if (exits.size() == most || grown + sizeof(SampledExit) > room) continue;
    exits.push_back(one.exit);
    grown += sizeof(SampledExit);
  }
  return grown;
}

std::size_t HeardExits::restore(std::uint32_t nodes, std::uint32_t node, std::vector<SampledExit> exits) {
  nodes_.resize(nodes);
  nodes_[node] = std::move(exits);
  return nodes_[node].size() * sizeof(SampledExit);
}

}  // namespace tress::inline v0_2::adaptive
