// The value of S towards a direction by one path, against histograms of whole paths. Seeds are fixed; the chance that
// right code fails is said at each test.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "fiber/fiber3d_reference.h"
#include "fiber/rough_fiber.h"
#include "support/scale.h"
#include "support/seed.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberParameters;
using fiber::RoughFiber;

constexpr float pi = std::numbers::pi_v<float>, degree = pi / 180;
constexpr std::size_t thetas = 3, phis = 4, bins = thetas * phis, orders = 5, channels = 2;
template <class T>
using Table = std::array<std::array<std::array<T, channels>, orders>, bins>;

std::size_t bin_of(const FiberDirection& w) {
  const auto theta = static_cast<int>((w.theta / pi + 0.5f) * thetas),
             phi = static_cast<int>((w.phi + pi) / (2 * pi) * phis);
  return static_cast<std::size_t>(std::clamp(theta, 0, static_cast<int>(thetas) - 1)) * phis +
         static_cast<std::size_t>(std::clamp(phi, 0, static_cast<int>(phis) - 1));
}

RoughFiber::FacetNumbers facets(RandomStream& random) {
  RoughFiber::FacetNumbers u;
  for (auto& pair : u) pair = {random.next(), random.next()};
  return u;
}

/// Draws directions about where whole paths have gone: by their histogram, an eighth of them by the uniform law.
class Proposal {
 public:
  void add(const FiberDirection& w) { ++counts_[cell_of(w)]; }
  void finish() {
    double sum = 0, all = 0;
    for (const int count : counts_) all += count;
    for (std::size_t i = 0; i < cells; ++i) {
      share_[i] = 0.125 / cells + 0.875 * counts_[i] / all;
      upper_[i] = sum += share_[i];
    }
  }
  FiberDirection draw(RandomStream& random) const {
    const auto found = std::ranges::upper_bound(upper_, static_cast<double>(random.next()));
    const auto i = std::min(static_cast<std::size_t>(found - upper_.begin()), cells - 1);
    return {pi * ((static_cast<float>(i / across) + random.next()) / down - 0.5f),
            pi * (2 * (static_cast<float>(i % across) + random.next()) / across - 1)};
  }
  /// Density in dtheta dphi.
  float density(const FiberDirection& w) const {
    return static_cast<float>(share_[cell_of(w)] * cells) / (2 * pi * pi);
  }

 private:
  static constexpr std::size_t down = 36, across = 36, cells = down * across;
  static std::size_t cell_of(const FiberDirection& w) {
    const auto theta = static_cast<std::size_t>(std::clamp((w.theta / pi + 0.5f) * down, 0.0f, down - 1.0f));
    const auto phi = static_cast<std::size_t>(std::clamp((w.phi + pi) / (2 * pi) * across, 0.0f, across - 1.0f));
    return theta * across + phi;
  }
  std::array<int, cells> counts_{};
  std::array<double, cells> share_{}, upper_{};
};

fiber::RoughExit whole_path(const RoughFiber& rough, const FiberDirection& wr, float h, RandomStream& random) {
  const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
  return rough.trace(rough.entry(wr, h), u, random);
}

/// Sums over many samples of which each adds to one bin: mean over all samples and its standard error.
struct Sums {
  Table<double> sum{}, square{};
  int samples = 0;

  void add(std::size_t bin, std::size_t order, const glm::vec3& value) {
    for (std::size_t c = 0; c < channels; ++c) {
      const auto x = static_cast<double>(value[static_cast<int>(c)]);
      sum[bin][order][c] += x;
      square[bin][order][c] += x * x;
    }
  }
  double mean(std::size_t b, std::size_t p, std::size_t c) const { return sum[b][p][c] / samples; }
  double variance(std::size_t b, std::size_t p, std::size_t c) const {
    return std::max(square[b][p][c] / samples - mean(b, p, c) * mean(b, p, c), 0.0) / samples;
  }
};

// Bins of 60 x 90 degrees by order and color, wi drawn about where light goes. Values have long tails: ways of light
// that are rare and bright where they are. Compared are bins that 1,500 whole paths or more have met, of late orders
// where alpha is 0.3 or more: some 320, half of them independent, within 5.5 standard errors of both (normal values:
// 2e-5) and a mean square deviation, in standard errors, within 0.6 and 1.5 (5e-4). Six seeds, with 200,000 paths,
// had 4.2 at most and 0.87 to 1.13: tails are taken into account by a rate of 1e-3 for all. Of wet fibers R alone is
// compared: what the film's outer surface lets out is as narrow as at an alpha of 0.05, and of 120,000 directions next
// to none meets it.
TEST(rough_estimate_statistics, its_mean_is_what_whole_paths_give) {
  struct Cell {
    float eccentricity, alpha, tilt_deg, theta_deg;
    fiber::TracedParts parts{};
  };
  std::vector<Cell> cells;
  int turn = 0;
  for (const float e : {0.5f, 0.85f}) {
    for (const float alpha : {0.1f, 0.2f, 0.3f}) {
      for (const float tilt : {0.0f, 3.0f}) {
        cells.push_back({e, alpha, tilt, std::array{30.0f, -60.0f, 0.0f, 80.0f, -20.0f}[turn++ % 5]});
      }
    }
  }
  cells.push_back({1, 1, 3, -40});
  cells.push_back({0.85f, 0.2f, 3, 30, {0.7f, 4, 0.4f, 0.3f}});
  cells.push_back({0.75f, 0.3f, 3, -20, {0.4f, 4, 0.4f, 0.3f, 0.8f, 0.3f}});
  cells.push_back({0.75f, 0.3f, 3, -20, {0, 0, 0, 0, 0.5f, 0.3f, 0.6f}});
  const int least_count = test::scaled(1500);
  double squares = 0;
  int compared = 0;
  for (const Cell& cell : cells) {
    FiberParameters parameters;
    parameters.eccentricity = cell.eccentricity;
    parameters.roughness = cell.alpha;
    parameters.tilt = cell.tilt_deg * degree;
    parameters.sigma_a = {0, 0.25f, 0.25f};
    cell.parts.give_to(parameters);
    const RoughFiber rough(parameters);
    const FiberDirection wr{cell.theta_deg * degree, 0.6f};
    RandomStream random(test::seed(51), static_cast<std::uint64_t>(&cell - cells.data()));
    Sums whole, estimated;
    Table<int> counts{};
    Proposal proposal;
    whole.samples = test::scaled(120000);
    estimated.samples = test::scaled(120000);
    for (int i = 0; i < whole.samples; ++i) {
      const fiber::RoughExit exit = whole_path(rough, wr, 2 * random.next() - 1, random);
      const std::size_t bin = bin_of(exit.angles()), order = static_cast<std::size_t>(std::min(exit.order, 4));
      whole.add(bin, order, exit.throughput);
      proposal.add(exit.angles());
      for (std::size_t c = 0; c < channels; ++c) counts[bin][order][c] += exit.throughput[static_cast<int>(c)] > 0;
    }
    proposal.finish();
    for (int i = 0; i < estimated.samples; ++i) {
      const FiberDirection wi = proposal.draw(random);
      const auto s = rough.estimate(rough.entry(wr, 2 * random.next() - 1), wi, facets(random), random);
      for (std::size_t p = 0; p < orders; ++p) {
        for (int c = 0; c < 3; ++c) ASSERT_TRUE(s[p][c] >= 0 && std::isfinite(s[p][c]));
        estimated.add(bin_of(wi), p, s[p] / proposal.density(wi));
      }
    }
    double largest = 0, sum = 0;
    int of_cell = 0;
    for (std::size_t b = 0; b < bins; ++b) {
      for (std::size_t p = 0; p < orders; ++p) {
        for (std::size_t c = 0; c < channels; ++c) {
          if (counts[b][p][c] < least_count || (p > 2 && cell.alpha < 0.25f)) continue;
          if (p > 0 && cell.parts.wetness > 0) continue;
          const double error = std::sqrt(whole.variance(b, p, c) + estimated.variance(b, p, c));
          const double z = (estimated.mean(b, p, c) - whole.mean(b, p, c)) / error;
          largest = std::max(largest, std::abs(z));
          sum += z * z;
          ++of_cell;
          EXPECT_LT(std::abs(z), 5.5) << "e " << cell.eccentricity << " alpha " << cell.alpha << " tilt "
                                      << cell.tilt_deg << " bin " << b << " order " << p << " channel " << c << ": "
                                      << estimated.mean(b, p, c) << ", whole paths " << whole.mean(b, p, c);
        }
      }
    }
    squares += sum;
    compared += of_cell;
    std::printf("e %.2f alpha %.1f tilt %.0f theta %3.0f: %d bins, mean square deviation %.3f, largest %.2f\n",
                static_cast<double>(cell.eccentricity), static_cast<double>(cell.alpha),
                static_cast<double>(cell.tilt_deg), static_cast<double>(cell.theta_deg), of_cell, sum / of_cell,
                largest);
  }
  std::printf("%d bins, mean square deviation %.3f\n", compared, squares / compared);
  EXPECT_GT(squares / compared, 0.6);
  EXPECT_LT(squares / compared, 1.5);
}

// What one value is worth as a light sample: its variance over S^2, of brown fibers and at directions drawn by S. The
// median of 200 directions: 13, 6 and 4 for alpha 0.1, 0.2 and 0.3. Bounds: with three quarters more, six standard
// errors of such a median.
TEST(rough_estimate_statistics, its_variance_is_small_where_fibers_are_rough) {
  constexpr std::size_t directions = 200;
  const int paths = test::scaled(1000);
  for (const auto& [alpha, bound] : {std::pair{0.1f, 23.0}, std::pair{0.2f, 10.5}, std::pair{0.3f, 7.0}}) {
    FiberParameters parameters;
    parameters.roughness = alpha;
    parameters.sigma_a = glm::vec3(0.5f);
    const RoughFiber rough(parameters);
    const FiberDirection wr{0, 0.6f};
    RandomStream random(test::seed(52));
    std::vector<double> relative;
    while (relative.size() < directions) {
      const fiber::RoughExit exit = whole_path(rough, wr, 2 * random.next() - 1, random);
      if (random.next() >= exit.throughput.g) continue;
      test::SampleMean mean, square;
      for (int i = 0; i < paths; ++i) {
        double sum = 0;
        for (const glm::vec3& s :
             rough.estimate(rough.entry(wr, 2 * random.next() - 1), exit.angles(), facets(random), random)) {
          sum += static_cast<double>(s.g);
        }
        mean.add(sum);
        square.add(sum * sum);
      }
      relative.push_back(square.mean() / mean.mean() / mean.mean() - 1);
    }
    std::ranges::sort(relative);
    std::printf("alpha %.1f: variance over S^2, median %.1f, 90 %% %.1f\n", static_cast<double>(alpha),
                relative[directions / 2], relative[directions * 9 / 10]);
    EXPECT_LT(relative[directions / 2], bound) << alpha;
  }
}

}  // namespace
}  // namespace tress
