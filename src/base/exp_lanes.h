// exp of a vector of doubles, for kernels that foreach_target compiles once for every instruction set: no #pragma once,
// it is read once a target.
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
namespace tress {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Doubles = hn::CappedTag<double, 8>;
using Words = hn::Repartition<std::uint64_t, Doubles>;
using V = hn::Vec<Doubles>;

// exp(x), x <= 0, relative error 1e-11; stays at exp(-700) below. The sum with 1.5 2^52 rounds to an integer and leaves
// it in the low bits, from where it is shifted into the exponent.
HWY_INLINE V Exp(V x) {
  const Doubles d;
  const Words w;
  x = hn::Max(x, hn::Set(d, -700.0));
  const V magic = hn::Set(d, 6755399441055744.0);
  const V shifted = hn::MulAdd(x, hn::Set(d, std::numbers::log2e), magic);
  const V k = hn::Sub(shifted, magic);
  V r = hn::NegMulAdd(k, hn::Set(d, 0.693147180369123816490), x);  // ln 2, the bits that k leaves exact
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
}  // namespace tress
HWY_AFTER_NAMESPACE();

#endif
