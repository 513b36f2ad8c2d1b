#include "fit/ribbon_kernels.h"

#include <cstdint>

// Compiled once for every instruction set by foreach_target; the machine chooses on the first call.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/ribbon_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tress::adaptive {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, ribbon_lanes>;
using F = hn::Vec<Floats>;
using Mask = hn::Mask<Floats>;

// exp(x), x <= 0, relative error 2e-7; stays at exp(-87) below. As Exp of base/exp_lanes.h, in floats.
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

HWY_INLINE F Line(const float (&ends)[2], F s) {
  const Floats d;
  return hn::MulAdd(s, hn::Set(d, ends[1] - ends[0]), hn::Set(d, ends[0]));
}

// A layer at an exit.
struct AtExit {
  F s, density, law;
  F slope;            // of -ln law by the distance from the mode in scales
  F distance;         // in scales of its side
  F inverse_side;     // 1/s of that side
  F inverse_both;     // 1/(s_below + s_above)
  F inverse_product;  // 1/(s_below s_above)
  Mask below;
};

template <HeightLaw law>
HWY_INLINE AtExit LayerAt(const RibbonSegment& segment, F x, F t) {
  const Floats d;
  AtExit at;
  const F one = hn::Set(d, 1.0f);
  at.s = hn::Mul(hn::Sub(x, hn::Set(d, segment.x0)), hn::Set(d, segment.inverse_width));
  at.density = Line(segment.density, at.s);
  const F scale_below = Line(segment.scale_below, at.s), scale_above = Line(segment.scale_above, at.s);
  const F both = hn::Add(scale_below, scale_above), product = hn::Mul(scale_below, scale_above);
  const F inverse = hn::Div(one, hn::Mul(both, product));
  at.inverse_both = hn::Mul(inverse, product);
  at.inverse_product = hn::Mul(inverse, both);
  const F away = hn::Sub(t, Line(segment.mode, at.s));
  at.below = hn::Lt(away, hn::Zero(d));
  at.inverse_side = hn::Mul(at.inverse_product, hn::IfThenElse(at.below, scale_above, scale_below));
  at.distance = hn::Mul(hn::Abs(away), at.inverse_side);
  if (law == HeightLaw::normal) {
    const F e = ExpOf(hn::Mul(hn::Set(d, -0.5f), hn::Mul(at.distance, at.distance)));
    at.law = hn::Mul(hn::Mul(hn::Set(d, 0.797884561f), at.inverse_both), e);
    at.slope = at.distance;
  } else {
    const F e = ExpOf(hn::Neg(at.distance)), inverse_one_e = hn::Div(one, hn::Add(one, e));
    const F two_e = hn::Mul(hn::Add(e, e), hn::Mul(inverse_one_e, inverse_one_e));
    at.law = hn::Mul(two_e, at.inverse_both);
    at.slope = hn::Mul(hn::Sub(one, e), inverse_one_e);
  }
  return at;
}

// The sums of a layer while they run, over all exits and weighted by s.
struct Running {
  F light, light_s, mode, mode_s, below, below_s, above, above_s, information, information_s, information_ss;

  HWY_INLINE void Clear() {
    const Floats d;
    light = light_s = mode = mode_s = below = below_s = above = above_s = hn::Zero(d);
    information = information_s = information_ss = hn::Zero(d);
  }
  // over_f: the weight over f.
  HWY_INLINE void Add(const AtExit& at, F over_f) {
    const F by_law = hn::Mul(over_f, at.law), share = hn::Mul(by_law, at.density);
    light = hn::Add(light, by_law);
    light_s = hn::MulAdd(by_law, at.s, light_s);
    const F push = hn::Mul(hn::Mul(share, at.slope), at.inverse_side);
    const F signed_push = hn::IfThenElse(at.below, hn::Neg(push), push);
    mode = hn::Add(mode, signed_push);
    mode_s = hn::MulAdd(signed_push, at.s, mode_s);
    const F widening = hn::Mul(push, at.distance), shrinking = hn::Mul(share, at.inverse_both);
    const F by_below = hn::Sub(hn::IfThenElseZero(at.below, widening), shrinking);
    const F by_above = hn::Sub(hn::IfThenZeroElse(at.below, widening), shrinking);
    below = hn::Add(below, by_below);
    below_s = hn::MulAdd(by_below, at.s, below_s);
    above = hn::Add(above, by_above);
    above_s = hn::MulAdd(by_above, at.s, above_s);
    const F known = hn::Mul(share, at.inverse_product), known_s = hn::Mul(known, at.s);
    information = hn::Add(information, known);
    information_s = hn::Add(information_s, known_s);
    information_ss = hn::MulAdd(known_s, at.s, information_ss);
  }
  static HWY_INLINE void Split(F all, F by_s, double (&out)[2]) {
    const Floats d;
    const double right = static_cast<double>(hn::GetLane(hn::SumOfLanes(d, by_s)));
    out[0] += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, all))) - right;
    out[1] += right;
  }
  HWY_INLINE void To(SegmentSums& sums) const {
    const Floats d;
    Split(light, light_s, sums.light);
    Split(mode, mode_s, sums.mode);
    Split(below, below_s, sums.scale_below);
    Split(above, above_s, sums.scale_above);
    const double all = static_cast<double>(hn::GetLane(hn::SumOfLanes(d, information)));
    const double by_s = static_cast<double>(hn::GetLane(hn::SumOfLanes(d, information_s)));
    const double by_ss = static_cast<double>(hn::GetLane(hn::SumOfLanes(d, information_ss)));
    sums.information[0] += all - 2 * by_s + by_ss;
    sums.information[1] += by_s - by_ss;
    sums.information[2] += by_ss;
  }
};

HWY_INLINE F DensityOf(const AtExit& main, const AtExit& broad) {
  const Floats d;
  const F f = hn::MulAdd(main.density, main.law, hn::Mul(broad.density, broad.law));
  return hn::Max(f, hn::Set(d, 1e-30f));
}

template <HeightLaw law>
void AddExitsBy(const RibbonSegment& main, const RibbonSegment& broad, const RibbonExits& exits, SegmentSums& main_sums,
                SegmentSums& broad_sums) {
  const Floats d;
  Running of_main, of_broad;
  of_main.Clear();
  of_broad.Clear();
  for (std::size_t i = 0; i < exits.n; i += hn::Lanes(d)) {
    const F x = hn::LoadU(d, exits.x + i), t = hn::LoadU(d, exits.t + i);
    const F w = hn::IfThenElseZero(hn::FirstN(d, exits.n - i), hn::LoadU(d, exits.w + i));
    const AtExit in_main = LayerAt<law>(main, x, t), in_broad = LayerAt<HeightLaw::logistic>(broad, x, t);
    const F over_f = hn::Div(w, DensityOf(in_main, in_broad));
    of_main.Add(in_main, over_f);
    of_broad.Add(in_broad, over_f);
  }
  of_main.To(main_sums);
  of_broad.To(broad_sums);
}

void AddExits(const RibbonSegment& main, HeightLaw main_law, const RibbonSegment& broad, const RibbonExits& exits,
              SegmentSums& main_sums, SegmentSums& broad_sums) {
  if (main_law == HeightLaw::normal) {
    AddExitsBy<HeightLaw::normal>(main, broad, exits, main_sums, broad_sums);
  } else {
    AddExitsBy<HeightLaw::logistic>(main, broad, exits, main_sums, broad_sums);
  }
}

template <HeightLaw law>
void EvaluateExitsBy(const RibbonSegment& main, const RibbonSegment& broad, const RibbonExits& exits, float* density,
                     float* main_share) {
  const Floats d;
  for (std::size_t i = 0; i < exits.n; i += hn::Lanes(d)) {
    const F x = hn::LoadU(d, exits.x + i), t = hn::LoadU(d, exits.t + i);
    const AtExit in_main = LayerAt<law>(main, x, t), in_broad = LayerAt<HeightLaw::logistic>(broad, x, t);
    const F f = DensityOf(in_main, in_broad);
    hn::StoreU(f, d, density + i);
    hn::StoreU(hn::Div(hn::Mul(in_main.density, in_main.law), f), d, main_share + i);
  }
}

void EvaluateExits(const RibbonSegment& main, HeightLaw main_law, const RibbonSegment& broad, const RibbonExits& exits,
                   float* density, float* main_share) {
  if (main_law == HeightLaw::normal) {
    EvaluateExitsBy<HeightLaw::normal>(main, broad, exits, density, main_share);
  } else {
    EvaluateExitsBy<HeightLaw::logistic>(main, broad, exits, density, main_share);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::adaptive
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::adaptive {

HWY_EXPORT(AddExits);
HWY_EXPORT(EvaluateExits);

void add_exits(const RibbonSegment& main, HeightLaw main_law, const RibbonSegment& broad, const RibbonExits& exits,
               SegmentSums& main_sums, SegmentSums& broad_sums) {
  HWY_DYNAMIC_DISPATCH(AddExits)(main, main_law, broad, exits, main_sums, broad_sums);
}

void evaluate_exits(const RibbonSegment& main, HeightLaw main_law, const RibbonSegment& broad, const RibbonExits& exits,
                    float* density, float* main_share) {
  HWY_DYNAMIC_DISPATCH(EvaluateExits)(main, main_law, broad, exits, density, main_share);
}

}  // namespace tress::adaptive
#endif
