// A vertex of the rough fiber that is answered by one traced path: the ground truth, and a row before it is learned.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fiber/energy_table.h"
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

/// A path as the picture takes it, under the fiber's color, and as a row is held to it.
struct HeardSample {
  FiberSample sample;      ///< as of TracedFibers::sample()
  int order = 0;           ///< how often it was inside
  float clear_weight = 0;  ///< of unit flux where sigma_a is 0; 0: it did not leave
  float way = 0;           ///< in the cortex, major semi-axes
};

/// Where on a fiber the light of an event enters: where its ray met it, or anywhere across (any_offset()).
enum class Offset { known, any };

/// The fibers of a model that traces, by FiberId. add(): one thread, between passes; the rest: any thread, during one.
class TracedFibers {
 public:
  explicit TracedFibers(Masked masked = Masked::meets_others) : masked_(masked) {}
  /// Of the next id.
  void add(const FiberParameters& parameters) {
    fibers_.emplace_back(parameters, masked_);
    FiberParameters clear = parameters;
    clear.sigma_a = glm::vec3(0.0f);
    clear_.emplace_back(clear, masked_);
  }
  std::size_t size() const { return fibers_.size(); }
  std::size_t bytes() const { return (fibers_.capacity() + clear_.capacity()) * sizeof(RoughFiber); }

  /// What balances estimate() against sampled lights, 1/sr, FiberModel::balance(): any number leaves the mean as it is.
  /// The variance of the light of one direction, of solid angle W when light is sampled alone, is least where the
  /// balance Q is that of which an estimate is worth the square: its second moment over its mean. That is the density
  /// of one facet about its own directions: what a slope of alpha reflects has the width 2 alpha, and what it lets out
  /// of a medium of index eta has (eta - 1) alpha. A share of it, by pictures: straight brown hair in a studio, all of
  /// it estimated, 16 samples, has a noise of 1.22 at 1.5 times a sphere's density, 1.23 at 3, 1.30 at 6, and 3.0
  /// without light samples; in a sunlit city 0.87, 0.83, 0.82.
  static float balance(const FiberParameters& fiber, const EnergyTable& energies, Offset offset);

  /// event: its fiber, known direction (clamped()) and xi; h of FiberModel::begin().
  TracedEvent begin(const FiberEvent& event, const FiberParameters& fiber, float h) const;
  /// A place across the fiber, uniform in [-1, 1], that depends on the numbers and direction of the event alone. What
  /// stands for a row begins there and not where the ray met the fiber: a row is the mean over the width, and in dense
  /// fur the two differ, since what an edge reflects goes where no neighbour stands.
  static float any_offset(const FiberEvent& event);
  /// One path: its throughput times the gain as S, in the lobe of its order, over a pdf of 1.
  FiberSample sample(FiberId id, const TracedEvent& event, const FiberParameters& fiber,
                     const std::array<float, 4>& u) const;
  /// The same, traced clear and colored after, so that what is heard of it does not depend on the color. key: of the
  /// stream that it goes by, beside the event's and u.
  HeardSample listen(FiberId id, const TracedEvent& event, const FiberParameters& fiber, const std::array<float, 4>& u,
                     std::uint64_t key) const;
  /// An unbiased value of S at wi by RoughFiber::estimate(), times the gain, by numbers that depend on the event and on
  /// wi alone; no pdf. Offset::any: the mean over equidistant places across the fiber. Of one path the variance is 4 to
  /// 10 times as large: a lobe comes from a part of the width that is as narrow as it is rough. Offset::known: of one
  /// path from there.
  FiberValue estimate(const FiberEvent& event, const TracedEvent& traced, const FiberParameters& fiber,
                      const FiberDirection& wi, Offset offset) const;
  static constexpr int paths_of_estimate = 8;  ///< of Offset::any

 private:
  static FiberSample sample_of(const RoughExit& exit, const glm::vec3& throughput, const TracedEvent& event,
                               const FiberParameters& fiber);

  Masked masked_;
  std::vector<RoughFiber> fibers_, clear_;  ///< clear_: without sigma_a
};

}  // namespace tress::fiber
