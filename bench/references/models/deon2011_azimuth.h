// Azimuthal scattering of d'Eon et al. 2011: rays through a circle at fixed offsets, and a Gaussian detector.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "base/float4.h"

namespace tress::inline v0_2::fiber {

/// Gauss-Legendre points over h in [-1, 1]. A circle mirrors h and -h, so that only one of the two is traced. Immutable
/// plain data; any thread.
struct OffsetQuadrature {
  /// points in [1, 65536].
  explicit OffsetQuadrature(int points);

  /// Four offsets in lanes. weight: of each side, halves of the rule's over 2, so that all of both sides sum to 1;
  /// lanes that are left over have none.
  struct Group {
    Float4 h, gamma;  ///< h >= 0 and asin h
    Float4 weight;
  };
  std::vector<Group> groups;
};

/// Fiber of circular cross-section.
struct CircularFiber {
  float eta = 1.55f;
  glm::vec3 sigma_a{0.0f};  ///< per radius
  Float4 sigma = splat(1);  ///< of the detector, R, TT, TRT, TRRT, radians, (0, pi/4]
};

/// The orders that the detector sees, R, TT, TRT, TRRT.
constexpr int detected_orders = 4;
using OrderColors = std::array<glm::vec3, detected_orders>;

/// Energies E_p = 1/2 integral A_p(h) dh by the quadrature, per channel: four orders, then all others. For clear hair
/// they sum to 1 to rounding, with any number of points. theta_d within +-pi/2.
std::array<glm::vec3, detected_orders + 1> circle_energies(const OffsetQuadrature& quadrature,
                                                           const CircularFiber& fiber, float theta_d);

/// The rays of every offset at one |theta_d|, and the sum of detectors that they make. Scratch memory of one thread.
class AzimuthalTrace {
 public:
  /// theta_d within +-pi/2. `quadrature` must outlive the use.
  void trace(const OffsetQuadrature& quadrature, const CircularFiber& fiber, float theta_d);

  /// Shape of order p at azimuth phi_i - phi_r in [-pi, pi], per channel, mass 1:
  ///   sum_k w_k A_p(h_k) D(phi - Phi_p(h_k)) / sum_k w_k A_p(h_k),  D the wrapped Gaussian of standard deviation
  ///   sigma.
  /// Uniform in a channel where no light is left (sum below 1e-30).
  glm::vec3 shape(int p, float phi) const;
  /// sum_k w_k A_p(h_k), per channel.
  const glm::vec3& mass(int p) const { return orders_[static_cast<std::size_t>(p)].mass; }
  /// Draws from sum_c channel_weights_c shape_c(p, .): an offset by u, then the Gaussian about its exit by `normal`,
  /// standard normal. channel_weights >= 0, sum 1. In [-pi, pi).
  float sample(int p, const glm::vec3& channel_weights, float u, float normal) const;

 private:
  struct Group {
    Float4 azimuth;                ///< |Phi_p|, in [0, pi]
    std::array<Float4, 3> weight;  ///< w A_p of one side, per channel
  };
  struct Order {
    std::vector<Group> groups;
    glm::vec3 mass{0.0f}, inverse_mass{0.0f};  ///< inverse 0 where the channel is dark
    float sigma = 1;
  };
  std::array<Order, detected_orders> orders_;
};

}  // namespace tress::inline v0_2::fiber
