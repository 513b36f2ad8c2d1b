// The unscrambled Sobol sequence, as bits.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/sobol.h"

namespace tress::inline v0_2 {
namespace sobol_detail {

constexpr std::size_t bits = 32;
using Directions = std::array<std::uint32_t, bits>;  // by bit of the index

/// A primitive polynomial: its degree, its inner coefficients, and the first numbers m of its recurrence.
struct Polynomial {
  std::uint32_t degree, coefficients;
  std::array<std::uint32_t, 5> first;
};
inline constexpr std::array<Polynomial, ScrambledSobol::dimensions - 1> polynomials{{{1, 0, {1}},
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
inline constexpr auto directions = [] {
  std::array<std::array<std::uint32_t, ScrambledSobol::dimensions>, bits> table{};
  for (std::size_t i = 0; i < bits; ++i) table[i][0] = 1u << (bits - 1 - i);
  for (std::size_t d = 1; d < ScrambledSobol::dimensions; ++d) {
    const Directions v = directions_of(polynomials[d - 1]);
    for (std::size_t i = 0; i < bits; ++i) table[i][d] = v[i];
  }
  return table;
}();

}  // namespace sobol_detail

/// The binary digits of the point with an index, the first digit as the highest bit. Those of i ^ j are those of i ^
/// those of j.
constexpr std::array<std::uint32_t, ScrambledSobol::dimensions> sobol_bits(std::uint32_t index) {
  std::array<std::uint32_t, ScrambledSobol::dimensions> x{};
  for (; index != 0; index &= index - 1) {
    const auto& row = sobol_detail::directions[static_cast<std::size_t>(std::countr_zero(index))];
    for (std::size_t d = 0; d < ScrambledSobol::dimensions; ++d) x[d] ^= row[d];
  }
  return x;
}

constexpr std::uint32_t reversed_bits(std::uint32_t x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  return (x >> 16) | (x << 16);
}

}  // namespace tress::inline v0_2
