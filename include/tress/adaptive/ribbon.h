// Density over a cylinder in two layers of knots: the fit of a row of a sampled target (ESTIMATOR.md, E9).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tress::inline v0_2::adaptive {

/// One knot of a layer. Between two knots density, mode and scales are linear in the azimuth.
struct RibbonKnot {
  float azimuth = 0;                       ///< radians in [-pi, pi), ascending within a layer
  float density = 0;                       ///< marginal of the layer over azimuth, 1/rad, >= 0
  float mode = 0;                          ///< mode of the height at this azimuth
  float scale_below = 1, scale_above = 1;  ///< scales of the law of the height, > 0
  /// Mean of exp(-rate attribute) over the light of the knot's hat, at Ribbon::decay_rates; in [0, 1].
  std::array<float, 2> decays{1, 1};
  friend bool operator==(const RibbonKnot&, const RibbonKnot&) = default;
};

/// The law of the height t at an azimuth, on either side of its mode m, with d = |t - m| and s the scale of that side:
///  normal:   sqrt(2/pi)/(s_below + s_above) exp(-d^2/2 s^2);
///  logistic: 2/(s_below + s_above) E/(1 + E)^2, E = exp(-d/s).
/// Its mass on the line is 1, and it is continuous at the mode.
enum class HeightLaw : std::uint8_t { normal = 0, logistic = 1 };

/// Values of the law with this mode and these scales (> 0): the density at t, the mass below t, and the height with the
/// mass u in [0, 1], clamped, below it. That height is finite and within 19 scales of the mode. The density at a height
/// that is not finite is 0, and NaN counts as 0 for the mass below it.
float height_density(HeightLaw law, float t, float mode, float scale_below, float scale_above);
float height_share_below(HeightLaw law, float t, float mode, float scale_below, float scale_above);
float sample_height(HeightLaw law, float u, float mode, float scale_below, float scale_above);

/// f(x, t) = sum over the two layers of density(x) law(t; mode(x), scales(x)), with mass 1 over both. The main layer
/// has its knots where its light is. The broad layer has equidistant knots (the first at -pi) and the logistic law.
/// Each layer continues from its last knot to its first. Immutable except for assignment; any thread may read. x in
/// radians, any turn; t any number, as in height_density(); uniforms are clamped.
class Ribbon {
 public:
  static constexpr std::size_t main_knots = 32, broad_knots = 8;
  static constexpr std::array<float, 2> decay_rates{0.15f, 0.9f};
  static constexpr float least_scale = 1e-3f, largest_scale = 0.9f, largest_mode = 12.0f;

  /// The uniform density over the sphere: heights by the logistic law of scale 1/2 about 0.
  Ribbon();
  /// Preconditions: knots as above, finite and within the bounds. Densities are scaled to mass 1; if they are all 0,
  /// the result is the uniform density.
  Ribbon(std::span<const RibbonKnot, main_knots> main, HeightLaw main_law,
         std::span<const RibbonKnot, broad_knots> broad);

  std::span<const RibbonKnot> main() const { return main_; }
  std::span<const RibbonKnot> broad() const { return broad_; }
  HeightLaw main_law() const { return main_law_; }
  /// The mass of the main layer.
  float main_mass() const { return main_below_.back(); }

  /// f, per radian and unit of height.
  float density(float x, float t) const;
  /// The Rosenblatt transform: the mass from -pi to x, and the share of the mass at x that is below t. It is uniform in
  /// the unit square if (x, t) was drawn from f.
  std::array<float, 2> cdf(float x, float t) const;
  /// Draws from f. u in [0, 1); all its bits are used. x in [-pi, pi). u_azimuth chooses the layer, then the place in
  /// it.
  struct Place {
    float azimuth, height;
  };
  Place sample(float u_azimuth, float u_height) const;

 private:
  struct Uniform {};
  explicit Ribbon(Uniform);
  void set_uniform();

  std::array<RibbonKnot, main_knots> main_;
  std::array<RibbonKnot, broad_knots> broad_;
  /// The layer's mass from its first knot to each knot; the last entry is once round, to the first knot again.
  std::array<float, main_knots + 1> main_below_;
  std::array<float, broad_knots + 1> broad_below_;
  HeightLaw main_law_ = HeightLaw::logistic;
};

/// The answer of a converged row of a sampled target: a ribbon and a mass for each part, quantised as it is kept and
/// stored (ESTIMATOR.md, E9). Packing an unpacked row gives the same bytes, and unpack() accepts no bytes other than
/// those that packing makes. Immutable except for assignment; any thread may read.
class RibbonRow {
 public:
  static constexpr std::uint32_t most_parts = 4;

  RibbonRow() = default;
  struct Part {
    Ribbon ribbon;
    float mass = 0;  ///< mass for unit flux without absorption, >= 0
  };
  /// Takes 1 to most_parts parts.
  explicit RibbonRow(std::span<const Part> parts);

  std::uint32_t parts() const { return parts_; }
  float mass(std::uint32_t part) const { return mass_[part]; }
  /// Decodes a part; a part without mass gives the uniform density.
  Ribbon ribbon(std::uint32_t part) const;
  float total_mass() const;

  /// The bytes that a cache stores, parts() times part_bytes, and the way back. unpack() returns false and changes
  /// nothing if the bytes are no valid row: masses that are negative, not finite or 0 in all, a wrong size, knots out
  /// of order, or bytes that packing never writes.
  static constexpr std::size_t part_bytes = 344;
  std::span<const std::byte> packed() const { return {bytes_.data(), parts_ * part_bytes}; }
  std::span<const float> masses() const { return {mass_.data(), parts_}; }
  bool unpack(std::span<const std::byte> bytes, std::span<const float> masses);
  std::size_t bytes() const { return sizeof(RibbonRow); }

  friend bool operator==(const RibbonRow&, const RibbonRow&) = default;

 private:
  std::uint32_t parts_ = 0;
  std::array<float, most_parts> mass_{};
  std::array<std::byte, most_parts * part_bytes> bytes_{};
};

/// A row with decoded parts, for readers of several of its values. A part without mass is the uniform density.
struct DecodedRow {
  DecodedRow() = default;
  explicit DecodedRow(const RibbonRow& row);

  std::uint32_t parts = 0;
  std::array<float, RibbonRow::most_parts> mass{};  ///< RibbonRow::mass()
  std::array<Ribbon, RibbonRow::most_parts> ribbon;
};

/// The share of light that is left at any rate >= 0, from the mean decays of its attribute at two rates: the Laplace
/// transform (1 + scale rate)^-shape of the gamma law that goes through both. It is in [0, 1], and 1 at rate 0. Light
/// of one attribute alone has a scale of least_scale, which makes no difference in single precision at rates that leave
/// light.
struct GammaDecay {
  static constexpr float least_scale = 1e-3f;
  float shape = 0, scale = least_scale;
  /// decays: at Ribbon::decay_rates, in [0, 1]. A pair that no law has (the second above the first or below its 6th
  /// power) is replaced by the nearest that one has.
  static GammaDecay from(const std::array<float, 2>& decays);
  float at(float rate) const;
};

}  // namespace tress::inline v0_2::adaptive
