// Traces many split paths through a rough elliptical fiber side by side: RoughFiber::trace_split() in vector lanes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "fiber/lane_stack.h"
#include "fiber/rough_fiber.h"
#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// The exits of the paths of a RoughPaths, in the order in which they were found.
class RoughPathExits {
 public:
  enum Field : std::size_t { dx, dy, dz, weight_field, way_field, path_field, tag_field, fields };

  std::size_t size() const { return records_.size(); }
  float weight(std::size_t i) const { return records_.at(weight_field, i); }  ///< for unit flux without absorption
  float way(std::size_t i) const { return records_.at(way_field, i); }        ///< in the cortex, major semi-axes
  glm::vec3 direction(std::size_t i) const { return {records_.at(dx, i), records_.at(dy, i), records_.at(dz, i)}; }
  std::uint32_t path(std::size_t i) const { return records_.word(path_field, i); }  ///< as passed to add()
  std::uint32_t set(std::size_t i) const { return records_.word(tag_field, i) & 15; }
  /// The number of times it was inside; 7 means 7 or more.
  int order(std::size_t i) const { return static_cast<int>(records_.word(tag_field, i) >> 9 & 7); }

  /// The directions of all exits, one after the other: azimuths relative to that of (cos_b, sin_b), in [-pi, pi), and
  /// asinh(tan theta_i), within +-largest_height. Errors below 1e-6.
  void places(float cos_b, float sin_b, float largest_height, std::vector<float>& azimuth,
              std::vector<float>& height) const;

 private:
  friend class RoughPaths;
  LaneStack records_{fields};
};

/// Follows paths as a wavefront of surface events, 16 at a time. The expected light is that of
/// RoughFiber::trace_split() with Masked::meets_others, but both lights that stay at a facet are followed, each with
/// its own roulette. The result of a path depends on its own numbers and, by rounding, on the instruction set, not on
/// the paths traced with it. One thread.
class RoughPaths {
 public:
  static constexpr std::uint32_t most_sets = 16;

  /// Reads eta, eccentricity, roughness, tilt, the medulla, the cortex and the wetness.
  explicit RoughPaths(const FiberParameters& parameters, const SplitRules& rules = {});
  ~RoughPaths();
  RoughPaths(const RoughPaths&) = delete;
  RoughPaths& operator=(const RoughPaths&) = delete;

  /// Adds a path that enters at `entry`, with the first facets from `u`; further numbers come from (seed, path).
  void add(const RoughEntry& entry, const RoughFiber::FacetNumbers& u, std::uint32_t seed, std::uint32_t path,
           std::uint32_t set);
  /// Adds paths [first, first + count) from one direction on the scrambled Sobol points of a key: h and the facets.
  void add_sobol(const FiberDirection& wr, std::uint64_t key, std::uint32_t first, std::uint32_t count,
                 std::uint32_t set);
  /// The same, but each path shares the light that its first facet reflects away with `more_reflections` others, of
  /// which nothing else is traced. The expected light is the same.
  void add_sobol_with_reflections(const FiberDirection& wr, std::uint64_t key, std::uint32_t first, std::uint32_t count,
                                  std::uint32_t set);
  static constexpr std::uint32_t more_reflections = 3;

  /// Traces all added paths, which are then removed, and returns their exits; valid until the next call.
  const RoughPathExits& trace();

  /// The fiber and the rules in the form that the vector code reads.
  struct Constants {
    float eccentricity, alpha, film_alpha, eta, tan_tilt, cos_tilt, roulette_below, longest_way;
    TracedParts parts;
  };

 private:
  void add_entries(const FiberDirection& wr, std::uint64_t key, std::uint32_t first, std::uint32_t count,
                   std::uint32_t tags);
  struct Memory;
  /// Memory that this thread's last RoughPaths has left, for reuse: new pages cost more time than the paths on them.
  static std::unique_ptr<Memory>& spare();

  RoughFiber fiber_;
  Constants constants_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace tress::inline v0_2::fiber
