// A row between others has their lobes on the way from one to the other.
#include "density/interpolated_row.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "adaptive/random_ribbons.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {
namespace {

RibbonRow row_of(std::vector<RibbonRow::Part> parts) { return RibbonRow(parts); }

RibbonRow random_row(std::uint64_t seed, bool rough = false) {
  return row_of({{random_ribbon(seed, rough), 0.2f},
                 {random_ribbon(seed + 1, rough), 0},
                 {random_ribbon(seed + 2, rough), 0.7f}});
}

/// All azimuths and modes moved.
Ribbon moved(const Ribbon& ribbon, float turn, float rise) {
  std::array<RibbonKnot, Ribbon::main_knots> main;
  std::array<RibbonKnot, Ribbon::broad_knots> broad;
  std::ranges::copy(ribbon.main(), main.begin());
  std::ranges::copy(ribbon.broad(), broad.begin());
  for (RibbonKnot& knot : main) {
    knot.azimuth = wrap_angle(knot.azimuth + turn);
    knot.mode += rise;
  }
  std::ranges::sort(main, {}, &RibbonKnot::azimuth);
  return Ribbon(main, ribbon.main_law(), broad);
}

/// A lobe of one width all around but for a peak at x.
Ribbon peak(float x, HeightLaw law = HeightLaw::normal) {
  std::array<RibbonKnot, Ribbon::main_knots> main;
  std::array<RibbonKnot, Ribbon::broad_knots> broad;
  for (std::size_t k = 0; k < main.size(); ++k) {
    const float s = (static_cast<float>(k) + 0.5f) / 16 - 1;  // denser about the peak
    const float away = std::numbers::pi_v<float> * s * (0.4f + 0.6f * s * s);
    main[k] = {wrap_angle(x + away), std::exp(-2 * away * away) + 0.01f, 0.1f, 0.1f, 0.2f, {0.8f, 0.4f}};
  }
  std::ranges::sort(main, {}, &RibbonKnot::azimuth);
  for (std::size_t k = 0; k < broad.size(); ++k) {
    broad[k] = {std::numbers::pi_v<float> * (static_cast<float>(k) / 4 - 1), 0.002f, 0, 0.5f, 0.5f, {0.8f, 0.4f}};
  }
  return Ribbon(main, law, broad);
}

/// Of the densities, relative L2.
double apart(const Ribbon& f, const Ribbon& g) {
  double off = 0, all = 0;
  for (int i = 0; i < 240; ++i) {
    for (int j = 0; j < 120; ++j) {
      const float x = 0.0261799f * (static_cast<float>(i) + 0.5f) - 3.1415927f, t = 0.03f * static_cast<float>(j - 60);
      const double a = f.density(x, t), b = g.density(x, t);
      off += (a - b) * (a - b);
      all += a * a;
    }
  }
  return std::sqrt(off / all);
}

TEST(InterpolatedRow, OfOneRowAloneIsThatRow) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const RibbonRow one = random_row(seed, seed % 2 == 1), other = random_row(seed + 7);
    const DecodedRow decoded(one), unused(other);
    EXPECT_EQ(interpolate_rows(std::array<WeightedRow, 1>{{{&decoded, 1.0f}}}), one) << seed;
    EXPECT_EQ(interpolate_rows(std::array<WeightedRow, 3>{{{&unused, 0.0f}, {&decoded, 1.0f}, {&unused, 0.0f}}}), one)
        << seed;
  }
}

TEST(InterpolatedRow, BetweenEqualRowsIsTheSameRow) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const RibbonRow row = random_row(seed, seed % 2 == 1);
    const DecodedRow decoded(row);
    const RibbonRow halfway = interpolate_rows(std::array<WeightedRow, 2>{{{&decoded, 0.5f}, {&decoded, 0.5f}}});
    EXPECT_EQ(halfway, row) << seed;
  }
}

// A peak moved by 0.4 with its width of 0.5, over the cut at pi too. A mixture of both is as far from either as they
// are from each other but for a half; what is moved is the peak between them.
TEST(InterpolatedRow, HalvesTheWayOfWhatHasMoved) {
  for (const float x : {0.3f, 2.9f, -2.7f, 3.0f}) {
    const Ribbon from = peak(x), to = moved(from, 0.4f, 0.2f), between = moved(from, 0.2f, 0.1f);
    const DecodedRow a(row_of({{from, 0.4f}})), b(row_of({{to, 0.8f}}));
    const RibbonRow row = interpolate_rows(std::array<WeightedRow, 2>{{{&a, 0.5f}, {&b, 0.5f}}});
    EXPECT_FLOAT_EQ(row.mass(0), 0.6f);
    const double off = apart(between, row.ribbon(0)), whole = apart(from, to);
    EXPECT_GT(whole, 0.5) << x;
    EXPECT_LT(off, 0.06) << x;  // the packing of three rows: steps of 5 % of densities, of 3 % of scales
    EXPECT_NEAR(apart(from, row.ribbon(0)) / apart(from, between), 1, 0.1) << x;
  }
}

TEST(InterpolatedRow, TakesTheLawOfTheLargestWeightAndWidensTheOther) {
  const Ribbon normal = peak(1), logistic = peak(1, HeightLaw::logistic);
  const DecodedRow a(row_of({{normal, 0.4f}})), b(row_of({{logistic, 0.4f}}));
  for (const float weight : {0.6f, 0.4f}) {
    const RibbonRow row = interpolate_rows(std::array<WeightedRow, 2>{{{&a, weight}, {&b, 1 - weight}}});
    EXPECT_EQ(row.ribbon(0).main_law(), weight > 0.5f ? HeightLaw::normal : HeightLaw::logistic);
    const double ratio = static_cast<double>(row.ribbon(0).main()[5].scale_above) / 0.2;
    EXPECT_NEAR(std::log(ratio), weight > 0.5f ? -0.4 * std::log(0.6) : 0.4 * std::log(0.6), 0.03);  // packing: 0.014
  }
}

TEST(InterpolatedRow, IsARowWhateverItsParents) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    RandomStream random(seed, 5);
    const std::array<DecodedRow, 4> rows{
        DecodedRow(random_row(4 * seed, true)), DecodedRow(random_row(4 * seed + 1, true)),
        DecodedRow(random_row(4 * seed + 2, true)), DecodedRow(random_row(4 * seed + 3, true))};
    const float u = random.next(), v = random.next();
    const RibbonRow row = interpolate_rows(std::array<WeightedRow, 4>{
        {{&rows[0], u * v}, {&rows[1], u * (1 - v)}, {&rows[2], (1 - u) * v}, {&rows[3], (1 - u) * (1 - v)}}});
    RibbonRow read;
    ASSERT_TRUE(read.unpack(row.packed(), row.masses())) << seed;
    EXPECT_EQ(read.mass(1), 0);
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
