// The light of the parts of a sampled target, clear and under absorption, from all paths that were drawn.
#pragma once

#include <array>
#include <cstdint>

#include "fit/row_exits.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::inline v0_2::adaptive {

/// Sums over exits by part. Plain data; one thread.
class PartEnergies {
 public:
  /// Adds the exits of this many paths.
  void add(const RowExits& exits, std::uint64_t paths);

  /// The mean over paths of the weights of a part.
  double mass(std::uint32_t part) const;
  double total_mass() const;
  /// Whether there is light, and not more than a float holds.
  bool has_mass() const;

  /// Returns the ribbon with decays whose mean over its light, at Ribbon::decay_rates, is that of the part. The
  /// logarithms of all knots are multiplied by one factor. The part must have mass.
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

}  // namespace tress::inline v0_2::adaptive
