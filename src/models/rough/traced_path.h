// Answers a vertex of the rough fiber by one traced path, as the reference does and as a row does before it is learned.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fiber/energy_table.h"
#include "fiber/rough_fiber.h"
#include "tress/fiber/fiber_model.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// The data that an event keeps for its paths.
struct TracedEvent {
  RoughEntry entry;
  float glint_share;      ///< share of GLINT in TRT
  std::uint64_t seed;     ///< from all numbers of the event
  float kept_inside = 1;  ///< of RoughFiber::trace()
};

/// A path that serves the picture, under the fiber's color, and the test of a row, in clear hair.
struct HeardSample {
  FiberSample sample;      ///< the same as from TracedFibers::sample()
  int order = 0;           ///< number of times it was inside
  float clear_weight = 0;  ///< for unit flux without absorption; 0 if it did not leave
  float way = 0;           ///< path length in the cortex, major semi-axes
};

/// Where light of an event enters the fiber: where its ray met it, or anywhere across it (any_offset()).
enum class Offset { known, any };

/// The fibers of a model that traces, by FiberId. add(): one thread, between passes; the rest: any thread, during one.
class TracedFibers {
 public:
  explicit TracedFibers(Masked masked = Masked::meets_others) : masked_(masked) {}
  /// Adds the fiber with the next id.
  void add(const FiberParameters& parameters) {
    fibers_.emplace_back(parameters, masked_);
    FiberParameters clear = parameters;
    clear.sigma_a = glm::vec3(0.0f);
    clear_.emplace_back(clear, masked_);
  }
  std::size_t size() const { return fibers_.size(); }
  std::size_t bytes() const { return (fibers_.capacity() + clear_.capacity()) * sizeof(RoughFiber); }

  /// The density that balances estimate() against sampled lights, 1/sr, for FiberModel::balance(). Any value leaves the
  /// mean unchanged. For light from one direction the variance is least if the balance is the second moment of an
  /// estimate over its mean. That is the density of one facet about its own directions: reflection at a slope of alpha
  /// has the width 2 alpha, and light that leaves a medium of index eta has the width (eta - 1) alpha.
  ///
  /// The share of it that is used was chosen by pictures. At 1.5, 3 and 6 times the density of a uniform sphere,
  /// straight brown hair in a studio, all of it estimated, with 16 samples, has a noise of 1.22, 1.23 and 1.30 (3.0
  /// without light samples); in a sunlit city it has 0.87, 0.83 and 0.82.
  static float balance(const FiberParameters& fiber, const EnergyTable& energies, Offset offset);

  /// event: its fiber, known direction (clamped()) and xi are read; h: as in FiberModel::begin().
  TracedEvent begin(const FiberEvent& event, const FiberParameters& fiber, float h) const;
  /// About the share of the light that enters a fiber that leaves it again, by the event's energies.
  static float kept_inside(const FiberEvent& event);
  /// A place across the fiber, uniform in [-1, 1], that depends only on the event's numbers and direction. A path that
  /// replaces a row starts there and not where the ray met the fiber, because a row is the mean over the width. In
  /// dense fur the two differ: light reflected at an edge goes where there is no neighbour.
  static float any_offset(const FiberEvent& event);
  /// Traces one path: S is its throughput times the gain, in the lobe of its order, over a pdf of 1.
  FiberSample sample(FiberId id, const TracedEvent& event, const FiberParameters& fiber,
                     const std::array<float, 4>& u) const;
  /// The same, traced clear and colored afterwards, so that the service receives the same path for every color. key:
  /// selects the random stream, besides the event's numbers and u.
  HeardSample listen(FiberId id, const TracedEvent& event, const FiberParameters& fiber, const std::array<float, 4>& u,
                     std::uint64_t key) const;
  /// Estimates S at wi without bias by RoughFiber::estimate(), times the gain, with numbers that depend only on the
  /// event and wi; it sets no pdf. Offset::any: the mean over equidistant places across the fiber. With one path the
  /// variance would be 4 to 10 times as large, because a lobe comes from a part of the width that is as narrow as the
  /// roughness is small. Offset::known: one path from that place.
  FiberValue estimate(const FiberEvent& event, const TracedEvent& traced, const FiberParameters& fiber,
                      const FiberDirection& wi, Offset offset) const;
  /// The same under other absorptions, of any number of channels, with gains by their luminance. fiber: its own.
  void add_estimate(const FiberEvent& event, const TracedEvent& traced, const FiberParameters& fiber,
                    const FiberDirection& wi, Offset offset, std::span<const float> sigma_a, std::span<float> s) const;
  /// S of a path of sample() or listen() under other absorptions.
  static void recolor(const FiberSample& drawn, const FiberParameters& fiber, std::span<const float> sigma_a,
                      std::span<float> s);
  static constexpr int paths_of_estimate = 8;  ///< for Offset::any
  /// The density, 1/sr, of light that the first facet sends towards wi, from a known offset.
  float reflection(FiberId id, const TracedEvent& event, const FiberDirection& wi) const {
    return fibers_[id].first_reflection(event.entry, wi, event.kept_inside);
  }

 private:
  static FiberSample sample_of(const RoughExit& exit, const glm::vec3& throughput, const TracedEvent& event,
                               const FiberParameters& fiber);
  FiberValue estimate(const RoughFiber& rough, const FiberEvent& event, const TracedEvent& traced,
                      const FiberParameters& fiber, const FiberDirection& wi, Offset offset) const;

  Masked masked_;
  std::vector<RoughFiber> fibers_, clear_;  ///< clear_: without sigma_a
};

}  // namespace tress::inline v0_2::fiber
