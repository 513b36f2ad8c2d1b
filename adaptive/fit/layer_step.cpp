#include "fit/layer_step.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

// foreach_target compiles this once for every instruction set; the first call chooses the machine's.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/layer_step.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/pi.h"
#include "density/law_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::adaptive {
namespace HWY_NAMESPACE {

constexpr float largest_mode_step = 1, largest_scale_step = 0.7f;  // of the mode in scales, and of ln scale
constexpr float no_light = 1e-12f;  // times the layer's largest density: a positive floor, so that light can return
constexpr float least_mass = 1e-30f;

// Lanes from g on, of all problems.
struct Group {
  std::size_t g;
  HWY_INLINE F Load(const Lanes& from) const { return hn::LoadU(Floats(), from.data() + g); }
  HWY_INLINE void Store(F x, Lanes& to) const { hn::StoreU(x, Floats(), to.data() + g); }
};

HWY_INLINE F Number(float x) { return hn::Set(Floats(), x); }
HWY_INLINE F Within(F x, float least, float most) { return hn::Min(hn::Max(x, Number(least)), Number(most)); }

// The numbers of a law from which its Fisher information is made (E9).
struct LawInformation {
  float mode, cross, scale;
};
LawInformation InformationOf(HeightLaw law) {
  if (law == HeightLaw::normal) return {1, static_cast<float>(2 * std::sqrt(2 / pi)), 3};
  return {1.0f / 3, static_cast<float>((1 + 2 * std::numbers::ln2) / 3), static_cast<float>(1 + (3 + pi * pi) / 9)};
}
struct InformationLanes {
  Lanes mode, cross, scale;
};

// The information of one exit times the product of the scales; mode and scales are each in their units.
struct Fisher {
  F of[3][3];
  HWY_INLINE Fisher(F mode, F cross, F scale, F below, F above) {
    const F p = hn::Div(below, hn::Add(below, above)), q = hn::Sub(Number(1), p);
    of[0][0] = mode;
    of[0][1] = of[1][0] = hn::Neg(hn::Mul(cross, q));
    of[0][2] = of[2][0] = hn::Mul(cross, p);
    of[1][1] = hn::Mul(hn::Sub(scale, p), q);
    of[1][2] = of[2][1] = hn::Neg(hn::Mul(p, q));
    of[2][2] = hn::Mul(hn::Sub(scale, q), p);
  }
};

// Positive definite band matrices side by side, as lower halves with five entries off the diagonal: each knot has three
// numbers and is coupled to its neighbours. Solved in place by L D L^T; the diagonal then holds the inverses of D.
// Where a pivot is not positive, the entry of the solution is 0.
template <std::size_t size>
struct Bands {
  static constexpr std::size_t reach = 6;
  F rows[size][reach];  // rows[i][d] is the entry (i, i - d)
  F right[size];

  HWY_INLINE F& At(std::size_t i, std::size_t j) { return rows[i][i - j]; }
  HWY_INLINE void Clear() {
    for (std::size_t i = 0; i < size; ++i) {
      for (F& entry : rows[i]) entry = hn::Zero(Floats());
      right[i] = hn::Zero(Floats());
    }
  }
  HWY_INLINE void Solve() {
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t first = i + 1 > reach ? i + 1 - reach : 0;
      for (std::size_t j = first; j < i; ++j) {  // first the row of L D, then that of L
        F sum = At(i, j);
        for (std::size_t k = first; k < j; ++k) sum = hn::NegMulAdd(At(i, k), At(j, k), sum);
        At(i, j) = sum;
      }
      F pivot = At(i, i), value = right[i];
      for (std::size_t j = first; j < i; ++j) {
        const F factor = hn::Mul(At(i, j), At(j, j));
        pivot = hn::NegMulAdd(factor, At(i, j), pivot);
        At(i, j) = factor;
        value = hn::NegMulAdd(factor, right[j], value);
      }
      right[i] = value;
      At(i, i) = hn::IfThenElseZero(hn::Gt(pivot, hn::Zero(Floats())), hn::Div(Number(1), pivot));
    }
    for (std::size_t i = size; i-- > 0;) {
      F value = hn::Mul(right[i], At(i, i));
      const std::size_t end = i + reach < size ? i + reach : size;
      for (std::size_t j = i + 1; j < end; ++j) value = hn::NegMulAdd(At(j, i), right[j], value);
      right[i] = value;
    }
  }
};

// The sums of a segment, transposed: one lane for each problem.
struct SumLanes {
  alignas(32) float of[segment_sums][fit_lanes];
};
template <std::size_t count>
HWY_INLINE void Turn(const std::array<std::array<SegmentSums, count>, fit_lanes>& sums, SumLanes (&out)[count]) {
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t lane = 0; lane < fit_lanes; ++lane) {
      const float* from = &sums[lane][k].light;
      for (std::size_t i = 0; i < segment_sums; ++i) out[k].of[i][lane] = from[i];
    }
  }
}

// Adds the prior strength/2 (apart/unit)^2 of two neighbours whose numbers move by a and b units.
template <class Matrix>
HWY_INLINE void Couple(Matrix& matrix, std::size_t i, std::size_t j, bool wraps, float strength, F apart, F a, F b) {
  const F pull = hn::Mul(Number(strength), apart), twice = Number(wraps ? 2 * strength : strength);
  matrix.right[i] = hn::NegMulAdd(pull, a, matrix.right[i]);
  matrix.right[j] = hn::MulAdd(pull, b, matrix.right[j]);
  matrix.At(i, i) = hn::MulAdd(hn::Mul(twice, a), a, matrix.At(i, i));
  matrix.At(j, j) = hn::MulAdd(hn::Mul(twice, b), b, matrix.At(j, j));
  if (!wraps) matrix.At(j, i) = hn::NegMulAdd(hn::Mul(Number(strength), a), b, matrix.At(j, i));
}

// Makes a step of Fisher scoring for modes and scales. Knots are in units of their scales; the hats couple neighbours.
template <std::size_t count>
void MoveShapes(const Group& group, LayerLanes<count>& layer, const SumLanes (&sums)[count],
                const InformationLanes& known, const RibbonPrior& prior) {
  Bands<3 * count> matrix;
  matrix.Clear();
  F unit[count][3];
  for (std::size_t k = 0; k < count; ++k) {
    unit[k][1] = group.Load(layer.knots[k].scale_below);
    unit[k][2] = group.Load(layer.knots[k].scale_above);
    unit[k][0] = hn::Sqrt(hn::Mul(unit[k][1], unit[k][2]));
  }
  const F known_mode = group.Load(known.mode), known_cross = group.Load(known.cross),
          known_scale = group.Load(known.scale);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t next = layer.after(k);
    const bool wraps = next < k;
    const auto sum = [&](std::size_t i) HWY_ATTR { return hn::LoadU(Floats(), sums[k].of[i] + group.g); };
    for (std::size_t i = 0; i < 3; ++i) {
      const F all = sum(2 + 2 * i), by_s = sum(3 + 2 * i);
      matrix.right[3 * k + i] = hn::MulAdd(hn::Sub(all, by_s), unit[k][i], matrix.right[3 * k + i]);
      matrix.right[3 * next + i] = hn::MulAdd(by_s, unit[next][i], matrix.right[3 * next + i]);
    }
    const Fisher fisher(known_mode, known_cross, known_scale, hn::Add(unit[k][1], unit[next][1]),
                        hn::Add(unit[k][2], unit[next][2]));
    const F all = sum(8), by_s = sum(9), squares_after = sum(10);
    const F both = hn::Sub(by_s, squares_after), squares = hn::Sub(hn::Sub(all, by_s), both);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        if (j <= i) {
          F& here = matrix.At(3 * k + i, 3 * k + j);
          here = hn::MulAdd(hn::Mul(squares, fisher.of[i][j]), hn::Mul(unit[k][i], unit[k][j]), here);
          F& there = matrix.At(3 * next + i, 3 * next + j);
          there = hn::MulAdd(hn::Mul(squares_after, fisher.of[i][j]), hn::Mul(unit[next][i], unit[next][j]), there);
        }
        if (!wraps) {
          F& between = matrix.At(3 * next + i, 3 * k + j);
          between = hn::MulAdd(hn::Mul(both, fisher.of[i][j]), hn::Mul(unit[next][i], unit[k][j]), between);
        }
      }
    }
    const KnotLanes &here = layer.knots[k], &there = layer.knots[next];
    const F inverse = hn::Div(Number(1), hn::Sqrt(hn::Mul(unit[k][0], unit[next][0])));
    Couple(matrix, 3 * k, 3 * next, wraps, prior.mode,
           hn::Mul(hn::Sub(group.Load(here.mode), group.Load(there.mode)), inverse), hn::Mul(unit[k][0], inverse),
           hn::Mul(unit[next][0], inverse));
    const F one = Number(1);
    Couple(matrix, 3 * k + 1, 3 * next + 1, wraps, prior.scale,
           hn::Sub(group.Load(here.log_below), group.Load(there.log_below)), one, one);
    Couple(matrix, 3 * k + 2, 3 * next + 2, wraps, prior.scale,
           hn::Sub(group.Load(here.log_above), group.Load(there.log_above)), one, one);
    // The exits that the parent counts for, with the information of the current shape.
    const Fisher own(known_mode, known_cross, known_scale, unit[k][1], unit[k][2]);
    const F exits = group.Load(here.prior_light), per_product = hn::Div(one, hn::Mul(unit[k][1], unit[k][2]));
    const F off[3] = {hn::Div(hn::Sub(group.Load(here.prior_mode), group.Load(here.mode)), unit[k][0]),
                      hn::Sub(group.Load(here.prior_log_below), group.Load(here.log_below)),
                      hn::Sub(group.Load(here.prior_log_above), group.Load(here.log_above))};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const F information =
            hn::Mul(hn::Mul(exits, own.of[i][j]), hn::Mul(hn::Mul(unit[k][i], unit[k][j]), per_product));
        if (j <= i) matrix.At(3 * k + i, 3 * k + j) = hn::Add(matrix.At(3 * k + i, 3 * k + j), information);
        matrix.right[3 * k + i] = hn::MulAdd(information, off[j], matrix.right[3 * k + i]);
      }
    }
  }
  for (std::size_t i = 0; i < 3 * count; ++i) {
    matrix.At(i, i) = hn::MulAdd(matrix.At(i, i), Number(1.001f), Number(1e-3f));
  }
  matrix.Solve();
  const float least = std::log(layer.least_scale), most = std::log(Ribbon::largest_scale);
  for (std::size_t k = 0; k < count; ++k) {
    KnotLanes& knot = layer.knots[k];
    const F by = Within(matrix.right[3 * k], -largest_mode_step, largest_mode_step);
    const F mode = hn::MulAdd(unit[k][0], by, group.Load(knot.mode));
    group.Store(Within(mode, -Ribbon::largest_mode, Ribbon::largest_mode), knot.mode);
    const auto move = [&](std::size_t i, Lanes& log_scale, Lanes& scale) HWY_ATTR {
      const F step = Within(matrix.right[3 * k + i], -largest_scale_step, largest_scale_step);
      const F now = Within(hn::Add(group.Load(log_scale), step), least, most);
      group.Store(now, log_scale);
      group.Store(Within(ExpOf(now), layer.least_scale, Ribbon::largest_scale), scale);
    };
    move(1, knot.log_below, knot.scale_below);
    move(2, knot.log_above, knot.scale_above);
  }
}

// Computes the light of each knot's hat, with the prior that its density is the mean of its neighbours'.
template <std::size_t count>
void MoveDensities(const Group& group, F exits, LayerLanes<count>& layer, const SumLanes (&sums)[count], float prior) {
  F next[count], largest = hn::Zero(Floats());
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t b = layer.before(k);
    const KnotLanes &knot = layer.knots[k], &knot_before = layer.knots[b], &knot_after = layer.knots[layer.after(k)];
    const auto sum = [&](std::size_t at, std::size_t i)
                         HWY_ATTR { return hn::LoadU(Floats(), sums[at].of[i] + group.g); };
    const F of_hat = hn::Add(sum(b, 1), hn::Sub(sum(k, 0), sum(k, 1)));
    const F light = hn::MulAdd(group.Load(knot.density), of_hat, group.Load(knot.prior_light));
    const F to_before = group.Load(knot_before.width), to_after = group.Load(knot.width);
    const F between = hn::Div(
        hn::MulAdd(group.Load(knot_before.density), to_after, hn::Mul(group.Load(knot_after.density), to_before)),
        hn::Add(to_before, to_after));
    const F per_density = hn::Mul(exits, group.Load(knot.hat));
    const F expected = hn::Mul(per_density, between);
    const F known = hn::Mul(Number(0.5f), hn::Add(light, expected));  // number of exits that determine it
    const F posterior = hn::MulAdd(known, light, hn::Mul(Number(prior), expected));
    next[k] = hn::Div(posterior, hn::Mul(hn::Add(known, Number(prior)), per_density));
    largest = hn::Max(largest, next[k]);
  }
  for (std::size_t k = 0; k < count; ++k) {
    group.Store(hn::Max(next[k], hn::Mul(Number(no_light), largest)), layer.knots[k].density);
  }
}

void ScaleToOne(const Group& group, RibbonLanes& lanes) {
  F mass = hn::Zero(Floats());
  for (const KnotLanes& knot : lanes.main.knots)
    mass = hn::MulAdd(group.Load(knot.density), group.Load(knot.hat), mass);
  for (const KnotLanes& knot : lanes.broad.knots)
    mass = hn::MulAdd(group.Load(knot.density), group.Load(knot.hat), mass);
  const F factor = hn::IfThenElse(hn::Gt(mass, Number(least_mass)), hn::Div(Number(1), mass), Number(1));
  for (KnotLanes& knot : lanes.main.knots) group.Store(hn::Mul(group.Load(knot.density), factor), knot.density);
  for (KnotLanes& knot : lanes.broad.knots) group.Store(hn::Mul(group.Load(knot.density), factor), knot.density);
}

void ScaleAllToOne(RibbonLanes& lanes) {
  for (std::size_t g = 0; g < fit_lanes; g += hn::Lanes(Floats())) ScaleToOne({g}, lanes);
}

void MoveLayers(RibbonLanes& lanes, const RowSums& sums, const RibbonPrior& prior) {
  InformationLanes of_main, of_broad;
  Lanes exits = lanes.count;
  for (std::size_t lane = 0; lane < fit_lanes; ++lane) {
    const auto store = [lane](const LawInformation& law, InformationLanes& to) {
      to.mode[lane] = law.mode;
      to.cross[lane] = law.cross;
      to.scale[lane] = law.scale;
    };
    store(InformationOf(lanes.law[lane]), of_main);
    store(InformationOf(HeightLaw::logistic), of_broad);
    for (const KnotLanes& knot : lanes.main.knots) exits[lane] += knot.prior_light[lane];
    for (const KnotLanes& knot : lanes.broad.knots) exits[lane] += knot.prior_light[lane];
  }
  SumLanes main[Ribbon::main_knots], broad[Ribbon::broad_knots];
  Turn(sums.main, main);
  Turn(sums.broad, broad);
  for (std::size_t g = 0; g < fit_lanes; g += hn::Lanes(Floats())) {
    const Group group{g};
    MoveShapes(group, lanes.main, main, of_main, prior);
    MoveDensities(group, group.Load(exits), lanes.main, main, prior.density);
    MoveShapes(group, lanes.broad, broad, of_broad, prior);
    MoveDensities(group, group.Load(exits), lanes.broad, broad, prior.density);
    ScaleToOne(group, lanes);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::adaptive
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::adaptive {

HWY_EXPORT(MoveLayers);
HWY_EXPORT(ScaleAllToOne);

void move_layers(RibbonLanes& lanes, const RowSums& sums, const RibbonPrior& prior) {
  HWY_DYNAMIC_DISPATCH(MoveLayers)(lanes, sums, prior);
}
void scale_to_one(RibbonLanes& lanes) { HWY_DYNAMIC_DISPATCH(ScaleAllToOne)(lanes); }

}  // namespace tress::inline v0_2::adaptive
#endif
