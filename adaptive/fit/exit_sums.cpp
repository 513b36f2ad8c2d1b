#include "fit/exit_sums.h"

#include <algorithm>
#include <array>
#include <cstddef>

// foreach_target compiles this once for every instruction set; the first call chooses the machine's.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/exit_sums.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/pi.h"
#include "density/law_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::adaptive {
namespace HWY_NAMESPACE {

// The half of a vector that holds the exits from half * 8 on. Exits are evaluated up to sixteen at a time, and added up
// eight at a time.
#if HWY_MAX_BYTES >= 64
constexpr std::size_t halves = 2;
template <std::size_t half>
HWY_INLINE F Half(W x) {
  return half == 0 ? hn::LowerHalf(Floats(), x) : hn::UpperHalf(Floats(), x);
}
#else
constexpr std::size_t halves = 1;
template <std::size_t half>
HWY_INLINE F Half(W x) {
  return x;
}
#endif

HWY_INLINE W Line(const Lanes& from, const Lanes& to, std::size_t lane, W s) {
  const Wide d;
  return hn::MulAdd(s, hn::Set(d, to[lane] - from[lane]), hn::Set(d, from[lane]));
}

// Returns the position along a segment, 0 to 1. An exit beyond its ends belongs to the next piece and has no weight
// here.
template <class D>
HWY_INLINE hn::Vec<D> Along(D d, hn::Vec<D> x, float x0, float inverse_width) {
  const auto s = hn::Mul(hn::Sub(x, hn::Set(d, x0)), hn::Set(d, inverse_width));
  return hn::Min(hn::Max(s, hn::Zero(d)), hn::Set(d, 1.0f));
}

// The values of a layer at an exit.
struct AtExit {
  W s, density, law;
  W slope;            // derivative of -ln law by the distance from the mode in scales
  W distance;         // from the mode, in scales of its side
  W inverse_side;     // 1/s of that side
  W inverse_both;     // 1/(s_below + s_above)
  W inverse_product;  // 1/(s_below s_above)
  WideMask below;
};

template <HeightLaw law>
HWY_INLINE AtExit LayerAt(const KnotLanes& from, const KnotLanes& to, std::size_t lane, float x0, float inverse_width,
                          W x, W t) {
  const Wide d;
  AtExit at;
  const W one = hn::Set(d, 1.0f);
  at.s = Along(d, x, x0, inverse_width);
  at.density = Line(from.density, to.density, lane, at.s);
  const W scale_below = Line(from.scale_below, to.scale_below, lane, at.s);
  const W scale_above = Line(from.scale_above, to.scale_above, lane, at.s);
  const W both = hn::Add(scale_below, scale_above), product = hn::Mul(scale_below, scale_above);
  const W inverse = hn::Div(one, hn::Mul(both, product));
  at.inverse_both = hn::Mul(inverse, product);
  at.inverse_product = hn::Mul(inverse, both);
  const W away = hn::Sub(t, Line(from.mode, to.mode, lane, at.s));
  at.below = hn::Lt(away, hn::Zero(d));
  at.inverse_side = hn::Mul(at.inverse_product, hn::IfThenElse(at.below, scale_above, scale_below));
  at.distance = hn::Mul(hn::Abs(away), at.inverse_side);
  if (law == HeightLaw::normal) {
    const W e = WideExpOf(hn::Mul(hn::Set(d, -0.5f), hn::Mul(at.distance, at.distance)));
    at.law = hn::Mul(hn::Mul(hn::Set(d, 0.797884561f), at.inverse_both), e);
    at.slope = at.distance;
  } else {
    const W e = WideExpOf(hn::Neg(at.distance)), inverse_one_e = hn::Div(one, hn::Add(one, e));
    const W two_e = hn::Mul(hn::Add(e, e), hn::Mul(inverse_one_e, inverse_one_e));
    at.law = hn::Mul(two_e, at.inverse_both);
    at.slope = hn::Mul(hn::Sub(one, e), inverse_one_e);
  }
  return at;
}

// Adds the sums over all lanes of four vectors to out[0 .. 3].
HWY_INLINE void AddFour(F a, F b, F c, F e, float* out) {
#if HWY_TARGET == HWY_SCALAR
  out[0] += hn::GetLane(a), out[1] += hn::GetLane(b), out[2] += hn::GetLane(c), out[3] += hn::GetLane(e);
#else
  const Floats d;
  const F ac = hn::Add(hn::InterleaveLower(d, a, c), hn::InterleaveUpper(d, a, c));
  const F be = hn::Add(hn::InterleaveLower(d, b, e), hn::InterleaveUpper(d, b, e));
  const F all = hn::Add(hn::InterleaveLower(d, ac, be), hn::InterleaveUpper(d, ac, be));  // in blocks of four lanes
  const Fours four;
#if HWY_MAX_BYTES >= 32
  const auto sum = hn::Add(hn::LowerHalf(four, all), hn::UpperHalf(four, all));
#else
  const auto sum = all;
#endif
  hn::StoreU(hn::Add(hn::LoadU(four, out), sum), four, out);
#endif
}

// What the exits add to the sums of a layer.
struct LayerTerms {
  W s, light, mode, below, above, information, information_s;

  // over_f: the weight divided by f.
  HWY_INLINE LayerTerms(const AtExit& at, W over_f) : s(at.s), light(hn::Mul(over_f, at.law)) {
    const W share = hn::Mul(light, at.density);
    const W push = hn::Mul(hn::Mul(share, at.slope), at.inverse_side);
    mode = hn::IfThenElse(at.below, hn::Neg(push), push);
    const W widening = hn::Mul(push, at.distance), shrinking = hn::Mul(share, at.inverse_both);
    below = hn::Sub(hn::IfThenElseZero(at.below, widening), shrinking);
    above = hn::Sub(hn::IfThenZeroElse(at.below, widening), shrinking);
    information = hn::Mul(share, at.inverse_product);
    information_s = hn::Mul(information, at.s);
  }
};

// The running sums of a layer.
struct Running {
  F light, light_s, mode, mode_s, below, below_s, above, above_s, information, information_s, information_ss;

  HWY_INLINE void Clear() {
    const Floats d;
    light = light_s = mode = mode_s = below = below_s = above = above_s = hn::Zero(d);
    information = information_s = information_ss = hn::Zero(d);
  }
  HWY_INLINE void Add(const LayerTerms& terms, std::size_t exits) {
    AddHalf<0>(terms);
    if (halves == 2 && exits > hn::Lanes(Floats())) AddHalf<halves - 1>(terms);
  }
  template <std::size_t half>
  HWY_INLINE void AddHalf(const LayerTerms& terms) {
    const F by_law = Half<half>(terms.light), s = Half<half>(terms.s), push = Half<half>(terms.mode);
    const F by_below = Half<half>(terms.below), by_above = Half<half>(terms.above);
    const F known = Half<half>(terms.information), known_s = Half<half>(terms.information_s);
    light = hn::Add(light, by_law);
    light_s = hn::MulAdd(by_law, s, light_s);
    mode = hn::Add(mode, push);
    mode_s = hn::MulAdd(push, s, mode_s);
    below = hn::Add(below, by_below);
    below_s = hn::MulAdd(by_below, s, below_s);
    above = hn::Add(above, by_above);
    above_s = hn::MulAdd(by_above, s, above_s);
    information = hn::Add(information, known);
    information_s = hn::Add(information_s, known_s);
    information_ss = hn::MulAdd(known_s, s, information_ss);
  }
  HWY_INLINE void To(SegmentSums& sums) const {
    const Floats d;
    float* out = &sums.light;
    AddFour(light, light_s, mode, mode_s, out);
    AddFour(below, below_s, above, above_s, out + 4);
    AddFour(information, information_s, information_ss, hn::Zero(d), out + 8);
  }
};

HWY_INLINE W DensityOf(const AtExit& main, const AtExit& broad) {
  const Wide d;
  const W f = hn::MulAdd(main.density, main.law, hn::Mul(broad.density, broad.law));
  return hn::Max(f, hn::Set(d, 1e-30f));
}

// Evaluates both layers at exits i .. of a piece.
template <HeightLaw law>
struct Both {
  AtExit main, broad;
  W w, f;
  HWY_INLINE Both(const RowExits& exits, const RibbonLanes& lanes, std::size_t lane, const RibbonPiece& piece,
                  std::size_t i) {
    const Wide d;
    const W x = hn::LoadU(d, exits.x.data() + i), t = hn::LoadU(d, exits.t.data() + i);
    w = hn::IfThenElseZero(hn::FirstN(d, piece.end - i), hn::LoadU(d, exits.w.data() + i));
    main = LayerAt<law>(lanes.main.knots[piece.main], lanes.main.knots[MainLanes::after(piece.main)], lane,
                        piece.main_x0, piece.main_inverse_width, x, t);
    broad =
        LayerAt<HeightLaw::logistic>(lanes.broad.knots[piece.broad], lanes.broad.knots[BroadLanes::after(piece.broad)],
                                     lane, piece.broad_x0, piece.broad_inverse_width, x, t);
    f = DensityOf(main, broad);
  }
};

template <class Do>
HWY_INLINE void ForPieces(const RibbonLanes& lanes, std::size_t part, Do&& what) {
  for (std::size_t i = 0; i < lanes.piece_count[part]; ++i) what(lanes.pieces[part][i]);
}

template <HeightLaw law>
void AddExitsBy(const RowExits& exits, const RibbonLanes& lanes, std::size_t lane, RowSums& sums) {
  ForPieces(lanes, part_of_lane(lane), [&](const RibbonPiece& piece) HWY_ATTR {
    Running of_main, of_broad;
    of_main.Clear();
    of_broad.Clear();
    for (std::size_t i = piece.begin; i < piece.end; i += hn::Lanes(Wide())) {
      const Both<law> at(exits, lanes, lane, piece, i);
      const W over_f = hn::Div(at.w, at.f);
      of_main.Add(LayerTerms(at.main, over_f), piece.end - i);
      of_broad.Add(LayerTerms(at.broad, over_f), piece.end - i);
    }
    of_main.To(sums.main[lane][piece.main]);
    of_broad.To(sums.broad[lane][piece.broad]);
  });
}

void AddExits(const RowExits& exits, const RibbonLanes& lanes, RowSums& sums) {
  for (std::size_t lane = 0; lane < fit_lanes; ++lane) {
    if (!lanes.active[lane]) continue;
    if (lanes.law[lane] == HeightLaw::normal) {
      AddExitsBy<HeightLaw::normal>(exits, lanes, lane, sums);
    } else {
      AddExitsBy<HeightLaw::logistic>(exits, lanes, lane, sums);
    }
  }
}

void AddHeights(const RowExits& exits, const RibbonLanes& lanes, std::size_t part, PartHeights& sums) {
  const Floats d;
  ForPieces(lanes, part, [&](const RibbonPiece& piece) HWY_ATTR {
    F w = hn::Zero(d), wt = w, wtt = w, main = w, main_t = w, main_tt = w, broad = w, broad_t = w, broad_tt = w;
    for (std::size_t i = piece.begin; i < piece.end; i += hn::Lanes(d)) {
      const F x = hn::LoadU(d, exits.x.data() + i), t = hn::LoadU(d, exits.t.data() + i);
      const F weight = hn::IfThenElseZero(hn::FirstN(d, piece.end - i), hn::LoadU(d, exits.w.data() + i));
      const F weight_t = hn::Mul(weight, t), weight_tt = hn::Mul(weight_t, t);
      w = hn::Add(w, weight);
      wt = hn::Add(wt, weight_t);
      wtt = hn::Add(wtt, weight_tt);
      const F s = Along(d, x, piece.main_x0, piece.main_inverse_width);
      main = hn::MulAdd(weight, s, main);
      main_t = hn::MulAdd(weight_t, s, main_t);
      main_tt = hn::MulAdd(weight_tt, s, main_tt);
      const F q = Along(d, x, piece.broad_x0, piece.broad_inverse_width);
      broad = hn::MulAdd(weight, q, broad);
      broad_t = hn::MulAdd(weight_t, q, broad_t);
      broad_tt = hn::MulAdd(weight_tt, q, broad_tt);
    }
    const F zero = hn::Zero(d);
    float *to_main = &sums.main[piece.main].light, *to_broad = &sums.broad[piece.broad].light;
    AddFour(w, main, wt, main_t, to_main);
    AddFour(wtt, main_tt, zero, zero, to_main + 4);
    AddFour(w, broad, wt, broad_t, to_broad);
    AddFour(wtt, broad_tt, zero, zero, to_broad + 4);
  });
}

template <HeightLaw law>
void AddDecaysBy(const RowExits& exits, const RibbonLanes& lanes, std::size_t lane, LaneDecays& sums) {
  const Floats d;
  ForPieces(lanes, part_of_lane(lane), [&](const RibbonPiece& piece) HWY_ATTR {
    const F zero = hn::Zero(d);
    F main[6] = {zero, zero, zero, zero, zero, zero}, broad[6] = {zero, zero, zero, zero, zero, zero};
    for (std::size_t i = piece.begin; i < piece.end; i += hn::Lanes(Wide())) {
      const Both<law> at(exits, lanes, lane, piece, i);
      const W over_f = hn::Div(at.w, at.f);
      const auto add = [&](F(&to)[6], const AtExit& layer) HWY_ATTR {
        const W all = hn::Mul(over_f, hn::Mul(layer.density, layer.law)), all_s = hn::Mul(all, layer.s);
        const auto add_half = [&](F w, F ws, std::size_t from) HWY_ATTR {
          const F first = hn::LoadU(d, exits.decay[0].data() + from),
                  second = hn::LoadU(d, exits.decay[1].data() + from);
          to[0] = hn::Add(to[0], w);
          to[1] = hn::Add(to[1], ws);
          to[2] = hn::MulAdd(w, first, to[2]);
          to[3] = hn::MulAdd(ws, first, to[3]);
          to[4] = hn::MulAdd(w, second, to[4]);
          to[5] = hn::MulAdd(ws, second, to[5]);
        };
        add_half(Half<0>(all), Half<0>(all_s), i);
        if (halves == 2 && piece.end - i > hn::Lanes(d))
          add_half(Half<halves - 1>(all), Half<halves - 1>(all_s), i + hn::Lanes(d));
      };
      add(main, at.main);
      add(broad, at.broad);
    }
    float *to_main = &sums.main[piece.main].clear, *to_broad = &sums.broad[piece.broad].clear;
    AddFour(main[0], main[1], main[2], main[3], to_main);
    AddFour(main[4], main[5], zero, zero, to_main + 4);
    AddFour(broad[0], broad[1], broad[2], broad[3], to_broad);
    AddFour(broad[4], broad[5], zero, zero, to_broad + 4);
  });
}

void AddDecays(const RowExits& exits, const RibbonLanes& lanes, std::size_t lane, LaneDecays& sums) {
  if (lanes.law[lane] == HeightLaw::normal) {
    AddDecaysBy<HeightLaw::normal>(exits, lanes, lane, sums);
  } else {
    AddDecaysBy<HeightLaw::logistic>(exits, lanes, lane, sums);
  }
}

template <HeightLaw law>
double LogLikelihoodBy(const RowExits& exits, const RibbonLanes& lanes, std::size_t lane) {
  const Floats d;
  double sum = 0;
  ForPieces(lanes, part_of_lane(lane), [&](const RibbonPiece& piece) HWY_ATTR {
    F of_piece = hn::Zero(d);
    for (std::size_t i = piece.begin; i < piece.end; i += hn::Lanes(Wide())) {
      const Both<law> at(exits, lanes, lane, piece, i);
      const W log_f = tress::HWY_NAMESPACE::LogOf(Wide(), at.f);
      of_piece = hn::MulAdd(Half<0>(at.w), Half<0>(log_f), of_piece);
      if (halves == 2 && piece.end - i > hn::Lanes(d))
        of_piece = hn::MulAdd(Half<halves - 1>(at.w), Half<halves - 1>(log_f), of_piece);
    }
    sum += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, of_piece)));
  });
  return sum;
}

double LogLikelihood(const RowExits& exits, const RibbonLanes& lanes, std::size_t lane) {
  return lanes.law[lane] == HeightLaw::normal ? LogLikelihoodBy<HeightLaw::normal>(exits, lanes, lane)
                                              : LogLikelihoodBy<HeightLaw::logistic>(exits, lanes, lane);
}

void AddDirections(const RowExits& exits, std::size_t begin, std::size_t end, float* out) {
  const Wide d;
  F sums[RowExits::harmonics];
  for (F& sum : sums) sum = hn::Zero(Floats());
  for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
    const W w = hn::IfThenElseZero(hn::FirstN(d, end - i), hn::LoadU(d, exits.w.data() + i));
    const W turns = hn::MulAdd(hn::LoadU(d, exits.x.data() + i), hn::Set(d, 0.5f / pi_f), hn::Set(d, 0.5f));
    W sine, cosine;
    tress::HWY_NAMESPACE::lanes16::SineAndCosineOfTurns(turns, sine, cosine);  // of x + pi
    cosine = hn::Neg(cosine), sine = hn::Neg(sine);
    W real = hn::Mul(w, cosine), imaginary = hn::Mul(w, sine);
    for (std::size_t j = 0; j < RowExits::harmonics; j += 2) {
      sums[j] = hn::Add(sums[j], Half<0>(real));
      sums[j + 1] = hn::Add(sums[j + 1], Half<0>(imaginary));
      if (halves == 2) {
        sums[j] = hn::Add(sums[j], Half<halves - 1>(real));
        sums[j + 1] = hn::Add(sums[j + 1], Half<halves - 1>(imaginary));
      }
      const W next = hn::MulSub(real, cosine, hn::Mul(imaginary, sine));
      imaginary = hn::MulAdd(imaginary, cosine, hn::Mul(real, sine));
      real = next;
    }
  }
  for (std::size_t j = 0; j < RowExits::harmonics; j += 4)
    AddFour(sums[j], sums[j + 1], sums[j + 2], sums[j + 3], out + j);
}

void WriteDecays(const float* attributes, std::size_t n, float* first, float* second) {
  const Floats d;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const F attribute = hn::LoadU(d, attributes + i);
    hn::StoreU(ExpOf(hn::Mul(hn::Set(d, -Ribbon::decay_rates[0]), attribute)), d, first + i);
    hn::StoreU(ExpOf(hn::Mul(hn::Set(d, -Ribbon::decay_rates[1]), attribute)), d, second + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::adaptive
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::adaptive {

HWY_EXPORT(AddExits);
HWY_EXPORT(AddHeights);
HWY_EXPORT(AddDecays);
HWY_EXPORT(AddDirections);
HWY_EXPORT(LogLikelihood);
HWY_EXPORT(WriteDecays);

void add_exits(const RowExits& exits, const RibbonLanes& lanes, RowSums& sums) {
  HWY_DYNAMIC_DISPATCH(AddExits)(exits, lanes, sums);
}
void add_heights(const RowExits& exits, const RibbonLanes& lanes, std::size_t part, PartHeights& sums) {
  HWY_DYNAMIC_DISPATCH(AddHeights)(exits, lanes, part, sums);
}
void add_decays(const RowExits& exits, const RibbonLanes& lanes, std::size_t lane, LaneDecays& sums) {
  HWY_DYNAMIC_DISPATCH(AddDecays)(exits, lanes, lane, sums);
}
std::array<double, RowExits::harmonics> sum_of_directions(const RowExits& exits, std::size_t begin, std::size_t end) {
  std::array<float, RowExits::harmonics> sums{};
  HWY_DYNAMIC_DISPATCH(AddDirections)(exits, begin, end, sums.data());
  std::array<double, RowExits::harmonics> all;
  std::ranges::copy(sums, all.begin());
  return all;
}
double log_likelihood(const RowExits& exits, const RibbonLanes& lanes, std::size_t lane) {
  return HWY_DYNAMIC_DISPATCH(LogLikelihood)(exits, lanes, lane);
}
void write_decays(const float* attributes, std::size_t n, float* first, float* second) {
  HWY_DYNAMIC_DISPATCH(WriteDecays)(attributes, n, first, second);
}

}  // namespace tress::inline v0_2::adaptive
#endif
