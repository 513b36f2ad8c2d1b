// Stratified numbers for the first dimensions of a pixel's paths: Sobol pairs with Owen scrambling by hashes (Burley
// 2020).
#pragma once

#include <array>
#include <cstdint>

#include "tress/base/random.h"

namespace tress::integrate {

/// Pairs of uniforms in [0, 1). The pairs of one dimension over consecutive indices are a scrambled (0,2)-sequence.
/// Different dimensions, pixels and halves (0 or 1) are independent. Thread-safe, without state.
class PixelSampler {
 public:
  PixelSampler(std::uint64_t seed, std::uint64_t pixel, std::uint32_t half)
      : key_(mix_bits(mix_bits(seed + 0x632be59bd9b4e019ull) ^ pixel) + half * 0xd1b54a32d192ed03ull) {}

  std::array<float, 2> pair(std::uint32_t index, std::uint32_t dimension) const {
    const std::uint64_t first = mix_bits(key_ + dimension * 0x9e3779b97f4a7c15ull);
    const std::uint64_t second = mix_bits(first + 1);
    const std::uint32_t shuffled = reverse(scramble(reverse(index), static_cast<std::uint32_t>(first)));
    // The scramble wants the bits of the sequence least significant first; they are reversed once, at the end.
    return {to_unit(reverse(scramble(shuffled, static_cast<std::uint32_t>(first >> 32)))),
            to_unit(reverse(scramble(sobol_second(shuffled), static_cast<std::uint32_t>(second))))};
  }

 private:
  static std::uint32_t reverse(std::uint32_t x) {
    x = (x >> 16) | (x << 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
  }

  /// Owen's nested uniform scramble of the bits, least significant first.
  static std::uint32_t scramble(std::uint32_t x, std::uint32_t seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
  }

  /// Sobol's second dimension with its bits reversed. Bit k of the index adds the polynomial (1 + x)^k modulo 2. The
  /// sum is computed by halves, since (1 + x)^(2^n) = 1 + x^(2^n).
  static std::uint32_t sobol_second(std::uint32_t index) {
    index ^= index >> 16;
    index ^= (index >> 8) & 0x00ff00ffu;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 2) & 0x33333333u;
    return index ^ ((index >> 1) & 0x55555555u);
  }

  static float to_unit(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

  std::uint64_t key_;
};

}  // namespace tress::integrate
