// Four floats at once by the compilers' vector extension (g++ and clang++, any machine). The lobes of a vertex are
// computed together in these lanes.
#pragma once

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace tress::inline v0_2 {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

inline Float4 splat(float x) { return Float4{x, x, x, x}; }
/// Returns floats first to first + 3 of an object that consists of floats only.
template <class Floats>
Float4 load4(const Floats& from, std::size_t first) {
  Float4 x;
  std::memcpy(&x, reinterpret_cast<const std::byte*>(&from) + first * sizeof(float), sizeof(x));
  return x;
}
template <class Floats>
void store4(Floats& to, std::size_t first, Float4 x) {
  std::memcpy(reinterpret_cast<std::byte*>(&to) + first * sizeof(float), &x, sizeof(x));
}
/// Returns {a[0], a[1], b[0], b[1]}.
inline Float4 pairs4(const float* a, const float* b) {
  using Pairs = double __attribute__((vector_size(16)));
  Pairs x;
  std::memcpy(&x, a, sizeof(double));
  std::memcpy(reinterpret_cast<std::byte*>(&x) + sizeof(double), b, sizeof(double));
  return std::bit_cast<Float4>(x);
}
inline Float4 max4(Float4 a, Float4 b) {
#ifdef __SSE2__
  return _mm_max_ps(a, b);  // does the same; g++ makes four instructions of the line below
#else
  return a > b ? a : b;
#endif
}
inline Float4 min4(Float4 a, Float4 b) {
#ifdef __SSE2__
  return _mm_min_ps(a, b);
#else
  return a < b ? a : b;
#endif
}
inline Float4 sqrt4(Float4 x) {
#ifdef __SSE2__
  return _mm_sqrt_ps(x);
#else
  return Float4{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
#endif
}
inline Float4 abs4(Float4 x) { return std::bit_cast<Float4>(std::bit_cast<Int4>(x) & 0x7fffffff); }
/// Whether a comparison holds in any lane.
inline bool any4(Int4 holds) {
#ifdef __SSE2__
  return _mm_movemask_ps(std::bit_cast<__m128>(holds)) != 0;
#else
  return (holds[0] | holds[1] | holds[2] | holds[3]) != 0;
#endif
}
inline float sum4(Float4 x) { return (x[0] + x[2]) + (x[1] + x[3]); }

/// Returns {sum of a, sum of b, sum of c, 0}.
inline Float4 sums4(Float4 a, Float4 b, Float4 c) {
#ifdef __SSE2__
  __m128 x = a, y = b, z = c, w = _mm_setzero_ps();
  _MM_TRANSPOSE4_PS(x, y, z, w);
  return (x + z) + (y + w);
#else
  return Float4{sum4(a), sum4(b), sum4(c), 0};
#endif
}

/// Makes rows of columns: lane i of a, b, c, d becomes lanes 0 to 3 of the i-th of them.
inline void transpose4(Float4& a, Float4& b, Float4& c, Float4& d) {
#ifdef __SSE2__
  __m128 x = a, y = b, z = c, w = d;
  _MM_TRANSPOSE4_PS(x, y, z, w);
  a = x, b = y, c = z, d = w;
#else
  const Float4 x = a, y = b, z = c, w = d;
  a = Float4{x[0], y[0], z[0], w[0]}, b = Float4{x[1], y[1], z[1], w[1]};
  c = Float4{x[2], y[2], z[2], w[2]}, d = Float4{x[3], y[3], z[3], w[3]};
#endif
}

/// Computes exp_of_negative() of each lane by the same steps.
inline Float4 exp_of_negative(Float4 x) {
  x = max4(x, splat(-87.0f));
  const Int4 n = __builtin_convertvector(x * 1.44269504f - 0.5f, Int4);
  const Float4 k = __builtin_convertvector(n, Float4);
  const Float4 r = (x - k * 0.693359375f) + k * 2.12194440e-4f;
  const Float4 p =
      1.0f +
      r * (1.0f + r * (0.5f + r * (1.66666667e-1f + r * (4.16666667e-2f + r * (8.33333333e-3f + r * 1.38888889e-3f)))));
  return p * std::bit_cast<Float4>((n + 127) << 23);
}

}  // namespace tress::inline v0_2
