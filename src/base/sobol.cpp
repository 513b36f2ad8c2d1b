#include "base/sobol.h"

#include <bit>

#include "tress/base/random.h"

namespace tress {
namespace {

constexpr std::size_t bits = 32;
using Directions = std::array<std::uint32_t, bits>;  // by bit of the index

/// A primitive polynomial of a degree, its inner coefficients, and the first numbers m of its recurrence.
struct Polynomial {
  std::uint32_t degree, coefficients;
  std::array<std::uint32_t, 5> first;
};
constexpr std::array<Polynomial, ScrambledSobol::dimensions - 1> polynomials{{{1, 0, {1}},
                                                                              {2, 1, {1, 3}},
                                                                              {3, 1, {1, 3, 1}},
                                                                              {3, 2, {1, 1, 1}},
                                                                              {4, 1, {1, 1, 3, 3}},
                                                                              {4, 4, {1, 3, 5, 13}},
                                                                              {5, 2, {1, 1, 5, 5, 17}}}};

constexpr Directions directions_of(const Polynomial& p) {
  Directions v{};
  for (std::size_t i = 0; i < bits; ++i) {
    if (i < p.degree) {
      v[i] = p.first[i] << (bits - 1 - i);
      continue;
    }
    v[i] = v[i - p.degree] ^ (v[i - p.degree] >> p.degree);
    for (std::uint32_t k = 1; k < p.degree; ++k) {
      if ((p.coefficients >> (p.degree - 1 - k)) & 1u) v[i] ^= v[i - k];
    }
  }
  return v;
}

/// [bit of the index][dimension]
constexpr auto directions = [] {
  std::array<std::array<std::uint32_t, ScrambledSobol::dimensions>, bits> table{};
  for (std::size_t i = 0; i < bits; ++i) table[i][0] = 1u << (bits - 1 - i);
  for (std::size_t d = 1; d < ScrambledSobol::dimensions; ++d) {
    const Directions v = directions_of(polynomials[d - 1]);
    for (std::size_t i = 0; i < bits; ++i) table[i][d] = v[i];
  }
  return table;
}();

constexpr std::uint32_t reversed(std::uint32_t x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  return (x >> 16) | (x << 16);
}

/// Flips each bit by a hash of the bits above it.
constexpr std::uint32_t scrambled(std::uint32_t x, std::uint32_t seed) {
  x = reversed(x);
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return reversed(x);
}

}  // namespace

ScrambledSobol::ScrambledSobol(std::uint64_t key) {
  RandomStream random(key);
  for (std::uint32_t& seed : seeds_) seed = static_cast<std::uint32_t>(random.next_bits() >> 32);
}

ScrambledSobol::Point ScrambledSobol::point(std::uint32_t index) const {
  std::array<std::uint32_t, dimensions> x{};
  for (; index != 0; index &= index - 1) {
    const auto& row = directions[static_cast<std::size_t>(std::countr_zero(index))];
    for (std::size_t d = 0; d < dimensions; ++d) x[d] ^= row[d];
  }
  Point point;
  for (std::size_t d = 0; d < dimensions; ++d) {
    point[d] = static_cast<float>(scrambled(x[d], seeds_[d]) >> 8) * 0x1p-24f;
  }
  return point;
}

}  // namespace tress
