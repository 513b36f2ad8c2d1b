#include "fiber/rough_paths.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "base/sobol.h"
#include "tress/base/random.h"

// foreach_target compiles this once for every instruction set; the first call chooses the machine's.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fiber/rough_paths.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/float_lanes.h"

#ifndef TRESS_ROUGH_PATHS_FIELDS
#define TRESS_ROUGH_PATHS_FIELDS
namespace tress::inline v0_2::fiber {
namespace {

constexpr std::size_t block = 16;

/// The fields of light on its way to a surface; words are kept as the bits of floats.
enum Field : std::size_t {
  dx,
  dy,
  dz,  // x, y, z of its direction
  px,
  py,  // its last point (x, y/e)
  weight,
  way,  // the same as in SplitExit
  seed,
  path,  // words: both together key all further random numbers
  tag,   // a word, see below
  ua,
  ub,
  uc,
  ud,  // numbers of the next facet and of the one after it
  surface_fields,
  ue = surface_fields,
  uf,  // for light that enters: numbers of the third facet
  start_fields,
  log_below = surface_fields,  // for light within a microsurface: the logarithm of the share of heights below it
  luck,                        // the uniform number that decides whether it meets another facet
  walk_fields
};

// Tags: the set in four bits; flags; the order, at most 7; the number of facets met on prepared numbers, at most 3; the
// number of steps. In walks in_film means that a side of the surface is water, and on_film that it is the film's outer
// surface. Light that is to draw `again` meets the film if it is_beyond.
constexpr std::uint32_t is_inside = 1u << 4, crosses = 1u << 5, is_step = 1u << 6, again = 1u << 7, is_beyond = 1u << 8,
                        one_order = 1u << 9, most_orders = 7u << 9, one_facet = 1u << 12, most_facets = 3u << 12,
                        in_core = 1u << 14, in_film = 1u << 15, on_film = crosses, one_step = 1u << 16,
                        most_steps = 0x3fffu << 16;
// Flags of light before its first facet. It shares what that facet reflects away with more_reflections other paths; of
// these nothing else is followed.
constexpr std::uint32_t shares_first = 1u << 30, only_first = 1u << 31;

}  // namespace
}  // namespace tress::inline v0_2::fiber
#endif

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::fiber {
namespace HWY_NAMESPACE {

using namespace tress::HWY_NAMESPACE::lanes16;
namespace hn = hwy::HWY_NAMESPACE;

constexpr float least_cosine = 1e-6f, lowest = 1e-6f, log_lowest = -13.8155106f;

HWY_INLINE Mask Has(W tags, std::uint32_t flag) { return hn::RebindMask(Floats(), hn::TestBit(tags, SplatWord(flag))); }
HWY_INLINE W IfWords(Mask mask, W yes, W no) { return hn::IfThenElse(hn::RebindMask(Words(), mask), yes, no); }
HWY_INLINE W FlagIf(Mask mask, std::uint32_t flag) {
  return hn::IfThenElseZero(hn::RebindMask(Words(), mask), SplatWord(flag));
}
HWY_INLINE bool Any(Mask mask) { return !hn::AllFalse(Floats(), mask); }

// The k-th number of an event, from its seed and the index of its path. It is a 32-bit hash (constants of Wellons) that
// mixes in the path half way, so that events of other paths with the same seed have other numbers.
HWY_INLINE W BitsOf(W seeds, W paths, std::uint32_t k) {
  W x = hn::Add(seeds, SplatWord(k * 0x9e3779b9u));
  x = hn::Xor(x, hn::ShiftRight<16>(x));
  x = hn::Mul(x, SplatWord(0x7feb352du));
  x = hn::Xor(hn::Xor(x, hn::ShiftRight<15>(x)), paths);
  x = hn::Mul(x, SplatWord(0x846ca68bu));
  return hn::Xor(x, hn::ShiftRight<16>(x));
}
// Uniform in (0, 1], 24 bits.
HWY_INLINE F NumberOf(W seeds, W paths, std::uint32_t k) {
  const auto whole = hn::BitCast(hn::RebindToSigned<Words>(), hn::ShiftRight<8>(BitsOf(seeds, paths, k)));
  return hn::MulAdd(hn::ConvertTo(Floats(), whole), Splat(0x1p-24f), Splat(0x1p-24f));
}

HWY_INLINE F Dot(F ax, F ay, F az, F bx, F by, F bz) { return hn::MulAdd(ax, bx, hn::MulAdd(ay, by, hn::Mul(az, bz))); }
// One Newton step onto the unit sphere.
HWY_INLINE void OntoUnit(F& x, F& y, F& z) {
  const F scale = hn::NegMulAdd(Splat(0.5f), Dot(x, y, z, x, y, z), Splat(1.5f));
  x = hn::Mul(x, scale);
  y = hn::Mul(y, scale);
  z = hn::Mul(z, scale);
}

// Smith's Lambda of c = cot(theta)/alpha > 0, absolute error 2e-7, and e^{-c^2}. The error function is that of
// Abramowitz and Stegun 7.1.26.
HWY_INLINE void LambdaOf(F c, F& lambda, F& bell) {
  bell = Exp(hn::Neg(hn::Mul(c, c)));
  const F reach = hn::MulAdd(c, Splat(0.3275911f), Splat(1));
  const F inverse = hn::Div(Splat(1), hn::Mul(c, reach)), t = hn::Mul(inverse, c);
  F p = hn::MulAdd(Splat(0.5f * 1.061405429f), t, Splat(0.5f * -1.453152027f));
  p = hn::MulAdd(p, t, Splat(0.5f * 1.421413741f));
  p = hn::MulAdd(p, t, Splat(0.5f * -0.284496736f));
  p = hn::MulAdd(p, t, Splat(0.5f * 0.254829592f));
  const F by_level = hn::Mul(hn::Mul(inverse, reach), Splat(0.28209479f));  // 1/(2 sqrt(pi) c)
  lambda = hn::Max(hn::Mul(bell, hn::NegMulAdd(p, t, by_level)), hn::Zero(Floats()));
}

// cot(theta)/alpha of the angle to the normal; the cosine is taken as positive.
HWY_INLINE F Steepness(F cosine, F inverse_alpha) {
  const F up = hn::Max(hn::Abs(cosine), Splat(1e-7f));
  const F sine = hn::Sqrt(hn::Max(hn::NegMulAdd(up, up, Splat(1)), Splat(1e-14f)));
  return hn::Div(hn::Mul(up, inverse_alpha), sine);
}

// Whether light at a height, heading for that cosine above the mean surface, meets another facet. luck: in (0, 1].
HWY_INLINE Mask Stays(F cosine, F log_of_below, F luck_number, F inverse_alpha) {
  F lambda, bell;
  LambdaOf(Steepness(cosine, inverse_alpha), lambda, bell);
  const F leaves = Exp(hn::Mul(lambda, log_of_below));
  return hn::Or(hn::Lt(cosine, Splat(1e-7f)), hn::Gt(luck_number, leaves));
}

// Draws the slopes (x along, y across, in alphas) of a facet seen at the steepness c, of either sign; `rejected` marks
// lanes to draw again. For c > 0, with normal slopes, the density (c - x) e^{-x^2} below c has two parts: a normal law,
// mirrored from x > 0 with probability x/c, and (|x| - c) e^{-x^2} beyond -c. For c < 0 only the second part exists. It
// is drawn from Rayleigh's law beyond |c| and accepted with probability (|x| - c)/|x|.
HWY_INLINE void FacetSlopes(F c, F bell, F u0, F u1, W seeds, W paths, std::uint32_t k, F& x, F& y, Mask& rejected) {
  const F radius2 = hn::Max(hn::Neg(Log(hn::Sub(Splat(1), u0))), hn::Zero(Floats())), radius = hn::Sqrt(radius2);
  F sine, cosine;
  SineAndCosineOfTurns(u1, sine, cosine);
  x = hn::Mul(radius, cosine);
  y = hn::Mul(radius, sine);
  const F number = NumberOf(seeds, paths, k), half_bell = hn::Mul(Splat(0.5f), bell);
  const F all = hn::MulAdd(c, Splat(1.77245385f), half_bell);
  const F second = NumberOf(seeds, paths, k + 1);
  const Mask beyond = hn::Or(hn::Lt(hn::Mul(number, all), half_bell), hn::Lt(c, hn::Zero(Floats())));
  x = hn::IfThenElse(hn::Lt(hn::Mul(second, c), x), hn::Neg(x), x);
  rejected = hn::MaskFromVec(hn::Zero(Floats()));
  if (Any(beyond)) {
    const F away = hn::Abs(c), far = hn::Sqrt(hn::MulAdd(away, away, radius2));
    const F height = hn::Sqrt(hn::Neg(Log(NumberOf(seeds, paths, k + 2))));
    rejected = hn::And(beyond, hn::Ge(hn::Mul(second, far), hn::Sub(far, away)));
    x = hn::IfThenElse(beyond, hn::Neg(far), x);
    y = hn::IfThenElse(beyond, hn::Mul(height, sine), y);
  }
}

// Unpolarised reflectance of a facet, and the cosine beyond it; ratio: the index beyond over that before.
HWY_INLINE void Fresnel(F cos_i, F ratio, F inverse_ratio, F& reflected, F& cos_t) {
  const F sine = hn::Mul(hn::NegMulAdd(cos_i, cos_i, Splat(1)), hn::Mul(inverse_ratio, inverse_ratio));
  const F cos2_t = hn::Sub(Splat(1), hn::Max(sine, hn::Zero(Floats())));
  const Mask passes = hn::Gt(cos2_t, hn::Zero(Floats()));
  cos_t = hn::Sqrt(hn::IfThenElseZero(passes, cos2_t));
  const F s = hn::Mul(ratio, cos_t), p = hn::Mul(ratio, cos_i);
  const F sum_s = hn::Add(cos_i, s), sum_p = hn::Add(p, cos_t);
  const F inverse = hn::Div(Splat(1), hn::Mul(sum_s, sum_p));
  const F rs = hn::Mul(hn::Mul(hn::Sub(cos_i, s), sum_p), inverse),
          rp = hn::Mul(hn::Mul(hn::Sub(p, cos_t), sum_s), inverse);
  reflected = hn::IfThenElse(passes, hn::Mul(Splat(0.5f), hn::MulAdd(rs, rs, hn::Mul(rp, rp))), Splat(1));
}

// One row of floats for each field, 16 records wide.
template <std::size_t fields>
struct alignas(64) Stage {
  float row[fields][block];
};

HWY_INLINE void Put(float* row, F x) { hn::Store(x, Floats(), row); }
HWY_INLINE void Put(float* row, W x) { hn::Store(FloatsOf(x), Floats(), row); }
HWY_INLINE F Get(const float* row) { return hn::Load(Floats(), row); }
HWY_INLINE W GetWord(const float* row) { return WordsOf(hn::Load(Floats(), row)); }

// Moves the lanes in a mask to the front of vectors. Highway's Compress for vectors of 8 and of 4 has a table in a
// local array, which g++ copies for each call; here the lanes are looked up once for each mask.
#if HWY_MAX_BYTES >= 64 || HWY_HAVE_SCALABLE || HWY_TARGET == HWY_SCALAR
class Packing {
 public:
  explicit HWY_INLINE Packing(Mask mask) : mask_(mask) {}
  HWY_INLINE F operator()(F x) const { return hn::Compress(x, mask_); }

 private:
  Mask mask_;
};
#else
class Packing {
 public:
  explicit HWY_INLINE Packing(Mask mask) : lanes_(hn::IndicesFromVec(Floats(), hn::Load(Words(), lanes_of(mask)))) {}
  HWY_INLINE F operator()(F x) const { return hn::TableLookupLanes(x, lanes_); }

 private:
  static constexpr std::size_t width = hn::MaxLanes(Floats());
  struct alignas(32) Table {
    std::uint32_t lanes[std::size_t{1} << width][width];
  };
  static constexpr Table table = [] {
    Table made{};
    for (std::size_t bits = 0; bits < std::size_t{1} << width; ++bits) {
      std::size_t count = 0;
      for (std::uint32_t lane = 0; lane < width; ++lane) {
        if (bits >> lane & 1) made.lanes[bits][count++] = lane;
      }
    }
    return made;
  }();
  static HWY_INLINE const std::uint32_t* lanes_of(Mask mask) {
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(Floats(), mask, bits);
    return table.lanes[bits[0]];
  }

  decltype(hn::IndicesFromVec(Floats(), hn::Zero(Words()))) lanes_;
};
#endif

// Appends those of 16 records whose weight is above 0. (It uses Compress and StoreU, because compressed stores are
// microcode on Zen 4.)
template <std::size_t fields>
HWY_INLINE void Append(LaneStack& to, const float* const (&rows)[fields], const float* weights) {
  to.reserve(block);
  for (std::size_t i = 0; i < block; i += hn::Lanes(Floats())) {
    const Mask mask = hn::Gt(Get(weights + i), hn::Zero(Floats()));
    const std::size_t count = hn::CountTrue(Floats(), mask);
    if (count == 0) continue;
    const Packing packed(mask);
    float* out = to.field(0) + to.size();
    const std::size_t stride = to.stride();
    for (std::size_t f = 0; f < fields; ++f) hn::StoreU(packed(Get(rows[f] + i)), Floats(), out + f * stride);
    to.resize(to.size() + count);
  }
}

/// is_wet: whether there is water. Without it, all masks of water are left out.
template <bool is_wet>
struct Kernel {
  const RoughPaths::Constants& fiber;
  LaneStack& surface;
  LaneStack& walks;
  LaneStack& flights;
  LaneStack& exits;
  float inverse_e = 1 / fiber.eccentricity;

  static HWY_INLINE Mask Unless(Mask of_water, Mask mask) {
    if constexpr (is_wet) return hn::AndNot(of_water, mask);
    return mask;
  }
  static HWY_INLINE W WithFlag(W tags, Mask of_water, std::uint32_t flag) {
    if constexpr (is_wet) return hn::Or(tags, FlagIf(of_water, flag));
    return tags;
  }

  // The surfaces that lanes meet: their roughness, and the index beyond over that before.
  struct Surface {
    F alpha, inverse_alpha, ratio, inverse_ratio;
  };
  // inside: from inside. water: of those between air and water, or water and hair; outer: of the former.
  HWY_INLINE Surface SurfaceOf(Mask inside, Mask water, Mask outer) const {
    F alpha = Splat(fiber.alpha), inverse_alpha = Splat(1 / fiber.alpha);
    F index = Splat(fiber.eta), inverse = Splat(1 / fiber.eta);
    if constexpr (is_wet) {
      const float under = fiber.eta / eta_of_water;
      alpha = hn::IfThenElse(outer, Splat(fiber.film_alpha), alpha);
      inverse_alpha = hn::IfThenElse(outer, Splat(1 / fiber.film_alpha), inverse_alpha);
      index = hn::IfThenElse(outer, Splat(eta_of_water), hn::IfThenElse(water, Splat(under), index));
      inverse = hn::IfThenElse(outer, Splat(1 / eta_of_water), hn::IfThenElse(water, Splat(1 / under), inverse));
    }
    return {alpha, inverse_alpha, hn::IfThenElse(inside, inverse, index), hn::IfThenElse(inside, index, inverse)};
  }

  // Returns (0, y, z) of the outward normal at a point.
  HWY_INLINE void NormalAt(F x, F y, F& ny, F& nz) const {
    const F by_e = hn::Mul(Splat(fiber.eccentricity), x);
    const F inverse = hn::Div(Splat(1), hn::Sqrt(hn::MulAdd(by_e, by_e, hn::Mul(y, y))));
    ny = hn::Mul(by_e, inverse);
    nz = hn::Mul(y, inverse);
  }

  // The normal of a face of the cuticle, on the side of light from outside (1) or inside (-1).
  HWY_INLINE void FaceOf(Mask step, Mask outer_film, F side, F ny, F nz, F& fx, F& fy, F& fz) const {
    const F by_cosine = hn::Mul(side, Splat(fiber.cos_tilt));
    fx = hn::IfThenElse(step, side, hn::Mul(by_cosine, Splat(-fiber.tan_tilt)));
    fy = hn::IfThenZeroElse(step, hn::Mul(by_cosine, ny));
    fz = hn::IfThenZeroElse(step, hn::Mul(by_cosine, nz));
    if constexpr (is_wet) {  // water fills the scales
      fx = hn::IfThenZeroElse(outer_film, fx);
      fy = hn::IfThenElse(outer_film, hn::Mul(side, ny), fy);
      fz = hn::IfThenElse(outer_film, hn::Mul(side, nz), fz);
    }
  }

  // Appends light that goes on: to the surface, or first through the fiber if it does not cross it straight. "through"
  // is the weight of the light that crosses.
  HWY_INLINE void AppendOnward(const float* const (&rows)[surface_fields], const float* tags) {
    if (fiber.parts.are_plain()) return Append(surface, rows, rows[weight]);
    alignas(64) float through[block], here[block];
    for (std::size_t i = 0; i < block; i += hn::Lanes(Floats())) {
      const Mask crossing = Has(GetWord(tags + i), crosses);
      const F w = Get(rows[weight] + i);
      Put(through + i, hn::IfThenElseZero(crossing, w));
      Put(here + i, hn::IfThenZeroElse(crossing, w));
    }
    Append(flights, rows, through);
    Append(surface, rows, here);
  }

  // Roulette: returns the weight with which light goes on.
  HWY_INLINE F Kept(F w, W seeds, W paths, std::uint32_t k) const {
    const F below = Splat(fiber.roulette_below), number = NumberOf(seeds, paths, k);
    const F survives = hn::IfThenElseZero(hn::Le(hn::Mul(number, below), w), below);
    return hn::IfThenElse(hn::Lt(w, below), survives, w);
  }

  // Computes a facet's normal and the cosine to it. w: towards where light comes from, at that cosine to `f`.
  HWY_INLINE void FacetNormal(F wx, F wy, F wz, F cosine, F sine, F fx, F fy, F fz, F alpha, F x, F y, F& mx, F& my,
                              F& mz, F& cos_i, F& cos_m) const {
    const F inverse_sine = hn::Div(Splat(1), sine);
    F tx = hn::Mul(hn::NegMulAdd(cosine, fx, wx), inverse_sine),
      ty = hn::Mul(hn::NegMulAdd(cosine, fy, wy), inverse_sine),
      tz = hn::Mul(hn::NegMulAdd(cosine, fz, wz), inverse_sine);
    const Mask upright = hn::Lt(sine, Splat(2e-6f));
    if (Any(upright)) {  // any tangent
      const Mask flat = hn::Lt(hn::Abs(fx), Splat(0.5f));
      F ax = hn::IfThenZeroElse(flat, hn::Neg(fz)), ay = hn::IfThenElseZero(flat, fz),
        az = hn::IfThenElse(flat, hn::Neg(fy), fx);
      const F inverse = hn::Div(Splat(1), hn::Sqrt(Dot(ax, ay, az, ax, ay, az)));
      tx = hn::IfThenElse(upright, hn::Mul(ax, inverse), tx);
      ty = hn::IfThenElse(upright, hn::Mul(ay, inverse), ty);
      tz = hn::IfThenElse(upright, hn::Mul(az, inverse), tz);
    }
    const F a = hn::Mul(alpha, x), b = hn::Mul(alpha, y);
    cos_m = hn::Div(Splat(1), hn::Sqrt(hn::MulAdd(a, a, hn::MulAdd(b, b, Splat(1)))));
    const F bx = hn::MulSub(fy, tz, hn::Mul(fz, ty)), by = hn::MulSub(fz, tx, hn::Mul(fx, tz)),
            bz = hn::MulSub(fx, ty, hn::Mul(fy, tx));
    mx = hn::Mul(cos_m, hn::NegMulAdd(b, bx, hn::NegMulAdd(a, tx, fx)));
    my = hn::Mul(cos_m, hn::NegMulAdd(b, by, hn::NegMulAdd(a, ty, fy)));
    mz = hn::Mul(cos_m, hn::NegMulAdd(b, bz, hn::NegMulAdd(a, tz, fz)));
    cos_i = hn::Min(hn::Max(hn::Mul(cos_m, hn::NegMulAdd(a, sine, cosine)), hn::Zero(Floats())), Splat(1));
  }

  HWY_NOINLINE void SurfaceBlock(const float* const (&in)[start_fields], std::size_t count) {
    Stage<walk_fields> stays;       // light that stays within the microsurface
    Stage<surface_fields> goes_on;  // light inside that goes to the surface again
    Stage<RoughPathExits::fields> leaves;
    Stage<8> also_stays, also_goes_on, ends;  // cases that few lanes have
    bool any_also_stays = false, any_also_goes_on = false, any_ends = false;
    const F zero = hn::Zero(Floats());
    for (std::size_t i = 0; i < block; i += hn::Lanes(Floats())) {
      if (i >= count) {
        Put(stays.row[weight] + i, zero);
        Put(goes_on.row[weight] + i, zero);
        Put(leaves.row[RoughPathExits::weight_field] + i, zero);
        Put(also_stays.row[0] + i, zero);
        Put(also_goes_on.row[0] + i, zero);
        Put(ends.row[0] + i, zero);
        continue;
      }
      const auto load = [&](std::size_t f) HWY_ATTR { return hn::LoadU(Floats(), in[f] + i); };
      F vx = load(dx), vy = load(dy), vz = load(dz), x = load(px), y = load(py), length = load(way);
      W tags = WordsOf(load(tag));
      const W seeds = WordsOf(load(seed)), paths = WordsOf(load(path));
      const W lane = hn::Iota(Words(), static_cast<std::uint32_t>(i));
      const Mask alive =
          hn::RebindMask(Floats(), hn::And(hn::Lt(lane, SplatWord(static_cast<std::uint32_t>(count))),
                                           hn::Ne(hn::And(tags, SplatWord(most_steps)), SplatWord(most_steps))));
      F light = hn::IfThenElseZero(alive, load(weight));

      // Moves light through the fiber to where it meets the surface.
      const Mask crossing = Has(tags, crosses);
      {
        const F across_z = hn::Mul(vz, Splat(inverse_e));
        const F across2 = hn::Max(hn::MulAdd(vy, vy, hn::Mul(across_z, across_z)), Splat(1e-12f));
        const F toward = hn::MulAdd(x, vy, hn::Mul(y, across_z));
        const F straight = hn::Max(hn::Div(hn::Mul(Splat(-2), toward), across2), zero);
        const F chord = fiber.parts.are_plain() ? hn::IfThenElseZero(crossing, straight) : zero;  // it has been moved
        x = hn::MulAdd(chord, vy, x);
        y = hn::MulAdd(chord, across_z, y);
        const F onto = hn::NegMulAdd(Splat(0.5f), hn::MulAdd(x, x, hn::Mul(y, y)), Splat(1.5f));
        x = hn::Mul(x, onto);
        y = hn::Mul(y, onto);
        length = hn::Add(length, chord);
        const Mask counts = hn::And(
            crossing, hn::RebindMask(Floats(), hn::Ne(hn::And(tags, SplatWord(most_orders)), SplatWord(most_orders))));
        tags = hn::AndNot(SplatWord(crosses), hn::Add(tags, FlagIf(counts, one_order)));
      }
      Put(stays.row[way] + i, length);
      Put(stays.row[path] + i, paths);
      Put(stays.row[px] + i, x);
      Put(stays.row[py] + i, y);
      Put(leaves.row[RoughPathExits::tag_field] + i, tags);

      // Light whose way is too long ends where it is.
      {
        const Mask late = hn::RebindMask(Floats(), hn::TestBit(tags, SplatWord(4u << 9)));
        const Mask too_far = hn::And(hn::And(crossing, late), hn::Gt(length, Splat(fiber.longest_way)));
        const F ended = hn::IfThenElseZero(too_far, light);
        Put(ends.row[0] + i, ended);
        if (Any(hn::Gt(ended, zero))) {
          any_ends = true;
          Put(ends.row[1] + i, vx);
          Put(ends.row[2] + i, vy);
          Put(ends.row[3] + i, vz);
          light = hn::IfThenZeroElse(too_far, light);
        }
      }

      F ny, nz, fx, fy, fz;
      NormalAt(x, y, ny, nz);
      Mask inside = Has(tags, is_inside), water = hn::MaskFromVec(zero), outer_film = water, covered = water;
      if constexpr (is_wet) {
        const Mask within = Has(tags, in_film), away = hn::Gt(hn::MulAdd(vy, ny, hn::Mul(vz, nz)), zero);
        const Mask known = Has(tags, again), drawn = hn::Le(NumberOf(seeds, paths, 13), Splat(fiber.parts.wetness));
        covered = hn::Or(hn::And(known, Has(tags, is_beyond)), hn::AndNot(known, drawn));
        covered = hn::AndNot(within, covered);
        water = hn::Or(within, covered);
        outer_film = hn::Or(hn::And(within, away), hn::AndNot(inside, covered));
        inside = hn::Or(inside, hn::And(within, away));
      }
      const auto [alpha, inverse_alpha, ratio, inverse_ratio] = SurfaceOf(inside, water, outer_film);
      const F side = hn::IfThenElse(inside, Splat(-1), Splat(1));
      F wx = hn::Neg(vx), wy = hn::Neg(vy), wz = hn::Neg(vz);
      Mask step = hn::MaskFromVec(zero);
      if (fiber.tan_tilt > 0) {
        const F tangent = Splat(fiber.tan_tilt), to_side = hn::Mul(side, wx);
        const F seen_step = hn::Mul(tangent, hn::Max(to_side, zero));
        const F to_slope = hn::NegMulAdd(tangent, to_side, hn::Mul(side, hn::MulAdd(wy, ny, hn::Mul(wz, nz))));
        const F both = hn::Add(seen_step, hn::Max(to_slope, zero));
        step = hn::Lt(hn::Mul(NumberOf(seeds, paths, 0), both), seen_step);
        const Mask known = Has(tags, again), known_step = Has(tags, is_step);
        step = Unless(outer_film, hn::Or(hn::And(known, known_step), hn::AndNot(known, step)));
        FaceOf(step, outer_film, side, ny, nz, fx, fy, fz);
      } else {
        fx = zero;
        fy = hn::Mul(side, ny);
        fz = hn::Mul(side, nz);
      }
      F cosine = Dot(wx, wy, wz, fx, fy, fz);
      const Mask past = hn::Lt(cosine, Splat(least_cosine));
      if (Any(past)) {
        const F lift = hn::IfThenElseZero(past, hn::Sub(Splat(least_cosine), cosine));
        wx = hn::MulAdd(lift, fx, wx);
        wy = hn::MulAdd(lift, fy, wy);
        wz = hn::MulAdd(lift, fz, wz);
        const F inverse = hn::IfThenElse(past, hn::Div(Splat(1), hn::Sqrt(Dot(wx, wy, wz, wx, wy, wz))), Splat(1));
        wx = hn::Mul(wx, inverse);
        wy = hn::Mul(wy, inverse);
        wz = hn::Mul(wz, inverse);
        cosine = hn::IfThenElse(past, hn::Mul(Splat(least_cosine), inverse), cosine);
      }

      // The first facet: its height and its slope.
      const F flat_x = hn::NegMulAdd(cosine, fx, wx), flat_y = hn::NegMulAdd(cosine, fy, wy),
              flat_z = hn::NegMulAdd(cosine, fz, wz);
      const F sine = hn::Max(hn::Sqrt(Dot(flat_x, flat_y, flat_z, flat_x, flat_y, flat_z)), Splat(1e-6f));
      const F c = hn::Div(hn::Mul(cosine, inverse_alpha), sine);
      F lambda, bell;
      LambdaOf(c, lambda, bell);
      const F log_b = hn::Max(hn::Div(Log(NumberOf(seeds, paths, 1)), hn::Add(lambda, Splat(1))), Splat(log_lowest));
      const F log_above = Log(hn::Max(hn::Sub(Splat(1), Exp(log_b)), Splat(lowest)));
      const W facets_met = hn::And(tags, SplatWord(most_facets));
      const Mask prepared =
          hn::AndNot(Has(tags, again), hn::RebindMask(Floats(), hn::Ne(facets_met, SplatWord(most_facets))));
      const F u0 = hn::IfThenElse(prepared, load(ua), hn::Sub(NumberOf(seeds, paths, 2), Splat(0x1p-24f)));
      const F u1 = hn::IfThenElse(prepared, load(ub), NumberOf(seeds, paths, 3));
      F slope_x, slope_y, mx, my, mz, cos_i, cos_m, reflected, cos_t;
      Mask rejected;
      FacetSlopes(c, bell, u0, u1, seeds, paths, 4, slope_x, slope_y, rejected);
      FacetNormal(wx, wy, wz, cosine, sine, fx, fy, fz, alpha, slope_x, slope_y, mx, my, mz, cos_i, cos_m);
      Fresnel(cos_i, ratio, inverse_ratio, reflected, cos_t);

      // The reflected and the refracted light, and how steeply they rise from their sides of the surface.
      const F twice = hn::Add(cos_i, cos_i), bend = hn::MulSub(cos_i, inverse_ratio, cos_t);
      F rx = hn::MulSub(twice, mx, wx), ry = hn::MulSub(twice, my, wy), rz = hn::MulSub(twice, mz, wz);
      F tx = hn::MulSub(bend, mx, hn::Mul(inverse_ratio, wx)), ty = hn::MulSub(bend, my, hn::Mul(inverse_ratio, wy)),
        tz = hn::MulSub(bend, mz, hn::Mul(inverse_ratio, wz));
      OntoUnit(rx, ry, rz);
      OntoUnit(tx, ty, tz);
      const F rises_r = Dot(rx, ry, rz, fx, fy, fz), rises_t = hn::Neg(Dot(tx, ty, tz, fx, fy, fz));
      light = hn::IfThenZeroElse(rejected, light);
      const Mask shares = Has(tags, shares_first), ends_here = Has(tags, only_first);
      const F light_r = hn::Mul(light, reflected), light_t = hn::NegMulAdd(light, reflected, light);
      const F inner_x = hn::IfThenElse(inside, rx, tx), inner_y = hn::IfThenElse(inside, ry, ty),
              inner_z = hn::IfThenElse(inside, rz, tz);
      const F outer_x = hn::IfThenElse(inside, tx, rx), outer_y = hn::IfThenElse(inside, ty, ry),
              outer_z = hn::IfThenElse(inside, tz, rz);
      const F inner_light = hn::IfThenElse(inside, light_r, light_t),
              outer_light = hn::IfThenElse(inside, light_t, light_r);
      const F inner_rises = hn::IfThenElse(inside, rises_r, rises_t),
              outer_rises = hn::IfThenElse(inside, rises_t, rises_r);
      const F inner_log = hn::IfThenElse(inside, log_b, log_above),
              outer_log = hn::IfThenElse(inside, log_above, log_b);
      const F inner_luck = NumberOf(seeds, paths, 7), outer_luck = NumberOf(seeds, paths, 8);
      const Mask inner_stays = Stays(inner_rises, inner_log, inner_luck, inverse_alpha),
                 outer_stays = Stays(outer_rises, outer_log, outer_luck, inverse_alpha);
      const Mask outer_away = hn::Gt(hn::MulAdd(outer_y, ny, hn::Mul(outer_z, nz)), zero);
      const Mask inner_in = hn::Lt(hn::MulAdd(inner_y, ny, hn::Mul(inner_z, nz)), zero);
      const W inner_seed = BitsOf(seeds, paths, 9), outer_seed = BitsOf(seeds, paths, 10);
      const W fewer = hn::AndNot(
          SplatWord(shares_first | only_first | is_inside | crosses | is_step | again | is_beyond | in_film), tags);
      const W onward = hn::Add(hn::Add(fewer, SplatWord(one_step)),
                               FlagIf(hn::RebindMask(Floats(), hn::Ne(facets_met, SplatWord(most_facets))), one_facet));

      // Light that leaves. Under the film it does not: it is in the film then.
      const Mask to_film = Unless(outer_film, water), leaves_here = Unless(to_film, outer_away);
      Put(leaves.row[RoughPathExits::dx] + i, outer_x);
      Put(leaves.row[RoughPathExits::dy] + i, outer_y);
      Put(leaves.row[RoughPathExits::dz] + i, outer_z);
      const F leaving = hn::IfThenElseZero(hn::AndNot(outer_stays, leaves_here), outer_light);
      Put(leaves.row[RoughPathExits::weight_field] + i,
          hn::IfThenElse(shares, hn::Mul(leaving, Splat(1.0f / (1 + RoughPaths::more_reflections))), leaving));

      // Light that goes on inside, or draws another facet here.
      const F inner_on = Kept(hn::IfThenZeroElse(hn::Or(inner_stays, ends_here), inner_light), seeds, paths, 11);
      Put(goes_on.row[weight] + i, inner_on);
      Put(goes_on.row[dx] + i, inner_x);
      Put(goes_on.row[dy] + i, inner_y);
      Put(goes_on.row[dz] + i, inner_z);
      Put(goes_on.row[seed] + i, inner_seed);
      W then_inside = hn::Or(SplatWord(is_inside), FlagIf(inner_in, crosses));
      if constexpr (is_wet) then_inside = IfWords(outer_film, SplatWord(in_film), then_inside);
      Put(goes_on.row[tag] + i, hn::Or(onward, then_inside));
      const F next_a = load(uc), next_b = load(ud), next_c = load(ue), next_d = load(uf);
      Put(goes_on.row[ua] + i, next_a);
      Put(goes_on.row[ub] + i, next_b);
      Put(goes_on.row[uc] + i, next_c);
      Put(goes_on.row[ud] + i, next_d);
      const F old_light = load(weight);
      const Mask draws_again = hn::And(rejected, hn::And(alive, hn::Not(hn::Gt(Get(ends.row[0] + i), zero))));
      if (Any(draws_again)) {
        const auto instead = [&](std::size_t f, F value) HWY_ATTR {
          Put(goes_on.row[f] + i, hn::IfThenElse(draws_again, value, Get(goes_on.row[f] + i)));
        };
        instead(weight, old_light);
        instead(dx, vx);
        instead(dy, vy);
        instead(dz, vz);
        const W kept = hn::Add(hn::AndNot(SplatWord(is_step | is_beyond), tags), SplatWord(one_step));
        const W drawn = WithFlag(FlagIf(step, is_step), covered, is_beyond);
        instead(tag, FloatsOf(hn::Or(kept, hn::Or(SplatWord(again), drawn))));
        instead(ua, next_c);
        instead(ub, next_d);
        instead(uc, next_a);
        instead(ud, next_b);
      }

      // Light that meets another facet.
      const F inner_walks = hn::IfThenElseZero(hn::AndNot(ends_here, inner_stays), inner_light),
              outer_walks = hn::IfThenElseZero(hn::AndNot(ends_here, outer_stays), outer_light);
      const Mask first = hn::Gt(inner_walks, zero), second = hn::Gt(outer_walks, zero);
      const W walks_from = WithFlag(WithFlag(onward, water, in_film), outer_film, on_film);
      const W walk_tags = hn::Or(hn::Or(walks_from, FlagIf(inside, is_inside)), FlagIf(step, is_step));
      const W inner_walk_tags = hn::Or(walk_tags, hn::AndNot(FlagIf(inside, is_beyond), SplatWord(is_beyond)));
      const W outer_walk_tags = hn::Or(walk_tags, FlagIf(inside, is_beyond));
      Put(stays.row[weight] + i, hn::IfThenElse(first, inner_walks, outer_walks));
      Put(stays.row[dx] + i, hn::IfThenElse(first, inner_x, outer_x));
      Put(stays.row[dy] + i, hn::IfThenElse(first, inner_y, outer_y));
      Put(stays.row[dz] + i, hn::IfThenElse(first, inner_z, outer_z));
      Put(stays.row[seed] + i, IfWords(first, inner_seed, outer_seed));
      Put(stays.row[tag] + i, IfWords(first, inner_walk_tags, outer_walk_tags));
      Put(stays.row[log_below] + i, hn::IfThenElse(first, inner_log, outer_log));
      Put(stays.row[luck] + i, hn::IfThenElse(first, inner_luck, outer_luck));
      const Mask both = hn::And(first, second);
      Put(also_stays.row[0] + i, hn::IfThenElseZero(both, outer_walks));
      if (Any(both)) {
        any_also_stays = true;
        Put(also_stays.row[1] + i, outer_x);
        Put(also_stays.row[2] + i, outer_y);
        Put(also_stays.row[3] + i, outer_z);
        Put(also_stays.row[4] + i, outer_seed);
        Put(also_stays.row[5] + i, outer_walk_tags);
        Put(also_stays.row[6] + i, outer_log);
        Put(also_stays.row[7] + i, outer_luck);
      }

      // Light that has left its face outside and meets the fiber again, or the film.
      const Mask outer_returns =
          hn::AndNot(hn::Or(hn::Or(outer_stays, leaves_here), ends_here), hn::Gt(outer_light, zero));
      Put(also_goes_on.row[0] + i, zero);
      if (Any(outer_returns)) {
        any_also_goes_on = true;
        Put(also_goes_on.row[0] + i, Kept(hn::IfThenElseZero(outer_returns, outer_light), seeds, paths, 12));
        Put(also_goes_on.row[1] + i, outer_x);
        Put(also_goes_on.row[2] + i, outer_y);
        Put(also_goes_on.row[3] + i, outer_z);
        Put(also_goes_on.row[4] + i, outer_seed);
        Put(also_goes_on.row[5] + i, WithFlag(onward, to_film, in_film));
      }
    }

    const float *at_x = stays.row[px], *at_y = stays.row[py], *lengths = stays.row[way], *paths = stays.row[path];
    const float* tags = leaves.row[RoughPathExits::tag_field];
    const auto& u = goes_on.row;
    Append(exits,
           {leaves.row[RoughPathExits::dx], leaves.row[RoughPathExits::dy], leaves.row[RoughPathExits::dz],
            leaves.row[RoughPathExits::weight_field], lengths, paths, tags},
           leaves.row[RoughPathExits::weight_field]);
    AppendOnward(
        {u[dx], u[dy], u[dz], at_x, at_y, u[weight], lengths, u[seed], paths, u[tag], u[ua], u[ub], u[uc], u[ud]},
        u[tag]);
    Append(walks,
           {stays.row[dx], stays.row[dy], stays.row[dz], at_x, at_y, stays.row[weight], lengths, stays.row[seed], paths,
            stays.row[tag], u[ua], u[ub], u[uc], u[ud], stays.row[log_below], stays.row[luck]},
           stays.row[weight]);
    if (any_also_stays) {
      const auto& also = also_stays.row;
      Append(walks,
             {also[1], also[2], also[3], at_x, at_y, also[0], lengths, also[4], paths, also[5], u[ua], u[ub], u[uc],
              u[ud], also[6], also[7]},
             also[0]);
    }
    if (any_also_goes_on) {
      const auto& also = also_goes_on.row;
      Append(surface,
             {also[1], also[2], also[3], at_x, at_y, also[0], lengths, also[4], paths, also[5], u[ua], u[ub], u[uc],
              u[ud]},
             also[0]);
    }
    if (any_ends) {
      Append(exits, {ends.row[1], ends.row[2], ends.row[3], ends.row[0], lengths, paths, tags}, ends.row[0]);
    }
  }

  HWY_NOINLINE void WalkBlock(const float* const (&in)[walk_fields], std::size_t count) {
    Stage<walk_fields> stays;
    Stage<surface_fields> goes_on;
    Stage<RoughPathExits::fields> leaves;
    const F zero = hn::Zero(Floats());
    for (std::size_t i = 0; i < block; i += hn::Lanes(Floats())) {
      if (i >= count) {
        Put(stays.row[weight] + i, zero);
        Put(goes_on.row[weight] + i, zero);
        Put(leaves.row[RoughPathExits::weight_field] + i, zero);
        continue;
      }
      const auto load = [&](std::size_t f) HWY_ATTR { return hn::LoadU(Floats(), in[f] + i); };
      const F vx = load(dx), vy = load(dy), vz = load(dz);
      const W tags = WordsOf(load(tag)), seeds = WordsOf(load(seed)), paths = WordsOf(load(path));
      const W lane = hn::Iota(Words(), static_cast<std::uint32_t>(i));
      const Mask alive =
          hn::RebindMask(Floats(), hn::And(hn::Lt(lane, SplatWord(static_cast<std::uint32_t>(count))),
                                           hn::Ne(hn::And(tags, SplatWord(most_steps)), SplatWord(most_steps))));
      const F light = hn::IfThenElseZero(alive, load(weight));
      F ny, nz, fx, fy, fz;
      NormalAt(load(px), load(py), ny, nz);
      // The mean normal on the light's side, which is inside if it came from inside and did not pass, or came from
      // outside and did.
      const Mask was_inside = Has(tags, is_inside), beyond = Has(tags, is_beyond),
                 now_inside = hn::Xor(was_inside, beyond);
      const Mask outer_film = Has(tags, on_film), water = Has(tags, in_film);
      const auto [alpha, inverse_alpha, ratio, inverse_ratio] = SurfaceOf(now_inside, water, outer_film);
      const F side = hn::IfThenElse(now_inside, Splat(-1), Splat(1));
      FaceOf(Has(tags, is_step), outer_film, side, ny, nz, fx, fy, fz);

      // Moves to the next facet, which rising light meets with some probability; with `again` it is already there.
      const F rises = Dot(vx, vy, vz, fx, fy, fz), steep = Steepness(rises, inverse_alpha);
      const Mask up = hn::Gt(rises, zero);
      F lambda, bell;
      LambdaOf(steep, lambda, bell);
      const F exponent =
          hn::Div(Splat(1), hn::IfThenElse(up, hn::Neg(hn::Max(lambda, Splat(1e-12f))), hn::Add(lambda, Splat(1))));
      const F moved = hn::IfThenZeroElse(Has(tags, again), hn::Mul(exponent, Log(load(luck))));
      const F log_b = hn::Min(hn::Max(hn::Add(load(log_below), moved), Splat(log_lowest)), zero);
      const F log_above = Log(hn::Max(hn::Sub(Splat(1), Exp(log_b)), Splat(lowest)));

      const F wx = hn::Neg(vx), wy = hn::Neg(vy), wz = hn::Neg(vz), cosine = hn::Neg(rises);
      const F flat_x = hn::NegMulAdd(cosine, fx, wx), flat_y = hn::NegMulAdd(cosine, fy, wy),
              flat_z = hn::NegMulAdd(cosine, fz, wz);
      const F sine = hn::Max(hn::Sqrt(Dot(flat_x, flat_y, flat_z, flat_x, flat_y, flat_z)), Splat(1e-6f));
      F slope_x, slope_y, mx, my, mz, cos_i, cos_m, reflected, cos_t;
      Mask rejected;
      FacetSlopes(hn::IfThenElse(up, hn::Neg(steep), steep), bell, hn::Sub(NumberOf(seeds, paths, 0), Splat(0x1p-24f)),
                  NumberOf(seeds, paths, 1), seeds, paths, 2, slope_x, slope_y, rejected);
      FacetNormal(wx, wy, wz, cosine, sine, fx, fy, fz, alpha, slope_x, slope_y, mx, my, mz, cos_i, cos_m);
      Fresnel(cos_i, ratio, inverse_ratio, reflected, cos_t);
      const Mask passes = hn::Gt(NumberOf(seeds, paths, 5), reflected);
      const F along_m = hn::IfThenElse(passes, hn::MulSub(cos_i, inverse_ratio, cos_t), hn::Add(cos_i, cos_i));
      const F along_w = hn::IfThenElse(passes, inverse_ratio, Splat(1));
      F ox = hn::MulSub(along_m, mx, hn::Mul(along_w, wx)), oy = hn::MulSub(along_m, my, hn::Mul(along_w, wy)),
        oz = hn::MulSub(along_m, mz, hn::Mul(along_w, wz));
      OntoUnit(ox, oy, oz);
      const F risen = Dot(ox, oy, oz, fx, fy, fz), risen_there = hn::IfThenElse(passes, hn::Neg(risen), risen);
      const F log_there = hn::IfThenElse(passes, log_above, log_b);
      const F number = NumberOf(seeds, paths, 6);
      const Mask walks_on = hn::Or(rejected, Stays(risen_there, log_there, number, inverse_alpha));
      const auto either = [&](F old, F made) HWY_ATTR { return hn::IfThenElse(rejected, old, made); };
      const W toggled = hn::Xor(tags, FlagIf(hn::AndNot(rejected, passes), is_beyond));
      const W next = hn::Add(hn::AndNot(SplatWord(again), toggled), SplatWord(one_step));
      const W next_seed = BitsOf(seeds, paths, 7);
      Put(stays.row[weight] + i, hn::IfThenElseZero(walks_on, light));
      Put(stays.row[dx] + i, either(vx, ox));
      Put(stays.row[dy] + i, either(vy, oy));
      Put(stays.row[dz] + i, either(vz, oz));
      Put(stays.row[seed] + i, next_seed);
      Put(stays.row[tag] + i, hn::Or(next, FlagIf(rejected, again)));
      Put(stays.row[log_below] + i, either(log_b, log_there));
      Put(stays.row[luck] + i, number);

      const Mask then_inside = hn::Xor(now_inside, passes);
      const F out = hn::MulAdd(oy, ny, hn::Mul(oz, nz));
      Mask to_film = hn::MaskFromVec(zero);
      if constexpr (is_wet) {
        to_film = hn::And(water, hn::Xor(hn::Not(then_inside), outer_film));
      }
      const Mask exits_here = Unless(to_film, hn::AndNot(then_inside, hn::Gt(out, zero)));
      const F left = hn::IfThenZeroElse(walks_on, light);
      Put(leaves.row[RoughPathExits::weight_field] + i, hn::IfThenElseZero(exits_here, left));
      Put(goes_on.row[weight] + i, Kept(hn::IfThenZeroElse(exits_here, left), seeds, paths, 8));
      const W cleared = hn::AndNot(SplatWord(is_inside | is_step | is_beyond | in_film | on_film), next);
      const Mask in_hair = Unless(to_film, then_inside), heads_in = hn::And(in_hair, hn::Lt(out, zero));
      Put(goes_on.row[dx] + i, ox);
      Put(goes_on.row[dy] + i, oy);
      Put(goes_on.row[dz] + i, oz);
      Put(goes_on.row[tag] + i,
          hn::Or(WithFlag(cleared, to_film, in_film), hn::Or(FlagIf(in_hair, is_inside), FlagIf(heads_in, crosses))));
      const auto copy = [&](std::size_t f) HWY_ATTR { Put(stays.row[f] + i, load(f)); };
      copy(px);
      copy(py);
      copy(way);
      copy(path);
      copy(ua);
      copy(ub);
      copy(uc);
      copy(ud);
    }
    const auto& all = stays.row;
    const auto& on = goes_on.row;
    Append(exits, {on[dx], on[dy], on[dz], leaves.row[RoughPathExits::weight_field], all[way], all[path], on[tag]},
           leaves.row[RoughPathExits::weight_field]);
    AppendOnward({on[dx], on[dy], on[dz], all[px], all[py], on[weight], all[way], all[seed], all[path], on[tag],
                  all[ua], all[ub], all[uc], all[ud]},
                 on[tag]);
    Append(walks,
           {all[dx], all[dy], all[dz], all[px], all[py], all[weight], all[way], all[seed], all[path], all[tag], all[ua],
            all[ub], all[uc], all[ud], all[log_below], all[luck]},
           all[weight]);
  }

  // The distance along a line, from a place within, to the surface or the core. (x, y): the place; across: the line.
  HWY_INLINE F WayOut(F x, F y, F across_y, F across_z, F inverse_across2, float radius) const {
    const F b = hn::Mul(hn::MulAdd(x, across_y, hn::Mul(y, across_z)), inverse_across2);
    const F inside = hn::Sub(Splat(radius * radius), hn::MulAdd(x, x, hn::Mul(y, y)));
    const F c = hn::Mul(hn::Max(inside, hn::Zero(Floats())), inverse_across2);
    return hn::Max(hn::Sub(hn::Sqrt(hn::MulAdd(b, b, c)), b), hn::Zero(Floats()));
  }

  HWY_INLINE F CortexFlight(W seeds, W paths, std::uint32_t k) const {
    return hn::Mul(Log(NumberOf(seeds, paths, k)), Splat(-1 / fiber.parts.cortex_scattering));
  }

  // Turns a direction by Henyey and Greenstein's law.
  static HWY_INLINE void Scatter(float g, W seeds, W paths, F& x, F& y, F& z) {
    const F u = NumberOf(seeds, paths, 1);
    F cosine = hn::NegMulAdd(Splat(2), u, Splat(1));
    if (std::abs(g) >= 1e-3f) {
      const F share = hn::Div(Splat(1 - g * g), hn::MulAdd(Splat(2 * g), u, Splat(1 - g)));
      cosine = hn::Mul(hn::NegMulAdd(share, share, Splat(1 + g * g)), Splat(1 / (2 * g)));
      cosine = hn::Min(hn::Max(cosine, Splat(-1)), Splat(1));
    }
    const F sine = hn::Sqrt(hn::Max(hn::NegMulAdd(cosine, cosine, Splat(1)), hn::Zero(Floats())));
    F turn_sine, turn_cosine;
    SineAndCosineOfTurns(NumberOf(seeds, paths, 2), turn_sine, turn_cosine);
    const Mask steep = hn::Lt(hn::Abs(x), Splat(0.5f));
    F sx = hn::IfThenZeroElse(steep, hn::Neg(z)), sy = hn::IfThenElseZero(steep, z),
      sz = hn::IfThenElse(steep, hn::Neg(y), x);
    const F inverse = hn::Div(Splat(1), hn::Sqrt(Dot(sx, sy, sz, sx, sy, sz)));
    sx = hn::Mul(sx, inverse);
    sy = hn::Mul(sy, inverse);
    sz = hn::Mul(sz, inverse);
    const F tx = hn::MulSub(y, sz, hn::Mul(z, sy)), ty = hn::MulSub(z, sx, hn::Mul(x, sz)),
            tz = hn::MulSub(x, sy, hn::Mul(y, sx));
    const F a = hn::Mul(sine, turn_cosine), b = hn::Mul(sine, turn_sine);
    x = hn::MulAdd(b, tx, hn::MulAdd(a, sx, hn::Mul(cosine, x)));
    y = hn::MulAdd(b, ty, hn::MulAdd(a, sy, hn::Mul(cosine, y)));
    z = hn::MulAdd(b, tz, hn::MulAdd(a, sz, hn::Mul(cosine, z)));
    OntoUnit(x, y, z);
  }

  // The same as cross_interior(): moves light to the core, through it and to the surface, or to where it scatters on
  // that way.
  HWY_NOINLINE void FlightBlock(const float* const (&in)[surface_fields], std::size_t count) {
    Stage<surface_fields> flies;
    alignas(64) float scattered[block], arrived[block];
    const TracedParts& core = fiber.parts;
    const bool cortex_scatters = core.cortex_scattering > 0;
    const F zero = hn::Zero(Floats());
    for (std::size_t i = 0; i < block; i += hn::Lanes(Floats())) {
      if (i >= count) {
        Put(scattered + i, zero);
        Put(arrived + i, zero);
        continue;
      }
      const auto load = [&](std::size_t f) HWY_ATTR { return hn::LoadU(Floats(), in[f] + i); };
      F vx = load(dx), vy = load(dy), vz = load(dz), x = load(px), y = load(py), length = load(way);
      const W tags = WordsOf(load(tag)), seeds = WordsOf(load(seed)), paths = WordsOf(load(path));
      const W lane = hn::Iota(Words(), static_cast<std::uint32_t>(i));
      const Mask alive =
          hn::RebindMask(Floats(), hn::And(hn::Lt(lane, SplatWord(static_cast<std::uint32_t>(count))),
                                           hn::Ne(hn::And(tags, SplatWord(most_steps)), SplatWord(most_steps))));
      F light = hn::IfThenElseZero(alive, load(weight));
      F across_z = hn::Mul(vz, Splat(inverse_e));
      F inverse = hn::Div(Splat(1), hn::Max(hn::MulAdd(vy, vy, hn::Mul(across_z, across_z)), Splat(1e-12f)));

      // Moves to the core.
      const Mask within = Has(tags, in_core);
      const F middle = hn::Mul(hn::Neg(hn::MulAdd(x, vy, hn::Mul(y, across_z))), inverse);
      const F near_x = hn::MulAdd(middle, vy, x), near_y = hn::MulAdd(middle, across_z, y);
      const F half2 = hn::Mul(
          hn::Sub(Splat(core.radius * core.radius), hn::MulAdd(near_x, near_x, hn::Mul(near_y, near_y))), inverse);
      const Mask meets = hn::And(hn::Gt(half2, zero), hn::Gt(middle, zero));
      const F half = hn::Sqrt(hn::Max(half2, zero));
      F to_core = hn::IfThenElseZero(hn::AndNot(within, meets), hn::Max(hn::Sub(middle, half), zero));
      F left = hn::IfThenElse(within, WayOut(x, y, vy, across_z, inverse, core.radius),
                              hn::IfThenElseZero(meets, hn::Add(half, half)));
      Mask turns = hn::MaskFromVec(zero);  // scatters in the cortex
      if (cortex_scatters) {
        const F flight = CortexFlight(seeds, paths, 5);
        turns = hn::Lt(flight, to_core);
        to_core = hn::Min(flight, to_core);
        left = hn::IfThenZeroElse(turns, left);
      }
      length = hn::Add(length, to_core);

      // Makes a flight in the core.
      F flight = Splat(1e30f);
      if (core.scattering > 0) flight = hn::Mul(Log(NumberOf(seeds, paths, 0)), Splat(-1 / core.scattering));
      const F flown = hn::Min(flight, left), moved = hn::Add(to_core, flown);
      x = hn::MulAdd(moved, vy, x);
      y = hn::MulAdd(moved, across_z, y);
      if (core.absorption > 0) {
        light = Kept(hn::Mul(light, Exp(hn::Mul(flown, Splat(-core.absorption)))), seeds, paths, 3);
      }
      const Mask stays = hn::Lt(flight, left);
      Mask scatters = hn::Or(stays, turns);

      // Moves to the surface, or scatters.
      F rest = hn::IfThenZeroElse(scatters, WayOut(x, y, vy, across_z, inverse, 1));
      if (cortex_scatters) {
        const F flight_on = CortexFlight(seeds, paths, 6);
        turns = hn::Or(turns, hn::Lt(flight_on, rest));
        scatters = hn::Or(stays, turns);
        rest = hn::Min(flight_on, rest);
      }
      Put(scattered + i, hn::IfThenElseZero(scatters, light));
      Put(arrived + i, hn::IfThenZeroElse(scatters, light));
      length = hn::Add(length, rest);
      x = hn::MulAdd(rest, vy, x);
      y = hn::MulAdd(rest, across_z, y);
      const F size = hn::Sqrt(hn::MulAdd(x, x, hn::Mul(y, y)));
      const F onto = hn::IfThenElse(scatters, Splat(1), hn::Div(Splat(1), hn::Max(size, Splat(1e-30f))));
      F sx = vx, sy = vy, sz = vz;
      Scatter(core.asymmetry, seeds, paths, sx, sy, sz);
      if (cortex_scatters) {
        F tx = vx, ty = vy, tz = vz;
        Scatter(core.cortex_asymmetry, seeds, paths, tx, ty, tz);
        sx = hn::IfThenElse(turns, tx, sx);
        sy = hn::IfThenElse(turns, ty, sy);
        sz = hn::IfThenElse(turns, tz, sz);
      }
      Put(flies.row[dx] + i, hn::IfThenElse(scatters, sx, vx));
      Put(flies.row[dy] + i, hn::IfThenElse(scatters, sy, vy));
      Put(flies.row[dz] + i, hn::IfThenElse(scatters, sz, vz));
      Put(flies.row[px] + i, hn::Mul(x, onto));
      Put(flies.row[py] + i, hn::Mul(y, onto));
      Put(flies.row[weight] + i, light);
      Put(flies.row[way] + i, length);
      Put(flies.row[seed] + i, BitsOf(seeds, paths, 4));
      Put(flies.row[path] + i, paths);
      const W next = hn::Add(hn::AndNot(SplatWord(in_core), tags), SplatWord(one_step));
      Put(flies.row[tag] + i, hn::Or(next, FlagIf(stays, in_core)));
      for (const std::size_t f : {ua, ub, uc, ud}) Put(flies.row[f] + i, load(f));
    }
    const auto& all = flies.row;
    const float* const rows[] = {all[dx],   all[dy],   all[dz],  all[px], all[py], all[weight], all[way],
                                 all[seed], all[path], all[tag], all[ua], all[ub], all[uc],     all[ud]};
    Append(surface, rows, arrived);
    Append(flights, rows, scattered);
  }
};

// Takes the last records of a stack, at most 16, field by field. They are removed, but stay valid until others are
// appended.
template <std::size_t fields>
HWY_INLINE std::size_t TakeLast(LaneStack& stack, const float* (&in)[fields]) {
  const std::size_t count = std::min(stack.size(), block), from = stack.size() - count;
  stack.resize(from);
  for (std::size_t f = 0; f < fields; ++f) in[f] = stack.field(f) + from;
  return count;
}

// Runs until nothing is left: flights or walks if there are 16 of them, else surface events, the newest first.
template <bool is_wet>
HWY_INLINE void FollowAll(const RoughPaths::Constants& fiber, LaneStack& starts, LaneStack& surface, LaneStack& walks,
                          LaneStack& flights, LaneStack& exits) {
  Kernel<is_wet> kernel{fiber, surface, walks, flights, exits};
  const float *flight[surface_fields], *walk[walk_fields], *start[start_fields], *event[surface_fields];
  for (;;) {
    const bool at_surface = surface.size() + starts.size() > 0;
    if (flights.size() >= block || (flights.size() > 0 && !at_surface && walks.size() == 0)) {
      kernel.FlightBlock(flight, TakeLast(flights, flight));
    } else if (walks.size() >= block || (walks.size() > 0 && !at_surface)) {
      kernel.WalkBlock(walk, TakeLast(walks, walk));
    } else if (surface.size() < block && starts.size() > 0) {
      kernel.SurfaceBlock(start, TakeLast(starts, start));
    } else if (surface.size() > 0) {
      const std::size_t count = TakeLast(surface, event);
      std::copy_n(event, surface_fields, start);
      start[ue] = event[ua];
      start[uf] = event[ub];
      kernel.SurfaceBlock(start, count);
    } else {
      return;
    }
  }
}

void Follow(const RoughPaths::Constants& fiber, LaneStack& starts, LaneStack& surface, LaneStack& walks,
            LaneStack& flights, LaneStack& exits) {
  return fiber.parts.wetness > 0 ? FollowAll<true>(fiber, starts, surface, walks, flights, exits)
                                 : FollowAll<false>(fiber, starts, surface, walks, flights, exits);
}

// Places paths at their entries by scrambled points: h is in `x`, and the rest is filled in.
void Enter(const float* middle, const float* direction, std::uint64_t key, std::uint32_t first, std::uint32_t set,
           LaneStack& starts, std::size_t from, std::size_t count) {
  const W low = SplatWord(static_cast<std::uint32_t>(key)), high = SplatWord(static_cast<std::uint32_t>(key >> 32));
  for (std::size_t i = from; i < from + count; i += hn::Lanes(Floats())) {
    const F h = hn::MulSub(Splat(2), hn::LoadU(Floats(), starts.field(px) + i), Splat(1));
    const F cos_h = hn::Sqrt(hn::Max(hn::NegMulAdd(h, h, Splat(1)), hn::Zero(Floats())));
    const auto put = [&](std::size_t f, F x) HWY_ATTR { hn::StoreU(x, Floats(), starts.field(f) + i); };
    put(px, hn::NegMulAdd(Splat(middle[1]), h, hn::Mul(Splat(middle[0]), cos_h)));
    put(py, hn::MulAdd(Splat(middle[0]), h, hn::Mul(Splat(middle[1]), cos_h)));
    put(dx, Splat(-direction[0]));
    put(dy, Splat(-direction[1]));
    put(dz, Splat(-direction[2]));
    put(weight, Splat(1));
    put(way, hn::Zero(Floats()));
    const W paths = hn::Iota(Words(), first + static_cast<std::uint32_t>(i - from));
    put(path, FloatsOf(paths));
    put(seed, FloatsOf(BitsOf(BitsOf(low, paths, 0), high, 1)));
    put(tag, FloatsOf(SplatWord(set)));
  }
}

void Places(const LaneStack& exits, float cos_b, float sin_b, float largest_height, float* azimuth, float* height) {
  for (std::size_t i = 0; i < exits.size(); i += hn::Lanes(Floats())) {
    const F x = hn::LoadU(Floats(), exits.field(RoughPathExits::dx) + i),
            y = hn::LoadU(Floats(), exits.field(RoughPathExits::dy) + i),
            z = hn::LoadU(Floats(), exits.field(RoughPathExits::dz) + i);
    const F turned_z = hn::MulSub(z, Splat(cos_b), hn::Mul(y, Splat(sin_b))),
            turned_y = hn::MulAdd(y, Splat(cos_b), hn::Mul(z, Splat(sin_b)));
    const F cosine = hn::Max(hn::Sqrt(hn::MulAdd(y, y, hn::Mul(z, z))), Splat(1e-12f));
    const F above = Log(hn::Div(hn::Add(Splat(1), hn::Abs(x)), cosine));
    hn::StoreU(AngleOf(turned_z, turned_y), Floats(), azimuth + i);
    hn::StoreU(hn::CopySign(hn::Min(hn::Max(above, hn::Zero(Floats())), Splat(largest_height)), x), Floats(),
               height + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::fiber
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace tress::inline v0_2::fiber {
namespace {

constexpr std::size_t most_kept = 1 << 16;  // number of records for which a thread keeps the memory

}  // namespace

HWY_EXPORT(Follow);
HWY_EXPORT(Enter);
HWY_EXPORT(Places);

struct RoughPaths::Memory {
  LaneStack starts{start_fields}, surface{surface_fields}, walks{walk_fields}, flights{surface_fields};
  RoughPathExits exits;
};

std::unique_ptr<RoughPaths::Memory>& RoughPaths::spare() {
  thread_local std::unique_ptr<Memory> memory;
  return memory;
}

RoughPaths::RoughPaths(const FiberParameters& parameters, const SplitRules& rules)
    : fiber_(without_parts(parameters)),
      constants_{parameters.eccentricity, parameters.roughness, film_roughness(parameters.roughness),
                 parameters.eta,          fiber_.tan_tilt(),    fiber_.cos_tilt(),
                 rules.roulette_below,    rules.longest_way,    TracedParts::of(parameters)},
      memory_(std::move(spare())) {
  if (memory_ == nullptr) memory_ = std::make_unique<Memory>();
  memory_->starts.resize(0);
}

RoughPaths::~RoughPaths() {
  if (memory_->starts.size() + memory_->exits.size() <= most_kept) spare() = std::move(memory_);
}

void RoughPaths::add(const RoughEntry& entry, const RoughFiber::FacetNumbers& u, std::uint32_t seed_of_path,
                     std::uint32_t path_index, std::uint32_t set) {
  memory_->starts.reserve(1);
  const std::size_t i = memory_->starts.size();
  const auto put = [&](std::size_t f, float x) { memory_->starts.field(f)[i] = x; };
  put(dx, -entry.direction.x);
  put(dy, -entry.direction.y);
  put(dz, -entry.direction.z);
  put(px, entry.point.x);
  put(py, entry.point.y);
  put(weight, 1);
  put(way, 0);
  put(seed, std::bit_cast<float>(seed_of_path));
  put(path, std::bit_cast<float>(path_index));
  put(tag, std::bit_cast<float>(set));
  for (std::size_t k = 0; k < 6; ++k) put(std::array{ua, ub, uc, ud, ue, uf}[k], u[k / 2][k % 2]);
  memory_->starts.resize(i + 1);
}

void RoughPaths::add_sobol(const FiberDirection& wr, std::uint64_t key, std::uint32_t first, std::uint32_t count,
                           std::uint32_t set) {
  add_entries(wr, key, first, count, set);
}

void RoughPaths::add_sobol_with_reflections(const FiberDirection& wr, std::uint64_t key, std::uint32_t first,
                                            std::uint32_t count, std::uint32_t set) {
  add_entries(wr, key, first, count, set | shares_first);
  add_entries(wr, mix_bits(key), first * more_reflections, count * more_reflections, set | shares_first | only_first);
}

void RoughPaths::add_entries(const FiberDirection& wr, std::uint64_t key, std::uint32_t first, std::uint32_t count,
                             std::uint32_t tags) {
  memory_->starts.reserve(count);
  const std::size_t from = memory_->starts.size();
  std::array<float*, 7> numbers;
  constexpr std::array fields{px, ua, ub, uc, ud, ue, uf};
  for (std::size_t d = 0; d < fields.size(); ++d) numbers[d] = memory_->starts.field(fields[d]) + from;
  ScrambledSobol(key).points(first, count, numbers);
  const RoughEntry middle = fiber_.entry(wr, 0);
  HWY_DYNAMIC_DISPATCH(Enter)(&middle.point.x, &middle.direction.x, key, first, tags, memory_->starts, from, count);
  memory_->starts.resize(from + count);
}

const RoughPathExits& RoughPaths::trace() {
  RoughPathExits& exits = memory_->exits;
  exits.records_.resize(0);
  HWY_DYNAMIC_DISPATCH(Follow)
  (constants_, memory_->starts, memory_->surface, memory_->walks, memory_->flights, exits.records_);
  return exits;
}

void RoughPathExits::places(float cos_b, float sin_b, float largest_height, std::vector<float>& azimuth,
                            std::vector<float>& height) const {
  const std::size_t room = (size() + block - 1) / block * block;
  azimuth.resize(room);
  height.resize(room);
  HWY_DYNAMIC_DISPATCH(Places)(records_, cos_b, sin_b, largest_height, azimuth.data(), height.data());
  azimuth.resize(size());
  height.resize(size());
}

}  // namespace tress::inline v0_2::fiber

#endif
