// exp of a vector of doubles, for kernels that foreach_target compiles once for every instruction set. There is no
// #pragma once, because it is read once for every target.
#if defined(TRESS_BASE_EXP_LANES_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TRESS_BASE_EXP_LANES_H
#undef TRESS_BASE_EXP_LANES_H
#else
#define TRESS_BASE_EXP_LANES_H
#endif

#include <hwy/highway.h>

#include <cstdint>
#include <numbers>

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2 {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Doubles = hn::CappedTag<double, 8>;
using Words = hn::Repartition<std::uint64_t, Doubles>;
using V = hn::Vec<Doubles>;

// exp(x) for x <= 0, relative error 1e-11; below -700 it returns exp(-700). Adding 1.5 2^52 rounds to an integer in the
// low bits, which are then shifted into the exponent.
HWY_INLINE V Exp(V x) {
  const Doubles d;
  const Words w;
  x = hn::Max(x, hn::Set(d, -700.0));
  const V magic = hn::Set(d, 6755399441055744.0);
  const V shifted = hn::MulAdd(x, hn::Set(d, std::numbers::log2e), magic);
  const V k = hn::Sub(shifted, magic);
  V r = hn::NegMulAdd(k, hn::Set(d, 0.693147180369123816490), x);  // ln 2 without low bits: k times it is exact
  r = hn::NegMulAdd(k, hn::Set(d, 1.90821492927058770002e-10), r);
  V p = hn::Set(d, 1. / 362880);
  p = hn::MulAdd(p, r, hn::Set(d, 1. / 40320));
  p = hn::MulAdd(p, r, hn::Set(d, 1. / 5040));
  p = hn::MulAdd(p, r, hn::Set(d, 1. / 720));
  p = hn::MulAdd(p, r, hn::Set(d, 1. / 120));
  p = hn::MulAdd(p, r, hn::Set(d, 1. / 24));
  p = hn::MulAdd(p, r, hn::Set(d, 1. / 6));
  p = hn::MulAdd(p, r, hn::Set(d, 0.5));
  p = hn::MulAdd(p, r, hn::Set(d, 1.0));
  p = hn::MulAdd(p, r, hn::Set(d, 1.0));
  const auto exponent = hn::ShiftLeft<52>(hn::BitCast(w, shifted));
  return hn::BitCast(d, hn::Add(hn::BitCast(w, p), exponent));
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2
HWY_AFTER_NAMESPACE();

#endif
