#include "base/sobol.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/sobol_directions.h"

// foreach_target compiles this once for every instruction set; the first call chooses the machine's.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "base/sobol.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2 {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, 16>;
using Words = hn::Repartition<std::uint32_t, Floats>;
using W = hn::Vec<Words>;

template <int shift>
HWY_INLINE W Swapped(W x, std::uint32_t low) {
  const W mask = hn::Set(Words(), low);
  return hn::Or(hn::And(hn::ShiftRight<shift>(x), mask), hn::ShiftLeft<shift>(hn::And(x, mask)));
}

HWY_INLINE W Reversed(W x) {
  x = Swapped<1>(x, 0x55555555u);
  x = Swapped<2>(x, 0x33333333u);
  x = Swapped<4>(x, 0x0f0f0f0fu);
  x = Swapped<8>(x, 0x00ff00ffu);
  return hn::Or(hn::ShiftRight<16>(x), hn::ShiftLeft<16>(x));
}

// Scrambles as ScrambledSobol::point() does; the bits are already reversed.
HWY_INLINE hn::Vec<Floats> Scrambled(W x, std::uint32_t seed) {
  const Words w;
  x = hn::Xor(x, hn::Mul(x, hn::Set(w, 0x3d20adeau)));
  x = hn::Add(x, hn::Set(w, seed));
  x = hn::Mul(x, hn::Set(w, (seed >> 16) | 1u));
  x = hn::Xor(x, hn::Mul(x, hn::Set(w, 0x05526c56u)));
  x = hn::Xor(x, hn::Mul(x, hn::Set(w, 0x53a22864u)));
  const auto whole = hn::BitCast(hn::RebindToSigned<Words>(), hn::ShiftRight<8>(Reversed(x)));
  return hn::Mul(hn::ConvertTo(Floats(), whole), hn::Set(Floats(), 0x1p-24f));
}

// Computes the points of a block of 16 whose first index is a multiple of 16; out[d][lane].
void BlockOfPoints(const std::uint32_t* seeds, std::uint32_t block, std::size_t wanted, float (*out)[16]) {
  static constexpr auto within = [] {
    std::array<std::array<std::uint32_t, 16>, ScrambledSobol::dimensions> bits{};
    for (std::uint32_t i = 0; i < 16; ++i) {
      const auto point = sobol_bits(i);
      for (std::size_t d = 0; d < bits.size(); ++d) bits[d][i] = reversed_bits(point[d]);
    }
    return bits;
  }();
  const Words w;
  const std::array<std::uint32_t, ScrambledSobol::dimensions> start = sobol_bits(block);
  for (std::size_t d = 0; d < wanted; ++d) {
    const W before = hn::Set(w, reversed_bits(start[d]));
    for (std::size_t i = 0; i < 16; i += hn::Lanes(w)) {
      hn::StoreU(Scrambled(hn::Xor(before, hn::LoadU(w, &within[d][i])), seeds[d]), Floats(), &out[d][i]);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>
#include <span>

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

HWY_EXPORT(BlockOfPoints);

void ScrambledSobol::points(std::uint32_t first, std::uint32_t count, std::span<float* const> out) const {
  const auto block_of_points = HWY_DYNAMIC_DISPATCH(BlockOfPoints);
  alignas(64) float block[dimensions][16];
  for (std::uint32_t done = 0; done < count;) {
    const std::uint32_t index = first + done, skipped = index % 16, here = std::min(16 - skipped, count - done);
    block_of_points(seeds_.data(), index - skipped, out.size(), block);
    for (std::size_t d = 0; d < out.size(); ++d) std::copy_n(block[d] + skipped, here, out[d] + done);
    done += here;
  }
}

}  // namespace tress::inline v0_2

#endif
