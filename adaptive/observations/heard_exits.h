// Paths that the host traced itself, by node. Any thread adds them during a pass; they are taken in between passes.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tress/adaptive/sampled_target.h"

namespace tress::inline v0_2::adaptive {

/// The host's paths in one slice. The same paths give the same contents to the bit, in whatever order and by however
/// many threads they were added.
class HeardExits {
 public:
  /// The number of paths that are kept at a node: the first ones.
  static constexpr std::size_t most = 1024;

  /// Keeps a path for take_in(), unless it is invalid (is_exit()). Any thread, but not during take_in().
  void add(std::uint32_t node, const SampledExit& exit) const;

  /// Takes in the paths that were added since the last call, in ascending order of nodes, while they need at most
  /// `room` bytes; the others are dropped. Returns the bytes by which the object grew. nodes: the number of nodes of
  /// the slice. One thread.
  std::size_t take_in(std::uint32_t nodes, std::size_t room);
  /// Restores what at() returned in an earlier session. Returns the bytes by which the object grew. One thread.
  std::size_t restore(std::uint32_t nodes, std::uint32_t node, std::vector<SampledExit> exits);

  /// The paths of a node in the order of the passes they came in, azimuths in [-pi, pi). Valid until the next
  /// take_in().
  std::span<const SampledExit> at(std::uint32_t node) const {
    return node < nodes_.size() ? std::span<const SampledExit>(nodes_[node]) : std::span<const SampledExit>();
  }
  /// The number of paths that were added before the last take_in(), including those that were not kept.
  std::uint64_t paths() const { return paths_; }
  void set_paths(std::uint64_t paths) { paths_ = paths; }

 private:
  struct AddedExit {
    std::uint32_t node;
    SampledExit exit;
  };
  mutable tbb::enumerable_thread_specific<std::vector<AddedExit>> added_;
  std::vector<std::vector<SampledExit>> nodes_;
  std::uint64_t paths_ = 0;
};

/// Whether the exit is valid for a target of this many parts (SampledTarget).
bool is_exit(const SampledExit& exit, std::uint32_t parts);

}  // namespace tress::inline v0_2::adaptive
