// Scrambled Sobol points: stratified in every prefix of 2^k points, unbiased, with random access.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tress::inline v0_2 {

/// The Sobol sequence with the direction numbers of Joe and Kuo 2008 (new-joe-kuo-6). Each dimension is scrambled by
/// nested uniform bit flips (Owen 1995), decided by a hash of its key (Laine and Karras 2011, with the constants of
/// Vegdahl 2021). The point of any index is uniform in the unit cube over keys; the first 2^k points of a key have one
/// in each of the 2^k equal intervals of every dimension. Immutable plain data; any thread.
class ScrambledSobol {
 public:
  static constexpr std::size_t dimensions = 8;
  using Point = std::array<float, dimensions>;  ///< in [0, 1), 24 bits

  /// Different keys give independent scrambles.
  explicit ScrambledSobol(std::uint64_t key);
  Point point(std::uint32_t index) const;
  /// Computes the points [first, first + count) in lanes, to the same bits: out[d][i] is dimension d of point first +
  /// i, for the first dimensions.
  void points(std::uint32_t first, std::uint32_t count, std::span<float* const> out) const;

 private:
  std::array<std::uint32_t, dimensions> seeds_;
};

}  // namespace tress::inline v0_2
