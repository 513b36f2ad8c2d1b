// A sketch against a map of bins to pairs: what it keeps is the nearest to each centre, exactly; it never shrinks; its
// bins say all of it.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <tuple>
#include <vector>

#include "observations/sketch.h"
#include "properties/generators.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

using std::numbers::pi;

std::vector<SketchBin> bins_of(const std::vector<SketchBin>& first, const std::vector<SketchBin>& second,
                               std::uint32_t count) {
  Sketch sketch(count);
  sketch.merge(first);
  sketch.merge(second);
  return sketch.bins();
}

RC_GTEST_PROP(Sketch, KeepsTheNearestPairOfEachBinAndNeverLosesABin, ()) {
  const std::vector<std::uint32_t> drawn = *any_numbers(3, 500);
  const std::uint32_t bins = 1 + drawn[2] % 300;
  Sketch sketch(bins);
  struct Nearest {
    double distance;  // from the centre, in widths
    float x, g;
  };
  std::map<std::uint32_t, Nearest> model;
  RandomStream random(drawn[0]);
  std::uint32_t occupied = 0;
  for (std::uint32_t i = 0; i < drawn[1]; ++i) {
    const float x = wrap_angle(7 * (random.next() - 0.5f)), g = random.next();
    sketch.offer(x, g);
    const double at = (x + pi) / (2 * pi) * bins;
    const double index = std::min(std::floor(at), bins - 1.0);
    const Nearest pair{std::abs(at - index - 0.5), x, g};
    const std::uint32_t now = sketch.occupied();
    RC_ASSERT(now >= occupied);
    occupied = now;
    const auto [found, is_new] = model.emplace(static_cast<std::uint32_t>(index), pair);
    if (is_new) continue;
    // Of one azimuth that was given two values, the smaller.
    Nearest& kept = found->second;
    if (pair.distance < kept.distance || (pair.x == kept.x && pair.g < kept.g)) kept = pair;
  }
  RC_ASSERT(occupied == model.size());
  const std::vector<ObservedPair> pairs = sketch.pairs();
  RC_ASSERT(pairs.size() == model.size());
  std::size_t i = 0;
  for (const auto& [index, nearest] : model) {
    // Two azimuths of equal distance to 2^-31 of a width: either may be kept.
    const float x = pairs[i].azimuth, before = i > 0 ? pairs[i - 1].azimuth : x;
    RC_ASSERT(before <= x && x >= -std::numbers::pi_v<float> && x < std::numbers::pi_v<float>);
    const double distance = std::abs((x + pi) / (2 * pi) * bins - index - 0.5);
    // The quantised offset and the float azimuth: 2^-32 and, of bins up to 300 over 2 pi, 1.2e-7 (an ulp at pi
    // is 2.4e-7).
    const double rounding = 0x1p-32 + 1.3e-7 * bins / (2 * pi);
    RC_ASSERT(std::abs(distance - nearest.distance) <= rounding);
    RC_ASSERT(pairs[i].g == nearest.g || std::abs(x - nearest.x) > 3e-7);
    ++i;
  }
}

RC_GTEST_PROP(Sketch, IsWhatItsBinsSay, ()) {
  const std::uint32_t bins = 128;
  const std::vector<SketchBin> a = *any_sketch(bins);
  RC_ASSERT(bins_of(a, {}, bins) == a);
}

RC_GTEST_PROP(Sketch, MergesAsASemilattice, ()) {
  const std::uint32_t bins = 128;
  const std::vector<SketchBin> a = *any_sketch(bins), b = *any_sketch(bins), c = *any_sketch(bins);
  RC_ASSERT(bins_of(a, b, bins) == bins_of(b, a, bins));
  RC_ASSERT(bins_of(bins_of(a, b, bins), c, bins) == bins_of(a, bins_of(b, c, bins), bins));
  RC_ASSERT(bins_of(a, a, bins) == a);
  Sketch both(bins);
  both.merge(a);
  const std::uint32_t before = both.occupied();
  both.merge(b);
  RC_ASSERT(both.occupied() >= before);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
