// A ribbon is the density of its knots: mass 1, its distribution functions are its integrals, its draws invert them.
#include "tress/adaptive/ribbon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "adaptive/random_ribbons.h"
#include "support/quadrature.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;

/// Integrates over heights on both sides of `mode`, out to 40 of the largest scale, where nothing that a double sees
/// is left of either law.
template <class Function>
double over_heights(Function&& f, double mode, double to = 40) {
  const double reach = 40 * 0.9;
  if (to < mode) return test::integrate(f, mode - reach, to, 400);
  return test::integrate(f, mode - reach, mode, 400) + test::integrate(f, mode, std::min(to, mode + reach), 400);
}

TEST(HeightLaw, IsADensityWithItsShares) {
  for (const HeightLaw law : {HeightLaw::normal, HeightLaw::logistic}) {
    for (const auto& [below, above] : {std::pair{0.3f, 0.7f}, std::pair{0.9f, 0.2f}, std::pair{0.5f, 0.5f}}) {
      const auto f = [&](double t) { return height_density(law, static_cast<float>(t), 0.4f, below, above); };
      EXPECT_NEAR(over_heights(f, 0.4), 1, 1e-6);  // floats, rounded to 6e-8
      for (const float t : {-1.5f, 0.1f, 0.4f, 0.8f, 3.0f}) {
        EXPECT_NEAR(height_share_below(law, t, 0.4f, below, above), over_heights(f, 0.4, static_cast<double>(t)), 2e-6);
      }
    }
  }
}

TEST(HeightLaw, DrawsInvertTheShare) {
  for (const HeightLaw law : {HeightLaw::normal, HeightLaw::logistic}) {
    for (int i = 0; i < 2000; ++i) {
      const float u = (static_cast<float>(i) + 0.5f) / 2000;
      EXPECT_NEAR(height_share_below(law, sample_height(law, u, -2, 0.05f, 0.6f), -2, 0.05f, 0.6f), u, 1e-6f) << u;
    }
    for (const float u : {0.0f, 1e-30f, 0.99999994f, 1.0f}) {
      EXPECT_LE(std::abs(sample_height(law, u, 0, 1, 1)), 19) << u;
    }
  }
}

TEST(Ribbon, HasMassOne) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Ribbon ribbon = random_ribbon(seed, seed >= 10);
    double mass = 0;
    for (const auto layer : {ribbon.main(), ribbon.broad()}) {
      for (std::size_t k = 0; k < layer.size(); ++k) {
        const bool last = k + 1 == layer.size();
        const double width = static_cast<double>(layer[last ? 0 : k + 1].azimuth) -
                             static_cast<double>(layer[k].azimuth) + (last ? 2 * pi : 0);
        mass += 0.5 * width * static_cast<double>(layer[k].density + layer[last ? 0 : k + 1].density);
      }
    }
    EXPECT_NEAR(mass, 1, 1e-5) << seed;
    EXPECT_FLOAT_EQ(ribbon.cdf(std::nextafter(std::numbers::pi_v<float>, 0.0f), 0)[0], 1) << seed;
    EXPECT_NEAR(ribbon.cdf(-std::numbers::pi_v<float>, 0)[0], 0, 2e-6) << seed;
  }
}

TEST(Ribbon, TheUniformOneIsTheSphere) {
  const Ribbon uniform;
  for (const float x : {-3.0f, 0.0f, 9.0f}) {
    for (const double theta :
         {-1.2, 0.0, 0.7}) {  // density in theta is p(t)/cos theta; of the sphere, cos theta / 4 pi
      const double p = uniform.density(x, static_cast<float>(std::asinh(std::tan(theta))));
      EXPECT_NEAR(p / std::cos(theta), std::cos(theta) / (4 * pi), 1e-7);
    }
  }
}

TEST(Ribbon, ItsDistributionsAreItsIntegrals) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Ribbon ribbon = random_ribbon(seed, seed >= 4);
    for (const float x : {-3.1f, -1.0f, 0.2f, 2.9f}) {
      const float h = 2e-3f;
      const auto along = [&](double t) { return ribbon.density(x, static_cast<float>(t)); };
      const double all = test::integrate(along, -45, 45, 4000);
      // Between the azimuths x -+ h the marginal is nearly straight: the difference of floats near 1 over 2 h. At the
      // bounds of everything a knot may lie there.
      if (seed < 4) {
        EXPECT_NEAR((ribbon.cdf(x + h, 0)[0] - ribbon.cdf(x - h, 0)[0]) / (2 * h), all, 2e-3 + 0.02 * all) << x;
      }
      for (const float t : {-2.0f, -0.3f, 0.0f, 0.5f}) {
        const double share = test::integrate(along, -45, static_cast<double>(t), 4000) / all;
        // Panels of 0.02 are wide beside the least scale, 0.001, of the rough ones.
        EXPECT_NEAR(ribbon.cdf(x, t)[1], share, seed < 4 ? 1e-4 : 0.05) << x << " " << t << " seed " << seed;
      }
    }
  }
}

TEST(Ribbon, AnyTurnIsTheSame) {
  const Ribbon ribbon = random_ribbon(3);
  EXPECT_NEAR(ribbon.density(1 + static_cast<float>(4 * pi), 0.1f), ribbon.density(1, 0.1f), 1e-5f);
}

TEST(Ribbon, StaysFiniteFarOut) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Ribbon ribbon = random_ribbon(seed, true);
    for (const float t : {-1e30f, -30.0f, 12.0f, 1e30f}) {
      for (int i = 0; i < 50; ++i) {
        const float x = -3.2f + 0.13f * static_cast<float>(i);
        const auto [u, v] = ribbon.cdf(x, t);
        EXPECT_TRUE(ribbon.density(x, t) >= 0 && std::isfinite(ribbon.density(x, t)));
        EXPECT_TRUE(u >= 0 && u <= 1 && v >= 0 && v <= 1) << u << " " << v;
      }
    }
    for (const float u : {0.0f, 0.5f, 0.99999994f}) {
      const Ribbon::Place place = ribbon.sample(u, 1 - u);
      EXPECT_TRUE(place.azimuth >= -std::numbers::pi_v<float> && place.azimuth < std::numbers::pi_v<float>);
      EXPECT_LE(std::abs(place.height), 30);
    }
  }
}

TEST(Ribbon, KnotsWithoutDensityAreTheUniformOne) {
  std::array<RibbonKnot, Ribbon::main_knots> main{};
  std::array<RibbonKnot, Ribbon::broad_knots> broad{};
  EXPECT_FLOAT_EQ(Ribbon(main, HeightLaw::normal, broad).density(1, 0.3f), Ribbon().density(1, 0.3f));
}

TEST(GammaDecay, GoesThroughBothMeans) {
  for (const float attribute : {0.01f, 0.5f, 2.0f, 8.0f, 30.0f}) {
    for (const float scale : {1e-3f, 0.05f, 0.7f, 5.0f, 300.0f}) {
      const auto law = [&](float rate) { return std::exp(-attribute / scale * std::log1p(rate * scale)); };
      const std::array<float, 2> decays{law(Ribbon::decay_rates[0]), law(Ribbon::decay_rates[1])};
      const GammaDecay decay = GammaDecay::from(decays);
      EXPECT_EQ(decay.at(0), 1);
      EXPECT_NEAR(decay.at(Ribbon::decay_rates[0]), decays[0], 1e-5f) << attribute << " " << scale;
      EXPECT_NEAR(decay.at(Ribbon::decay_rates[1]), decays[1], 1e-5f) << attribute << " " << scale;
      // A float near 1 says little of a law that takes little: of what is taken, 6e-8 is not seen.
      EXPECT_NEAR(decay.at(3), law(3), 1e-3f * std::min(1.0f, 1 / attribute) + 1e-5f) << attribute << " " << scale;
    }
  }
}

TEST(GammaDecay, TakesWhatNoLawHas) {
  for (const float first : {0.0f, 1e-30f, 0.3f, 0.999f, 1.0f}) {
    for (const float second : {0.0f, 1e-20f, 0.2f, 1.0f}) {
      const GammaDecay decay = GammaDecay::from({first, second});
      float before = 1;
      for (const float rate : {0.0f, 0.1f, 1.0f, 10.0f, 1e6f}) {
        const float kept = decay.at(rate);
        EXPECT_TRUE(kept >= 0 && kept <= before) << first << " " << second << " " << rate << ": " << kept;
        before = kept;
      }
    }
  }
  EXPECT_EQ(GammaDecay::from({1, 1}).at(5), 1);
  EXPECT_NEAR(GammaDecay::from({std::exp(-0.3f), std::exp(-1.8f)}).at(1), std::exp(-2.0f), 1e-3f);  // one attribute
}

RibbonRow row_of(std::uint64_t seed, bool rough) {
  return RibbonRow(std::vector<RibbonRow::Part>{
      {random_ribbon(seed, rough), 0.2f}, {random_ribbon(seed + 1, rough), 0}, {random_ribbon(seed + 2, rough), 0.7f}});
}

TEST(RibbonRow, KeepsWhatItPacks) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Ribbon ribbon = random_ribbon(seed);
    const Ribbon kept = RibbonRow(std::vector<RibbonRow::Part>{{ribbon, 0.5f}}).ribbon(0);
    EXPECT_EQ(kept.main_law(), ribbon.main_law());
    EXPECT_NEAR(kept.main_mass(), ribbon.main_mass(), 1e-5f);
    for (const auto& [was, is, mode, decay] : {std::tuple{ribbon.main(), kept.main(), 6e-4f, 0.009f},
                                               std::tuple{ribbon.broad(), kept.broad(), 0.04f, 0.018f}}) {
      for (std::size_t k = 0; k < was.size(); ++k) {
        EXPECT_NEAR(is[k].azimuth, was[k].azimuth, 5e-5f);
        EXPECT_NEAR(is[k].density, was[k].density, 0.04f * was[k].density + 1e-5f);
        EXPECT_NEAR(is[k].mode, was[k].mode, mode);  // half a step of asinh at 1
        EXPECT_NEAR(is[k].scale_below, was[k].scale_below, 0.015f * was[k].scale_below);
        EXPECT_NEAR(is[k].scale_above, was[k].scale_above, 0.015f * was[k].scale_above);
        // An attribute below 0.01 counts as 0.
        for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(is[k].decays[i], was[k].decays[i], decay);
      }
    }
  }
}

TEST(RibbonRow, PackingAgainChangesNothing) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const RibbonRow row = row_of(seed, seed % 2 == 1);
    std::vector<RibbonRow::Part> parts;
    for (std::uint32_t p = 0; p < row.parts(); ++p) parts.push_back({row.ribbon(p), row.mass(p)});
    EXPECT_EQ(RibbonRow(parts), row) << seed;
    RibbonRow read;
    ASSERT_TRUE(read.unpack(row.packed(), row.masses())) << seed;
    EXPECT_EQ(read, row);
  }
}

// Codes are chosen by a quick logarithm, and by that of the library where it could round elsewhere: a fingerprint of
// 600 rows that were packed by that of the library alone, and of what they decode to. Scales, modes and decays of every
// size.
TEST(RibbonRow, PacksToTheBytesThatItAlwaysHas) {
  RandomStream random(3, 3);
  std::uint64_t hash = 1469598103934665603u;
  const auto add = [&hash](std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes) hash = (hash ^ static_cast<std::uint64_t>(byte)) * 1099511628211u;
  };
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    const Ribbon drawn = random_ribbon(seed, seed % 2 == 1);
    std::array<RibbonKnot, Ribbon::main_knots> main;
    std::array<RibbonKnot, Ribbon::broad_knots> broad;
    std::ranges::copy(drawn.main(), main.begin());
    std::ranges::copy(drawn.broad(), broad.begin());
    for (RibbonKnot& knot : main) {
      knot.scale_below = 1e-3f + 0.899f * std::pow(random.next(), 6.0f);
      knot.mode = 12 * (2 * random.next() - 1) * std::pow(random.next(), 4.0f);
      knot.decays[0] = 1 - std::pow(random.next(), 6.0f);
      knot.decays[1] = knot.decays[0] * random.next();
      knot.density = std::pow(random.next(), 8.0f);
    }
    const RibbonRow row(std::vector<RibbonRow::Part>{{Ribbon(main, drawn.main_law(), broad), 0.5f}});
    add(row.packed());
    const Ribbon decoded = row.ribbon(0);
    add(std::as_bytes(decoded.main()));
    add(std::as_bytes(decoded.broad()));
  }
  EXPECT_EQ(hash, 2421315345978685172u);
}

TEST(RibbonRow, APartWithoutMassIsUniform) {
  const RibbonRow row = row_of(4, false);
  EXPECT_FLOAT_EQ(row.total_mass(), 0.9f);
  EXPECT_FLOAT_EQ(row.ribbon(1).density(2, 0.4f), Ribbon().density(2, 0.4f));
}

TEST(RibbonRow, RefusesDamage) {
  const RibbonRow row = row_of(8, false);
  RibbonRow read;
  std::vector<float> masses(row.masses().begin(), row.masses().end());
  EXPECT_FALSE(read.unpack(row.packed().first(300), masses));
  EXPECT_FALSE(read.unpack({}, {}));
  for (const float bad : {-1.0f, -0.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::max()}) {
    std::vector<float> damaged{bad, masses[1], bad};
    EXPECT_FALSE(read.unpack(row.packed(), damaged)) << bad;
  }
  EXPECT_FALSE(read.unpack(row.packed(), std::vector<float>(3, 0.0f)));
  EXPECT_EQ(read, RibbonRow());
  RandomStream random(5);
  int taken = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> bytes(row.packed().begin(), row.packed().end());
    bytes[random.next_bits() % bytes.size()] ^= static_cast<std::byte>(1u << (random.next_bits() % 8));
    if (!read.unpack(bytes, masses)) continue;
    ++taken;  // a row all the same: it answers finitely and packs to the same bytes
    std::vector<RibbonRow::Part> parts;
    for (std::uint32_t p = 0; p < read.parts(); ++p) parts.push_back({read.ribbon(p), read.mass(p)});
    ASSERT_EQ(RibbonRow(parts), read);
    ASSERT_TRUE(std::isfinite(read.ribbon(0).density(random.next(), 0.1f)));
  }
  EXPECT_GT(taken, 500);  // checksums are the file's affair
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
