// The host's own paths by node: told by any thread during a pass, taken in between passes.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tress/adaptive/sampled_target.h"

namespace tress::adaptive {

/// The paths heard in one slice. The same paths, added in any order by any number of threads, are kept alike, to the
/// bit.
class HeardExits {
 public:
  /// Paths that are kept at a node: the first ones.
  static constexpr std::size_t most = 1024;

  /// Keeps a path for take_in(), unless it is no exit (is_exit()). Any thread, but not during take_in().
  void add(std::uint32_t node, const SampledExit& exit) const;

  /// Takes in the paths that were added since the last call, nodes ascending, while they need at most `room` bytes; the
  /// others are forgotten. Returns the bytes by which the object grew. nodes: how many the slice has. One thread.
  std::size_t take_in(std::uint32_t nodes, std::size_t room);
  /// Takes over what at() gave in an earlier session. Returns the bytes by which the object grew. One thread.
  std::size_t restore(std::uint32_t nodes, std::uint32_t node, std::vector<SampledExit> exits);

  /// The paths of a node in the order of the passes they came in, azimuths in [-pi, pi). Until the next take_in().
  std::span<const SampledExit> at(std::uint32_t node) const {
    return node < nodes_.size() ? std::span<const SampledExit>(nodes_[node]) : std::span<const SampledExit>();
  }
  /// How many paths were added before the last take_in(), those that are not kept included.
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

/// Whether a target of so many parts may draw this exit (SampledTarget).
bool is_exit(const SampledExit& exit, std::uint32_t parts);

}  // namespace tress::adaptive
