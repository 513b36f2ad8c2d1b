// Circular piecewise-linear density on equidistant knots: the rival `table`, a row without a mixture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tress::inline v0_2::adaptive {

/// One knot: the density there, and the moments of the attribute over the light of its hat function.
struct Knot {
  float density = 0;             ///< 1/rad, >= 0
  float attribute_mean = 0;      ///< over the traced rays that this knot accounts for
  float attribute_variance = 0;  ///< over the same rays
  friend bool operator==(const Knot&, const Knot&) = default;
};

/// f(x) = sum_k density_k hat_k(x), knot k of K at -pi + k h, h = 2 pi/K. hat_k is 1 at its knot, 0 at the others and
/// linear between them, so f joins the knots by straight lines and its mass is exactly h sum_k density_k. A hat
/// corresponds to a component of a mixture: it has mass h density_k and its own attribute. Immutable except for
/// assignment; any thread may read. Azimuths in radians.
class KnotDensity {
 public:
  /// K is 32, 64 or 128.
  static constexpr std::uint32_t fewest = 32, most = 128;
  static constexpr std::uint32_t sizes = 3;  ///< number of possible values of K
  static constexpr bool is_size(std::size_t count) { return count == 32 || count == 64 || count == 128; }

  /// Has no knots: the density is 0 everywhere, and sample() draws uniformly.
  KnotDensity() = default;
  /// Preconditions: is_size(knots.size()); densities finite and >= 0.
  explicit KnotDensity(std::vector<Knot> knots);

  bool empty() const { return knots_.empty(); }
  std::span<const Knot> knots() const { return knots_; }
  /// The mass, h sum density_k, summed in double.
  float energy() const { return energy_; }
  /// Bytes of memory beyond the object itself.
  std::size_t bytes() const { return knots_.size() * (sizeof(Knot) + sizeof(float)); }

  /// f in 1/rad; phi in radians, any turn.
  float density(float phi) const;
  /// The density from which sample() draws: (1 - u_share) f/energy + u_share/2 pi, in 1/rad. Uniform if energy is 0.
  float proposal_density(float phi, float u_share) const;
  /// Draws from proposal_density(., u_share) by inversion. u in [0, 1); all its bits are used. Radians in [-pi, pi).
  float sample(float u, float u_share) const;

 private:
  std::vector<Knot> knots_;
  std::vector<float> below_;  ///< mass between -pi and knot k, divided by the energy
  float energy_ = 0;
};

}  // namespace tress::inline v0_2::adaptive
