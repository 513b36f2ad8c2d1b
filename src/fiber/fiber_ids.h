// The fibers of a model by their parameters: equal parameters are one fiber.
#pragma once

#include <cstddef>
#include <unordered_map>
#include <utility>
#include <vector>

#include "tress/fiber/fiber_model.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// Ids are 0, 1, ... in the order of first appearance, so a model can keep its data of fibers in a vector.
/// find_or_add(): one thread, between passes; the rest: any thread, during a pass.
class FiberIds {
 public:
  /// Returns the id, found by hashing, and whether it is new.
  std::pair<FiberId, bool> find_or_add(const FiberParameters& parameters);
  const FiberParameters& operator[](FiberId id) const { return fibers_[id]; }
  std::size_t size() const { return fibers_.size(); }

 private:
  std::vector<FiberParameters> fibers_;
  std::unordered_multimap<std::size_t, FiberId> id_of_hash_;
};

}  // namespace tress::inline v0_2::fiber
