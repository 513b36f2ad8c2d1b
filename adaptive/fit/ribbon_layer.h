// The two layers of a ribbon while it is fitted, and how exits fall between their knots.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "fit/exit_columns.h"
#include "fit/ribbon_kernels.h"
#include "tress/adaptive/ribbon.h"

namespace tress::adaptive {

/// A layer while it is fitted.
template <std::size_t count>
struct RibbonLayer {
  std::array<std::uint32_t, count> bin;  ///< where the knot is
  std::array<double, count> density{}, mode{}, scale_below{}, scale_above{};
  double least_scale = Ribbon::least_scale;

  double azimuth(std::size_t k) const { return ExitColumns::azimuth(bin[k]); }
  double width(std::size_t k) const {
    const std::uint32_t bins = k + 1 < count ? bin[k + 1] - bin[k] : bin[0] + ExitColumns::bins - bin[k];
    return 2 * std::numbers::pi * bins / ExitColumns::bins;
  }
  double hat(std::size_t k) const { return 0.5 * (width(k) + width(before(k))); }
  static std::size_t before(std::size_t k) { return (k + count - 1) % count; }
  static std::size_t after(std::size_t k) { return (k + 1) % count; }

  RibbonSegment segment(std::size_t k, bool before_first) const {
    const std::size_t next = after(k);
    const auto pair = [&](const std::array<double, count>& of, float(&out)[2]) {
      out[0] = static_cast<float>(of[k]);
      out[1] = static_cast<float>(of[next]);
    };
    RibbonSegment s;
    s.x0 = static_cast<float>(azimuth(k) - (before_first ? 2 * std::numbers::pi : 0));
    s.inverse_width = static_cast<float>(1 / width(k));
    pair(density, s.density);
    pair(mode, s.mode);
    pair(scale_below, s.scale_below);
    pair(scale_above, s.scale_above);
    return s;
  }
};

/// Exits between two knots of either layer.
struct RibbonPiece {
  std::uint32_t begin, end;
  std::size_t main, broad;
  bool before_first;  ///< knot of the main layer, on the way round from its last
};

using MainLayer = RibbonLayer<Ribbon::main_knots>;
using BroadLayer = RibbonLayer<Ribbon::broad_knots>;

/// Exits as they are fitted: each between two knots of either layer.
struct RibbonLight {
  const ExitColumns& exits;
  double count = 1;            ///< as many exits of equal weight tell as much
  std::vector<float> weights;  ///< adding up to count
  std::vector<RibbonPiece> pieces;
  std::array<double, 4> harmonics{};  ///< means of cos x, sin x, cos 2x, sin 2x
};

/// Scales the densities of both layers so that their mass is 1; not where there is none.
void scale_to_one(MainLayer& main, BroadLayer& broad);

}  // namespace tress::adaptive
