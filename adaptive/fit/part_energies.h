// How much light the parts of a sampled target have, clear and under absorption, by all paths that were drawn.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "fit/row_exits.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::adaptive {

/// Sums over exits by part. Plain data; one thread.
class PartEnergies {
 public:
  /// The exits of this many paths: parts below SampledTarget::most_parts.
  void add(std::span<const SampledExit> exits, std::uint64_t paths);

  /// The same exits, sorted.
  void add(const RowExits& exits, std::uint64_t paths);

  std::uint64_t paths() const { return paths_; }
  /// Mean over paths of the weights of a part.
  double mass(std::uint32_t part) const;
  double total_mass() const;
  /// Whether there is light, and no more than a float holds.
  bool has_mass() const;

  /// The same ribbon where what absorption leaves of all its light, at Ribbon::decay_rates, is what it leaves of the
  /// part: of every knot the logarithms are multiplied alike. For a part of some mass.
  Ribbon mended(const Ribbon& ribbon, std::uint32_t part) const;

 private:
  static constexpr std::size_t rates = Ribbon::decay_rates.size();
  struct Light {
    double clear = 0;
    std::array<double, rates> left{};
  };
  std::array<Light, SampledTarget::most_parts> light_{};
  std::uint64_t paths_ = 0;
};

}  // namespace tress::adaptive
