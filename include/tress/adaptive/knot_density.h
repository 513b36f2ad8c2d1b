// Circular piecewise-linear density on equidistant knots: what a row is answered with where the learner is `table`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tress::adaptive {

/// One knot: the density there, and the moments of the attribute over the light of its hat function.
struct Knot {
  float density = 0;             ///< 1/rad, >= 0
  float attribute_mean = 0;      ///< of the traced rays that this knot answers for
  float attribute_variance = 0;  ///< likewise
  friend bool operator==(const Knot&, const Knot&) = default;
};

/// f(x) = sum_k density_k hat_k(x), knot k of K at -pi + k h, h = 2 pi/K; hat_k is 1 at its knot, 0 at the others and
/// linear between them, so f is what joins the knots by straight lines and its mass is h sum_k density_k, exactly.
/// Each hat is what a component is to a mixture: of mass h density_k, with its own attribute.
/// Immutable but for assignment; any thread may read. Azimuths in radians.
class KnotDensity {
 public:
  /// K is one of these and what lies between them by doubling: 32, 64, 128.
  static constexpr std::uint32_t fewest = 32, most = 128;
  static constexpr std::uint32_t sizes = 3;  ///< how many K there are
  static constexpr bool is_size(std::size_t count) { return count == 32 || count == 64 || count == 128; }

  /// No knots: 0 everywhere, drawn uniformly.
  KnotDensity() = default;
  /// is_size(knots.size()), densities finite and >= 0: a precondition.
  explicit KnotDensity(std::vector<Knot> knots);

  bool empty() const { return knots_.empty(); }
  std::span<const Knot> knots() const { return knots_; }
  /// Mass: h sum density_k, summed in double.
  float energy() const { return energy_; }
  /// Bytes of memory beyond the object itself.
  std::size_t bytes() const { return knots_.size() * (sizeof(Knot) + sizeof(float)); }

  /// f, 1/rad, radians in any turn.
  float density(float phi) const;
  /// Density of what sample() draws: (1 - u_share) f/energy + u_share/2 pi. Uniform if energy is 0. 1/rad.
  float proposal_density(float phi, float u_share) const;
  /// Draws from proposal_density(., u_share) by inversion. u in [0, 1) is used up whole. Radians in [-pi, pi).
  float sample(float u, float u_share) const;

 private:
  std::vector<Knot> knots_;
  std::vector<float> below_;  ///< mass between -pi and knot k, over the energy
  float energy_ = 0;
};

/// Where a straight line from density a to density b, over a cell of length 1, has the share r of its mass below it:
/// the inverse CDF in the form that loses no bits where a and b are close. a, b >= 0; r in [0, 1]. In [0, 1].
float invert_line(float a, float b, float r);

}  // namespace tress::adaptive
