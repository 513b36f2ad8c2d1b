// Counter-based random numbers: the same key gives the same numbers on every thread.
#pragma once

#include <bit>
#include <cstdint>

namespace tress::inline v0_2 {

/// Mixes 64 bits (the finaliser of splitmix64, Steele et al. 2014). Bijective.
constexpr std::uint64_t mix_bits(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

/// The bits of both numbers, as a key.
constexpr std::uint64_t bits_of(float a, float b) {
  return (std::uint64_t{std::bit_cast<std::uint32_t>(a)} << 32) | std::bit_cast<std::uint32_t>(b);
}

/// A stream keyed by up to three integers (seed, pixel, sample, ...). Copyable; each copy is for one thread.
class RandomStream {
 public:
  explicit constexpr RandomStream(std::uint64_t key, std::uint64_t second = 0, std::uint64_t third = 0)
      : state_(mix_bits(mix_bits(mix_bits(key + 0x9e3779b97f4a7c15ull) ^ (second + 0x7f4a7c159e3779b9ull)) ^
                        (third + 0x3c6ef372fe94f82aull))) {}

  constexpr std::uint64_t next_bits() { return mix_bits(state_ += 0x9e3779b97f4a7c15ull); }

  /// Returns a number uniform in [0, 1), with 24 bits.
  constexpr float next() { return static_cast<float>(next_bits() >> 40) * 0x1p-24f; }

 private:
  std::uint64_t state_;
};

}  // namespace tress::inline v0_2
