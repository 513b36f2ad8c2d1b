#include "convergence/exit_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

// foreach_target compiles the file once per instruction set; the first call chooses one for the machine.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "convergence/exit_cells.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/pi.h"
#include "density/law_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::adaptive {
namespace HWY_NAMESPACE {

using I = hn::Vec<Integers>;

HWY_INLINE W Number(float x) { return hn::Set(Wide(), x); }
HWY_INLINE W Clamped(W x) { return hn::Min(hn::Max(x, Number(0)), Number(1)); }

// erfc(x), x >= 0, error 2e-7 (Abramowitz and Stegun 7.1.26).
HWY_INLINE W Beyond(W x) {
  const W t = hn::Div(Number(1), hn::MulAdd(Number(0.3275911f), x, Number(1)));
  W p = Number(1.061405429f);
  p = hn::MulAdd(p, t, Number(-1.453152027f));
  p = hn::MulAdd(p, t, Number(1.421413741f));
  p = hn::MulAdd(p, t, Number(-0.284496736f));
  p = hn::MulAdd(p, t, Number(0.254829592f));
  return hn::Mul(hn::Mul(p, t), WideExpOf(hn::Neg(hn::Mul(x, x))));
}

// A layer at an exit: its mass below x, its density at x, and the part of that density below t.
struct LayerShares {
  W below_azimuth, density, below_height;
};

// read(field): that field of the segment of each exit.
template <class Read>
HWY_INLINE LayerShares SharesBy(Read field, WideMask normal, W x, W t) {
  const Wide d;
  using S = CellTables::Segment;
  const W s = Clamped(hn::Mul(hn::Sub(x, field(&S::x0)), field(&S::inverse_width)));
  const auto line = [&](const float S::* from, const float S::* more)
                        HWY_ATTR { return hn::MulAdd(s, field(more), field(from)); };
  LayerShares at;
  const W density = field(&S::density), more = field(&S::more_density);
  at.density = hn::MulAdd(s, more, density);
  const W mean = hn::MulAdd(hn::Mul(Number(0.5f), s), more, density);
  at.below_azimuth = hn::MulAdd(hn::Mul(field(&S::width), s), mean, field(&S::below));
  const W scale_below = line(&S::scale_below, &S::more_below), scale_above = line(&S::scale_above, &S::more_above);
  const W away = hn::Sub(t, line(&S::mode, &S::more_mode));
  const WideMask is_below = hn::Lt(away, hn::Zero(d));
  const W side = hn::IfThenElse(is_below, scale_below, scale_above);
  const W z = hn::Min(hn::Div(hn::Abs(away), side), Number(80));
  W beyond = z;
  if (!hn::AllTrue(d, normal)) {
    const W e = WideExpOf(hn::Neg(z));
    beyond = hn::Div(hn::Add(e, e), hn::Add(Number(1), e));
  }
  if (!hn::AllFalse(d, normal)) {
    const W by_normal = Beyond(hn::Mul(hn::Min(z, Number(12)), Number(std::numbers::sqrt2_v<float> / 2)));
    beyond = hn::IfThenElse(normal, by_normal, beyond);
  }
  const W share = hn::Mul(beyond, hn::Div(side, hn::Add(scale_below, scale_above)));
  at.below_height = hn::Mul(at.density, hn::IfThenElse(is_below, share, hn::Sub(Number(1), share)));
  return at;
}

HWY_INLINE LayerShares At(const CellTables::Segment* segments, I segment, WideMask normal, W x, W t) {
  const Wide d;
  const CellTables::Segment& first = segments[hn::GetLane(segment)];
  if (hn::AllTrue(Integers(), hn::Eq(segment, hn::Set(Integers(), hn::GetLane(segment))))) {  // many are sorted
    const auto field = [&](const float CellTables::Segment::* which) HWY_ATTR { return hn::Set(d, first.*which); };
    return SharesBy(field, normal, x, t);
  }
  const auto fields = hn::Mul(segment, hn::Set(Integers(), sizeof(CellTables::Segment) / sizeof(float)));
  const auto field = [&](const float CellTables::Segment::* which)
                         HWY_ATTR { return hn::GatherIndex(d, &(segments->*which), fields); };
  return SharesBy(field, normal, x, t);
}

HWY_INLINE I Cell(W share, std::int32_t cells) {
  const Integers i;
  const I at = hn::ConvertTo(i, hn::Mul(share, Number(static_cast<float>(cells))));
  return hn::Min(at, hn::Set(i, cells - 1));
}

// Finds the main segments of exits; those of a part follow those of the parts before it.
HWY_INLINE I MainSegments(const CellTables& tables, I part, W x) {
  const Wide d;
  const Integers i;
  const I first = hn::ShiftLeft<5>(part);  // Ribbon::main_knots are 32
  I knot = hn::Zero(i);
  for (std::int32_t step = Ribbon::main_knots / 2; step > 0; step /= 2) {
    const I further = hn::Add(knot, hn::Set(i, step));
    const WideMask is_there = hn::Ge(x, hn::GatherIndex(d, tables.azimuth.data(), hn::Add(first, further)));
    knot = hn::IfThenElse(hn::RebindMask(i, is_there), further, knot);
  }
  const WideMask before_first = hn::Lt(x, hn::GatherIndex(d, tables.azimuth.data(), first));
  knot = hn::IfThenElse(hn::RebindMask(i, before_first), hn::Set(i, Ribbon::main_knots), knot);
  return hn::Add(hn::Add(first, part), knot);
}

void FindCells(const CellTables& tables, std::int32_t us, std::int32_t vs, std::size_t n, const float* xs,
               const float* ts, const std::int32_t* parts, std::int32_t* cells) {
  const Wide d;
  const Integers i;
  std::int32_t last_part = -1, last = 0;  // of the exit before: the next ones are often in the same segment
  float from = 0, to = 0;
  for (std::size_t at = 0; at < n; at += hn::Lanes(d)) {
    const W x = hn::LoadU(d, xs + at), t = hn::LoadU(d, ts + at);
    const I part = hn::LoadU(i, parts + at);
    I segment = hn::Set(i, last);
    if (!hn::AllTrue(i, hn::Eq(part, hn::Set(i, last_part))) ||
        !hn::AllTrue(d, hn::And(hn::Ge(x, hn::Set(d, from)), hn::Lt(x, hn::Set(d, to))))) {
      segment = MainSegments(tables, part, x);
      alignas(64) std::int32_t of_exit[16];
      hn::Store(segment, i, of_exit);
      last = of_exit[hn::Lanes(d) - 1];
      last_part = parts[at + hn::Lanes(d) - 1];
      const auto [begin, end] = tables.ends(last_part, last);
      from = begin, to = end;
    }
    const WideMask normal = hn::Gt(hn::GatherIndex(d, tables.is_normal.data(), part), Number(0.5f));
    const LayerShares main = At(tables.main.data(), segment, normal, x, t);
    const W turn = hn::Mul(hn::Add(x, Number(pi_f)), Number(Ribbon::broad_knots / two_pi_f));
    const I broad_knot = hn::Min(hn::ConvertTo(i, turn), hn::Set(i, Ribbon::broad_knots - 1));
    const LayerShares broad =
        At(tables.broad.data(), hn::Add(hn::ShiftLeft<3>(part), broad_knot), hn::MaskFromVec(hn::Zero(d)), x, t);
    const W u = Clamped(hn::Add(main.below_azimuth, broad.below_azimuth));
    const W all = hn::Add(main.density, broad.density), below = hn::Add(main.below_height, broad.below_height);
    const W v = hn::IfThenElse(hn::Gt(all, hn::Zero(d)), Clamped(hn::Div(below, all)), Number(0.5f));
    const I of_part = hn::Mul(part, hn::Set(i, us * vs));
    hn::StoreU(hn::Add(of_part, hn::Add(hn::Mul(Cell(u, us), hn::Set(i, vs)), Cell(v, vs))), i, cells + at);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::adaptive
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::adaptive {

HWY_EXPORT(FindCells);

static_assert(Ribbon::main_knots == 32 && Ribbon::broad_knots == 8);

namespace {

/// Writes the segments of a layer, by the number of the knot before them. If `out` has room for one more, it also gets
/// the segment from -pi to the first knot.
void write_segments(std::span<const RibbonKnot> knots, std::span<CellTables::Segment> out) {
  const std::size_t count = knots.size();
  double below = 0, cut = 0;  // cut: mass from the first knot to -pi, on the way round the circle
  for (std::size_t k = 0; k < count; ++k) {
    const RibbonKnot &a = knots[k], &b = knots[(k + 1) % count];
    const double x0 = static_cast<double>(a.azimuth);
    const double width = std::max(static_cast<double>(b.azimuth) - x0 + (k + 1 < count ? 0 : 2 * pi), 0.0);
    out[k] = {a.azimuth,
              width > 0 ? static_cast<float>(1 / width) : 0.0f,
              static_cast<float>(below),
              static_cast<float>(width),
              a.density,
              b.density - a.density,
              a.mode,
              b.mode - a.mode,
              a.scale_below,
              b.scale_below - a.scale_below,
              a.scale_above,
              b.scale_above - a.scale_above};
    const double density = static_cast<double>(a.density), more = static_cast<double>(b.density) - density;
    if (k + 1 == count) {
      const double s = width > 0 ? std::clamp((pi - x0) / width, 0.0, 1.0) : 0;
      cut = below + width * s * (density + 0.5 * s * more);
    }
    below += width * (density + 0.5 * more);
  }
  const double from_cut = below - cut;  // mass from -pi to the first knot
  if (out.size() > count) {
    out[count] = out[count - 1];
    out[count].x0 -= static_cast<float>(2 * pi);
    out[count].below -= static_cast<float>(cut);
  }
  for (std::size_t k = 0; k < count; ++k) out[k].below += static_cast<float>(from_cut);
}

}  // namespace

std::array<float, 2> CellTables::ends(std::int32_t part, std::int32_t segment) const {
  const auto p = static_cast<std::size_t>(part), k = static_cast<std::size_t>(segment) - p * main_segments;
  const auto knots = std::span(azimuth).subspan(p * Ribbon::main_knots, Ribbon::main_knots);
  if (k == knots.size()) return {-HUGE_VALF, knots[0]};
  return {knots[k], k + 1 < knots.size() ? knots[k + 1] : HUGE_VALF};
}

void CellTables::set(std::size_t part, const Ribbon& ribbon) {
  for (std::size_t k = 0; k < Ribbon::main_knots; ++k) {
    azimuth[part * Ribbon::main_knots + k] = ribbon.main()[k].azimuth;
  }
  write_segments(ribbon.main(), std::span(main).subspan(part * main_segments, main_segments));
  write_segments(ribbon.broad(), std::span(broad).subspan(part * Ribbon::broad_knots, Ribbon::broad_knots));
  is_normal[part] = ribbon.main_law() == HeightLaw::normal ? 1.0f : 0.0f;
}

void find_cells(const CellTables& tables, std::int32_t us, std::int32_t vs, std::size_t n, const float* x,
                const float* t, const std::int32_t* part, std::int32_t* cell) {
  HWY_DYNAMIC_DISPATCH(FindCells)(tables, us, vs, n, x, t, part, cell);
}

}  // namespace tress::inline v0_2::adaptive
#endif
