// Scrambled Sobol points: stratified in every prefix of 2^k, unbiased, and any of them at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tress {

/// The Sobol sequence with the direction numbers of Joe and Kuo 2008 (new-joe-kuo-6), each dimension scrambled by
/// nested uniform bit flips (Owen 1995) that a hash of its key decides (Laine and Karras 2011, the constants of Vegdahl
/// 2021). The point of any index is uniform in the unit cube over keys; the first 2^k points of a key have one in each
/// of the 2^k equal intervals of every dimension. Immutable plain data; any thread.
class ScrambledSobol {
 public:
  static constexpr std::size_t dimensions = 8;
  using Point = std::array<float, dimensions>;  ///< in [0, 1), 24 bits

  /// Keys give independent scrambles.
  explicit ScrambledSobol(std::uint64_t key);
  Point point(std::uint32_t index) const;
  /// The points [first, first + count), the same bits, in lanes: out[d][i] is dimension d of point first + i, for the
  /// first dimensions.
  void points(std::uint32_t first, std::uint32_t count, std::span<float* const> out) const;

 private:
  std::array<std::uint32_t, dimensions> seeds_;
};

}  // namespace tress
