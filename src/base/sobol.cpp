#include "base/sobol.h"

#include "base/sobol_directions.h"
#include "tress/base/random.h"

namespace tress::inline v0_2 {
namespace {

/// Flips each bit by a hash of the bits above it.
constexpr std::uint32_t scrambled(std::uint32_t x, std::uint32_t seed) {
  x = reversed_bits(x);
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return reversed_bits(x);
}

}  // namespace

ScrambledSobol::ScrambledSobol(std::uint64_t key) {
  RandomStream random(key);
  for (std::uint32_t& seed : seeds_) seed = static_cast<std::uint32_t>(random.next_bits() >> 32);
}

ScrambledSobol::Point ScrambledSobol::point(std::uint32_t index) const {
  const std::array<std::uint32_t, dimensions> x = sobol_bits(index);
  Point point;
  for (std::size_t d = 0; d < dimensions; ++d) {
    point[d] = static_cast<float>(scrambled(x[d], seeds_[d]) >> 8) * 0x1p-24f;
  }
  return point;
}

}  // namespace tress::inline v0_2
