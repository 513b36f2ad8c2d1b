// The basis of the paper's fit on a sample of azimuths: p_d and its derivatives by the shape parameters b_d.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tress::inline v0_2::adaptive {

/// What x = phi - mu is: wrapped into [-pi, pi) (this project's components), or taken on the line, where p_d is cut
/// off at +-pi (table 3 as printed; the periodicity term of section 5.2 is for these).
enum class AisBasis : std::uint8_t { circular, line };

/// b_d: mode in [-pi, pi), scales in radians. Table 3's p_d = E/(1+E)^2, E = exp(-|x|/s), s = left for x < 0, else
/// right: 1/4 at mu, not normalised; its mass is P_d of step I.
struct AisShape {
  double mu = 0, left = 0.5, right = 0.5;

  /// Mass of each side: s/2 tanh(c/(2s)), c = pi, or the way to the end of the line.
  double left_mass(AisBasis basis) const;
  double right_mass(AisBasis basis) const;
  /// P_d.
  double mass(AisBasis basis) const { return left_mass(basis) + right_mass(basis); }
};

/// Derivatives by (mu, ln left, ln right), and the second ones by (mu mu, mu left, mu right, left left, right right):
/// the mixed one of both scales is 0, since a side knows only its own.
constexpr std::size_t ais_first = 3, ais_second = 5;

/// p at n azimuths in [-pi, pi], n a multiple of kernel_lanes; derivatives in columns `stride` apart.
void ais_columns(const AisShape& shape, AisBasis basis, const double* azimuth, std::size_t n, double* p, double* first,
                 double* second, std::size_t stride);

}  // namespace tress::inline v0_2::adaptive
