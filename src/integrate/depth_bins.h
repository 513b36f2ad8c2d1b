// The light of a pixel's paths by depth.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/ext/vector_double3.hpp>

namespace tress::integrate {

/// Opaque paths that end between two depths. Trivially copyable: files have its bytes.
struct DepthBin {
  glm::dvec3 light{0.0};          ///< sum over the paths, linear RGB
  float near_cm = 0, far_cm = 0;  ///< the least and the largest distance of the paths
  std::uint32_t paths = 0;        ///< 0 if this bin and all after it are free
  std::uint32_t always_zero = 0;  ///< so that the bytes have no gap
};

/// The bins of one pixel, from near to far; they do not overlap. The order of the paths matters for where bins end, and
/// the paths of a pixel always come in the same order.
struct DepthBins {
  static constexpr std::size_t most = 8;
  std::array<DepthBin, most> bins{};

  /// Adds an opaque path, to the bin that its distance lies in, if there is one. Otherwise the path opens a bin. If
  /// there is no room, the two neighbours that are shortest together become one bin.
  void add(const glm::dvec3& light, float distance_cm);
  /// Whether the bins can be those of a pixel with this number of paths.
  bool are_sound(std::uint32_t paths) const;
};

}  // namespace tress::integrate
