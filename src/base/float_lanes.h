// Elementary functions of floats in lanes, for kernels that foreach_target compiles once for every instruction set.
// There is no #pragma once, because it is read once for every target.
#if defined(TRESS_BASE_FLOAT_LANES_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TRESS_BASE_FLOAT_LANES_H
#undef TRESS_BASE_FLOAT_LANES_H
#else
#define TRESS_BASE_FLOAT_LANES_H
#endif

#include <hwy/highway.h>

#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2 {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// exp(x) for x <= 87, relative error 2e-7; below -87 it returns exp(-87). Adding 1.5 2^23 rounds to an integer in the
// low bits, which are then shifted into the exponent.
template <class D>
HWY_INLINE hn::Vec<D> ExpOf(D d, hn::Vec<D> x) {
  const hn::Repartition<std::uint32_t, D> words;
  const auto number = [d](float value) HWY_ATTR { return hn::Set(d, value); };
  x = hn::Max(x, number(-87.0f));
  const auto magic = number(12582912.0f), shifted = hn::MulAdd(x, number(1.44269504f), magic);
  const auto k = hn::Sub(shifted, magic);
  auto r = hn::NegMulAdd(k, number(0.693359375f), x);
  r = hn::NegMulAdd(k, number(-2.12194440e-4f), r);
  auto p = hn::MulAdd(number(1.0f / 720), r, number(1.0f / 120));
  for (const float c : {1.0f / 24, 1.0f / 6, 0.5f, 1.0f, 1.0f}) p = hn::MulAdd(p, r, number(c));
  return hn::BitCast(d, hn::Add(hn::BitCast(words, p), hn::ShiftLeft<23>(hn::BitCast(words, shifted))));
}

// ln x for a normal x > 0, by the method of natural_log() in base/logarithm.h: relative error 2e-7, also near x = 1.
template <class D>
HWY_INLINE hn::Vec<D> LogOf(D d, hn::Vec<D> x) {
  const hn::RebindToSigned<D> i;
  const auto number = [d](float value) HWY_ATTR { return hn::Set(d, value); };
  const auto bits = hn::Sub(hn::BitCast(i, x), hn::Set(i, 0x3f3504f3));
  const auto k = hn::ConvertTo(d, hn::ShiftRight<23>(bits));
  const auto mantissa = hn::Add(hn::And(bits, hn::Set(i, 0x7fffff)), hn::Set(i, 0x3f3504f3));
  const auto r = hn::Sub(hn::BitCast(d, mantissa), number(1)), z = hn::Mul(r, r);
  auto p = hn::MulAdd(number(7.0376836292e-2f), r, number(-1.1514610310e-1f));
  for (const float c : {1.1676998740e-1f, -1.2420140846e-1f, 1.4249322787e-1f, -1.6668057665e-1f, 2.0000714765e-1f,
                        -2.4999993993e-1f, 3.3333331174e-1f})
    p = hn::MulAdd(p, r, number(c));
  const auto tail = hn::MulAdd(k, number(-2.12194440e-4f), hn::Mul(hn::Mul(r, z), p));
  return hn::MulAdd(k, number(0.693359375f), hn::Add(hn::NegMulAdd(number(0.5f), z, tail), r));
}

namespace lanes16 {

// Sixteen floats are one vector, or two, or four: code that works in blocks of 16 does the same on every machine.
using Floats = hn::CappedTag<float, 16>;
using Words = hn::Repartition<std::uint32_t, Floats>;
using F = hn::Vec<Floats>;
using W = hn::Vec<Words>;
using Mask = hn::Mask<Floats>;

HWY_INLINE F Splat(float x) { return hn::Set(Floats(), x); }
HWY_INLINE W SplatWord(std::uint32_t x) { return hn::Set(Words(), x); }
HWY_INLINE W WordsOf(F x) { return hn::BitCast(Words(), x); }
HWY_INLINE F FloatsOf(W x) { return hn::BitCast(Floats(), x); }

HWY_INLINE F Exp(F x) { return ExpOf(Floats(), x); }
HWY_INLINE F Log(F x) { return LogOf(Floats(), x); }

// Sine and cosine of a fraction of a turn in [0, 1], error 1e-7 (Cephes).
HWY_INLINE void SineAndCosineOfTurns(F turns, F& sine, F& cosine) {
  const F magic = Splat(12582912.0f), shifted = hn::MulAdd(turns, Splat(4), magic);
  const F r = hn::Mul(hn::MulSub(turns, Splat(4), hn::Sub(shifted, magic)), Splat(1.57079633f)), z = hn::Mul(r, r);
  F s = hn::MulAdd(Splat(-1.9515295891e-4f), z, Splat(8.3321608736e-3f));
  s = hn::MulAdd(hn::Mul(hn::MulAdd(s, z, Splat(-1.6666654611e-1f)), z), r, r);
  F c = hn::MulAdd(Splat(2.443315711809948e-5f), z, Splat(-1.388731625493765e-3f));
  c = hn::MulAdd(c, z, Splat(4.166664568298827e-2f));
  c = hn::MulAdd(hn::Mul(c, z), z, hn::NegMulAdd(Splat(0.5f), z, Splat(1)));
  const W quarter = WordsOf(shifted), one = SplatWord(1);
  const Mask odd = hn::RebindMask(Floats(), hn::TestBit(quarter, one));
  const W sine_sign = hn::ShiftLeft<30>(hn::And(quarter, SplatWord(2)));
  const W cosine_sign = hn::ShiftLeft<30>(hn::And(hn::Add(quarter, one), SplatWord(2)));
  sine = hn::Xor(hn::IfThenElse(odd, c, s), FloatsOf(sine_sign));
  cosine = hn::Xor(hn::IfThenElse(odd, s, c), FloatsOf(cosine_sign));
}

// The angle of (x, y) in [-pi, pi], error 3e-7, by the method of angle_of() in base/arctangent.h; 0 or pi where both
// are 0.
HWY_INLINE F AngleOf(F y, F x) {
  const F ax = hn::Abs(x), ay = hn::Abs(y), longer = hn::Max(ax, ay), shorter = hn::Min(ax, ay);
  const Mask turned = hn::Gt(shorter, hn::Mul(Splat(0.414213562f), longer));
  const F above = hn::IfThenElse(turned, hn::Sub(shorter, longer), shorter);
  const F below = hn::IfThenElse(turned, hn::Add(shorter, longer), longer);
  const F t = hn::Div(above, hn::Max(below, Splat(1e-37f))), z = hn::Mul(t, t);
  F p = hn::MulAdd(Splat(8.05374449538e-2f), z, Splat(-1.38776856032e-1f));
  p = hn::MulAdd(p, z, Splat(1.99777106478e-1f));
  p = hn::MulAdd(p, z, Splat(-3.33329491539e-1f));
  F angle = hn::Add(hn::IfThenElseZero(turned, Splat(0.785398163f)), hn::MulAdd(hn::Mul(t, z), p, t));
  angle = hn::IfThenElse(hn::Gt(ay, ax), hn::Sub(Splat(1.57079633f), angle), angle);
  angle = hn::IfThenElse(hn::Lt(x, hn::Zero(Floats())), hn::Sub(Splat(3.14159265f), angle), angle);
  return hn::CopySign(angle, y);
}

}  // namespace lanes16
}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2
HWY_AFTER_NAMESPACE();

#endif
