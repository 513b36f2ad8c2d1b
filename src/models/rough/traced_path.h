// A vertex of the rough fiber that is answered by one traced path: the ground truth, and a row before it is learned.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fiber/rough_fiber.h"
#include "tress/fiber/fiber_model.h"
#include "tress/fiber/parameters.h"

namespace tress::fiber {

/// What an event keeps for its paths.
struct TracedEvent {
  RoughEntry entry;
  float glint_share;   ///< of TRT
  std::uint64_t seed;  ///< by all numbers of the event
};

/// The fibers of a model that traces, by FiberId. add(): one thread, between passes; the rest: any thread, during one.
class TracedFibers {
 public:
  explicit TracedFibers(Masked masked = Masked::meets_others) : masked_(masked) {}
  /// Of the next id.
  void add(const FiberParameters& parameters) { fibers_.emplace_back(parameters, masked_); }
  std::size_t size() const { return fibers_.size(); }
  std::size_t bytes() const { return fibers_.capacity() * sizeof(RoughFiber); }

  /// event: its fiber, known direction (clamped()) and xi; h of FiberModel::begin().
  TracedEvent begin(const FiberEvent& event, const FiberParameters& fiber, float h) const;
  /// A place across the fiber, uniform in [-1, 1], that depends on the numbers and direction of the event alone. What
  /// stands for a row begins there and not where the ray met the fiber: a row is the mean over the width, and in dense
  /// fur the two differ, since what an edge reflects goes where no neighbour stands.
  static float any_offset(const FiberEvent& event);
  /// One path: its throughput times the gain as S, in the lobe of its order, over a pdf of 1.
  FiberSample sample(FiberId id, const TracedEvent& event, const FiberParameters& fiber,
                     const std::array<float, 4>& u) const;
  /// An unbiased value of S at wi: the mean of RoughFiber::estimate() from equidistant places across the fiber, times
  /// the gain, by numbers that depend on the event and on wi alone; no pdf. Of one path from where the ray met the
  /// fiber the variance is 4 to 10 times as large: a lobe comes from a part of the width that is as narrow as it is
  /// rough.
  FiberValue estimate(const FiberEvent& event, const TracedEvent& traced, const FiberParameters& fiber,
                      const FiberDirection& wi) const;
  static constexpr int paths_of_estimate = 8;

 private:
  Masked masked_;
  std::vector<RoughFiber> fibers_;
};

}  // namespace tress::fiber
