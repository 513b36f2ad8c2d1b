// A mixture is finite and never negative, is the formula of ESTIMATOR.md E1 in doubles, has its energy as its mass,
// does not ask for the order of its components nor for the turn of an azimuth; as the table stores it, it is the same.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "density/mixture_store.h"
#include "properties/generators.h"
#include "support/mixture_formula.h"
#include "support/quadrature.h"

namespace tress::inline v0_2::adaptive {
namespace {

using std::numbers::pi;
// Of a float sum of nine products of a float density: exponential 3e-7, its argument of up to 87 rounded by 1.2e-7 of
// it.
constexpr double relative = 1.5e-5;

/// Where densities are hardest: the modes, their antipodes, both ends of the circle.
std::vector<float> azimuths_of(const Mixture& fit) {
  std::vector<float> at{0, -std::numbers::pi_v<float>, std::nextafter(std::numbers::pi_v<float>, 0.0f), 0.7f};
  for (const Component& part : fit.parts()) {
    const float mu = part.shape.mu;
    for (const float x : {mu, mu + part.shape.s_right, mu - 3 * part.shape.s_left, mu + 3.1415927f, mu - 3.1415925f}) {
      at.push_back(wrap_angle(x));
    }
  }
  return at;
}

/// The smallest and largest of E1 where each component may take the azimuth for one within `reach` radians of it: x -
/// mu is rounded for each by itself.
std::array<double, 2> range_of(const Mixture& fit, double at, double reach) {
  const double flat = static_cast<double>(fit.uniform_weight) / (2 * pi);
  std::array<double, 2> range{flat, flat};
  for (const Component& part : fit.parts()) {
    const double mu = part.shape.mu;
    std::vector<double> points{at - reach, at, at + reach};
    // Between those it has no extremum but at its mode and its antipode, where it may also jump.
    if (std::abs(std::remainder(at - mu, 2 * pi)) <= reach) points.push_back(mu);
    if (std::abs(std::remainder(at - mu - pi, 2 * pi)) <= reach) {
      points.push_back(mu + pi - 1e-12);
      points.push_back(mu + pi + 1e-12);
    }
    double least = std::numeric_limits<double>::infinity(), largest = 0;
    for (const double x : points) {
      least = std::min(least, test::density(part.shape, x));
      largest = std::max(largest, test::density(part.shape, x));
    }
    range = {range[0] + static_cast<double>(part.weight) * least,
             range[1] + static_cast<double>(part.weight) * largest};
  }
  return range;
}

bool within(float f, const std::array<double, 2>& range) {
  // exp_of_negative stops at exp(-87): what is below that of the largest density is not distinguished from it.
  return f >= range[0] * (1 - relative) - 1e-37 && f <= range[1] * (1 + relative) + 1e-33;
}

RC_GTEST_PROP(Mixture, IsFiniteNeverNegativeAndTheFormula, ()) {
  const Mixture fit = *common_mixture();
  for (const float x : azimuths_of(fit)) {
    const float f = fit.density(x);
    RC_ASSERT(std::isfinite(f) && f >= 0);
    // x - mu is rounded to a float, 2.4e-7 between 4 and 8, and once more when it is wrapped, 1.2e-7.
    RC_ASSERT(within(f, range_of(fit, x, 4e-7)));
  }
}

RC_GTEST_PROP(Mixture, OfAnythingThatAFileMayHoldIsFiniteAndNeverNegative, ()) {
  const Mixture fit = *any_mixture();
  for (const float x : azimuths_of(fit)) {
    RC_ASSERT(std::isfinite(fit.density(x)) && fit.density(x) >= 0);
    for (const float share : {0.0f, 0.02f, 0.05f}) {
      const float q = fit.proposal_density(x, share);
      RC_ASSERT(std::isfinite(q) && q >= share * 0.159154f);
      const float drawn = fit.sample(std::clamp((x + 3.1415927f) / 6.2831855f, 0.0f, 1 - 0x1p-24f), share);
      RC_ASSERT(drawn >= -std::numbers::pi_v<float> && drawn < std::numbers::pi_v<float>);
    }
  }
}

TRESS_DEAR_PROPERTY(Mixture, HasItsEnergyAsItsMass, 50) {
  const Mixture fit = *common_mixture();
  // Panels end where a density has a kink or a jump: at modes and antipodes; there are 4 panels a scale where it is
  // steep. Gauss-Legendre of 8 points errs by less than 1e-9 of such a panel, float azimuths and densities by
  // `relative` and, 2.4e-7 rad against a scale of 0.004, 6e-5 at random, so 2e-5 of the mass of a component.
  std::vector<double> ends{-pi, pi};
  for (const Component& part : fit.parts()) {
    for (const double side : {-static_cast<double>(part.shape.s_left), static_cast<double>(part.shape.s_right)}) {
      for (const double distance : {0.0, 1.0, 2.0, 4.0, 7.0, 12.0, 20.0}) {
        if (distance * std::abs(side) < pi) {
          ends.push_back(std::remainder(part.shape.mu + distance * side, 2 * pi));
        }
      }
    }
    ends.push_back(std::remainder(part.shape.mu + pi, 2 * pi));
  }
  std::ranges::sort(ends);
  double mass = 0;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    mass += test::integrate([&](double x) { return fit.density(static_cast<float>(x)); }, ends[i - 1], ends[i], 2);
  }
  RC_ASSERT(std::abs(mass - fit.energy()) <= 3e-5 * fit.energy());
}

RC_GTEST_PROP(Mixture, DoesNotAskForTheOrderOfItsComponents, ()) {
  const Mixture fit = *any_mixture();
  Mixture turned = fit;
  if (fit.component_count > 0) {
    const std::uint32_t by = (*any_numbers(1, 8))[0] % fit.component_count;
    std::ranges::rotate(turned.components.begin(), turned.components.begin() + by,
                        turned.components.begin() + fit.component_count);
  }
  RC_ASSERT(std::abs(turned.energy() - fit.energy()) <= 1e-6 * fit.energy());
  for (const float x : azimuths_of(fit)) {
    RC_ASSERT(std::abs(turned.density(x) - fit.density(x)) <= 1e-6 * fit.density(x));  // order of a sum of nine
  }
}

RC_GTEST_PROP(Mixture, IsPeriodic, ()) {
  const Mixture fit = *common_mixture();
  for (const float x : azimuths_of(fit)) {
    for (const int turns : {1, -1, 3, -20, 1000}) {
      const auto moved = static_cast<float>(x + 2 * pi * turns);
      // Rounded here and once more by x - mu, which is up to 4 further out.
      const double largest = std::abs(moved) + 4;
      const double reach = 4e-7 + static_cast<double>(0x1p-23f) * largest;
      RC_ASSERT(within(fit.density(moved), range_of(fit, x, reach)));
    }
  }
}

/// Bits of the mixture as they stand in a cache: to the bit, attributes included.
bool same(const Mixture& a, const Mixture& b, float attribute_slack) {
  const auto close = [&](float x, float y) { return std::abs(x - y) <= std::max(attribute_slack * y, 0x1p-134f); };
  bool equal = a.component_count == b.component_count && a.uniform_weight == b.uniform_weight &&
               close(a.uniform_attribute_mean, b.uniform_attribute_mean) &&
               close(a.uniform_attribute_variance, b.uniform_attribute_variance);
  for (std::size_t d = 0; equal && d < a.component_count; ++d) {
    const Component &x = a.components[d], &y = b.components[d];
    equal = x.shape.mu == y.shape.mu && x.shape.s_left == y.shape.s_left && x.shape.s_right == y.shape.s_right &&
            x.weight == y.weight && close(x.attribute_mean, y.attribute_mean) &&
            close(x.attribute_variance, y.attribute_variance);
  }
  return equal;
}

/// Not inlined, or g++ 12 sees an element before the first of a list that it knows to be empty.
[[gnu::noinline]] const PackedMixture& put(MixtureStore& store, const Mixture& fit) { return *store.put(fit, 0.25f); }

RC_GTEST_PROP(Mixture, PackedIsTheSameAndPackedAgainTheSameToTheBit, ()) {
  const Mixture fit = *any_mixture();
  MixtureStore store;
  const PackedMixture& packed = put(store, fit);
  const Mixture once = packed;
  const Mixture twice = put(store, once);
  RC_ASSERT(same(once, fit, 0x1p-9f));  // 8 bits behind the point, to the nearest
  RC_ASSERT(same(twice, once, 0));
  RC_ASSERT(packed.energy() == fit.energy());
  for (const float x : azimuths_of(fit)) {
    RC_ASSERT(packed.density(x) == fit.density(x));
    RC_ASSERT(packed.proposal_density(x, 0.02f) == fit.proposal_density(x, 0.02f));
    const float u = std::clamp((x + 3.1415927f) / 6.2831855f, 0.0f, 1 - 0x1p-24f);
    RC_ASSERT(packed.sample(u, 0.02f) == fit.sample(u, 0.02f));
  }
}

/// The store of a table against a plain list, whatever is put and given back in between.
RC_GTEST_PROP(Mixture, InTheStoreIsNotTouchedByOthers, ()) {
  struct Kept {
    const PackedMixture* packed;
    Mixture fit;
  };
  MixtureStore store;
  std::vector<Kept> kept;
  const Mixture fit = *any_mixture();
  for (const std::uint32_t choice : *any_numbers(60, 36)) {
    if (choice < 12 && !kept.empty()) {
      const std::size_t at = choice % kept.size();
      store.give_back(kept[at].packed);
      kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(at));
    } else {
      Mixture other = fit;
      other.component_count = choice % 9;
      other.uniform_weight = static_cast<float>(kept.size());
      kept.push_back({&put(store, other), other});
    }
    for (const Kept& one : kept) RC_ASSERT(same(Mixture(*one.packed), one.fit, 0x1p-9f));
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
