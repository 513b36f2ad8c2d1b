// exp and ln of several floats at once, for kernels that foreach_target compiles once for every instruction set. There
// is no #pragma once, because it is read once for every target. At most eight lanes are used, so that AVX2 and AVX-512
// add up in one order.
#if defined(TRESS_DENSITY_LAW_LANES_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TRESS_DENSITY_LAW_LANES_H
#undef TRESS_DENSITY_LAW_LANES_H
#else
#define TRESS_DENSITY_LAW_LANES_H
#endif

#include <hwy/highway.h>

#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace tress::adaptive {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, 8>;
using Fours = hn::CappedTag<float, 4>;
using Integers = hn::RebindToSigned<Floats>;
using F = hn::Vec<Floats>;
using Mask = hn::Mask<Floats>;

// exp(x) for x <= 87, relative error 2e-7; below -87 it returns exp(-87). Same method as Exp of base/exp_lanes.h, in
// floats.
HWY_INLINE F ExpOf(F x) {
  const Floats d;
  const hn::Repartition<std::uint32_t, Floats> words;
  x = hn::Max(x, hn::Set(d, -87.0f));
  const F magic = hn::Set(d, 12582912.0f);  // 1.5 2^23
  const F shifted = hn::MulAdd(x, hn::Set(d, 1.44269504f), magic);
  const F k = hn::Sub(shifted, magic);
  F r = hn::NegMulAdd(k, hn::Set(d, 0.693359375f), x);
  r = hn::NegMulAdd(k, hn::Set(d, -2.12194440e-4f), r);
  F p = hn::Set(d, 1.0f / 720);
  p = hn::MulAdd(p, r, hn::Set(d, 1.0f / 120));
  p = hn::MulAdd(p, r, hn::Set(d, 1.0f / 24));
  p = hn::MulAdd(p, r, hn::Set(d, 1.0f / 6));
  p = hn::MulAdd(p, r, hn::Set(d, 0.5f));
  p = hn::MulAdd(p, r, hn::Set(d, 1.0f));
  p = hn::MulAdd(p, r, hn::Set(d, 1.0f));
  const auto exponent = hn::ShiftLeft<23>(hn::BitCast(words, shifted));
  return hn::BitCast(d, hn::Add(hn::BitCast(words, p), exponent));
}

// ln(x) for x > 0 and not denormal; the error is 2e-7 of the larger of the result and 1. x = 2^k (1 + y), and the
// logarithm of 1 + y is 2 atanh z, z = y/(2 + y).
HWY_INLINE F LogOf(F x) {
  const Floats d;
  const Integers i;
  const auto bits = hn::BitCast(i, x);
  const auto from_root = hn::Sub(bits, hn::Set(i, 0x3f3504f3));  // sqrt(1/2)
  const auto k = hn::ShiftRight<23>(from_root);
  const F m = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<23>(k)));
  const F one = hn::Set(d, 1.0f);
  const F z = hn::Div(hn::Sub(m, one), hn::Add(m, one)), zz = hn::Mul(z, z);
  F p = hn::Set(d, 2.0f / 9);
  p = hn::MulAdd(p, zz, hn::Set(d, 2.0f / 7));
  p = hn::MulAdd(p, zz, hn::Set(d, 2.0f / 5));
  p = hn::MulAdd(p, zz, hn::Set(d, 2.0f / 3));
  p = hn::MulAdd(p, zz, hn::Set(d, 2.0f));
  return hn::MulAdd(hn::ConvertTo(d, k), hn::Set(d, 0.693147181f), hn::Mul(p, z));
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::adaptive
HWY_AFTER_NAMESPACE();

#endif
