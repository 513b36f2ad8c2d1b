// Exits fall into the cells that the distribution functions of their ribbons say.
#include "convergence/exit_cells.h"

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

// (u, v) of the scalar functions, errors of floats alike: 1e-5 of a cell's borders either cell is right. Many places of
// the row, and where nothing is left of it.
TEST(ExitCells, AreThoseOfTheDistributionFunctions) {
  constexpr std::int32_t us = 64, vs = 32;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    CellTables tables;
    std::array<Ribbon, 4> ribbons;
    for (std::uint32_t p = 0; p < 4; ++p) {
      // As decoded: broad knots where packing has them.
      ribbons[p] = RibbonRow(std::vector<RibbonRow::Part>{{random_ribbon(4 * seed + p, seed >= 8), 1.0f}}).ribbon(0);
      tables.set(p, ribbons[p]);
    }
    RandomStream random(seed, 3);
    std::vector<float> x(4096), t(4096);
    std::vector<std::int32_t> part(4096), cell(4096);
    for (std::size_t i = 0; i < x.size(); ++i) {
      part[i] = static_cast<std::int32_t>(random.next_bits() % 4);
      const float u = random.next();
      const auto place = ribbons[static_cast<std::size_t>(part[i])].sample(u, random.next());
      x[i] = i % 5 == 0 ? wrap_angle(6.2831853f * random.next()) : place.azimuth;
      t[i] = i % 7 == 0 ? 60 * (2 * random.next() - 1) : i % 101 == 0 ? 1e30f : place.height;
    }
    x[0] = -std::numbers::pi_v<float>;
    x[1] = std::nextafter(std::numbers::pi_v<float>, 0.0f);
    find_cells(tables, us, vs, x.size(), x.data(), t.data(), part.data(), cell.data());
    int elsewhere = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const auto [u, v] = ribbons[static_cast<std::size_t>(part[i])].cdf(x[i], t[i]);
      const std::int32_t in_part = cell[i] - part[i] * us * vs;
      ASSERT_TRUE(in_part >= 0 && in_part < us * vs) << seed << " " << i;
      const auto off = [](float share, std::int32_t cells, std::int32_t at) {
        const float place = share * static_cast<float>(cells);
        return std::max({static_cast<float>(at) - place, place - static_cast<float>(at + 1), 0.0f});
      };
      // A knot's scale of 0.001 beside one of 0.9 makes v steep in x: rough ribbons may differ by a float's step of x.
      const bool is_off = off(u, us, in_part / vs) > 1e-3f || off(v, vs, in_part % vs) > 1e-3f;
      elsewhere += is_off ? 1 : 0;
      EXPECT_FALSE(seed < 8 && is_off) << seed << " at " << x[i] << " " << t[i] << ": " << u << " " << v;
    }
    EXPECT_LE(elsewhere, 8) << seed;
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
