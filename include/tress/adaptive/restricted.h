// Rows restricted to an interval of azimuth, such as the half-cylinder above the horizon of a surface: no mass beyond
// it, all of it inside.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "tress/adaptive/mixture.h"
#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::adaptive {

/// The azimuths from `from` (radians, any turn) upwards over `width`, [least_width, 2 pi]. Everything clamps a width
/// out of that range; numbers that are not finite count as 0, but a width of infinity as 2 pi.
struct Arc {
  static constexpr float least_width = 1e-5f;
  float from = 0, width = 0;
  /// Both ends count, and 1e-6 beyond them, so that every azimuth that is drawn is inside.
  bool contains(float x) const;
  /// Within its ranges, from in [-pi, pi): the arc that it stands for.
  Arc clamped() const;
};

/// A mixture within an arc: its components cut off there, and scaled to the energy that the mixture has on the whole
/// circle. One without light in the arc is uniform there. It is built in a microsecond or so. Immutable; any thread.
/// Also of a PackedMixture, as RowView has it: RestrictedMixture(*row.fit, arc).
class RestrictedMixture {
 public:
  RestrictedMixture(const Mixture& mixture, const Arc& arc);

  /// The share of the mixture's energy that was inside, [0, 1].
  float share_inside() const { return energy_ > 0 ? static_cast<float>(inside_ / energy_) : 0; }
  /// 1/rad; 0 outside. Its integral over the arc is the mixture's energy.
  float density(float x) const;
  /// The density from which sample() draws, 1/rad: (1 - u_share) density/energy + u_share/width; 0 outside. Its
  /// integral over the arc is 1.
  float proposal_density(float x, float u_share) const;
  /// Draws from it. u in [0, 1), clamped. Radians in [-pi, pi).
  float sample(float u, float u_share) const;

 private:
  /// One side of a component, between two distances from its mode.
  struct Piece {
    double mass, scale, nearest, farthest;  ///< scale: negative on the left
    float mu;
  };

  Mixture mixture_;
  Arc arc_;
  double energy_, inside_ = 0;
  std::size_t count_ = 0;
  std::array<Piece, 4 * Mixture::max_components> pieces_;
};

/// A ribbon within an arc, of mass 1, over all heights. One without light there is the uniform density. Immutable; any
/// thread.
class RestrictedRibbon {
 public:
  RestrictedRibbon(const Ribbon& ribbon, const Arc& arc);

  /// The share of the ribbon's mass that was inside.
  float share_inside() const { return share_; }
  /// Per radian and unit of height; 0 outside.
  float density(float x, float t) const;
  /// Draws from it, as Ribbon::sample() does.
  Ribbon::Place sample(float u_azimuth, float u_height) const;

 private:
  Ribbon ribbon_;
  Arc arc_;
  double main_, broad_;  ///< masses of the layers inside
  float share_;
};

/// The row of a slice of samples within an arc: each part keeps its mass.
class RestrictedRow {
 public:
  RestrictedRow(const RibbonRow& row, const Arc& arc);
  std::uint32_t parts() const { return parts_; }
  float mass(std::uint32_t part) const { return mass_[part]; }
  /// The density of a part within the arc, of mass 1.
  const RestrictedRibbon& ribbon(std::uint32_t part) const { return ribbon_[part]; }

 private:
  std::uint32_t parts_;
  std::array<float, RibbonRow::most_parts> mass_{};
  std::array<RestrictedRibbon, RibbonRow::most_parts> ribbon_;
};

}  // namespace tress::inline v0_2::adaptive
