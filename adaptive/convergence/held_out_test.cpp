#include "convergence/held_out_test.h"

#include <algorithm>
#include <cmath>

#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// Degrees of freedom that a cell's variance borrows from the other cells of its part, beside the three of its own
/// sets. The sets alone say almost nothing about a cell that few exits meet.
constexpr double pooled_freedom = 9;

constexpr std::size_t whole_blocks(std::size_t n) { return (n + 15) / 16 * 16; }

}  // namespace

HeldOutTest::HeldOutTest(const RibbonRow& row) {
  for (std::uint32_t p = 0; p < row.parts(); ++p) mass_ += static_cast<double>(row.mass(p));
  for (std::uint32_t p = 0; p < row.parts(); ++p) {
    tables_.set(p, row.ribbon(p));
    expected_.push_back(std::max(static_cast<double>(row.mass(p)), least_share * mass_) / cells);
  }
  for (std::vector<double>& of_set : observed_) of_set.assign(row.parts() * cells, 0.0);
}

void HeldOutTest::add(std::size_t set, std::span<const SampledExit> exits) {
  std::array<float, at_once> x{}, t{};
  std::array<std::int32_t, at_once> part{}, cell;
  for (std::size_t first = 0; first < exits.size(); first += at_once) {
    const std::size_t n = std::min(at_once, exits.size() - first);
    for (std::size_t i = 0; i < n; ++i) {
      const SampledExit& exit = exits[first + i];
      x[i] = wrap_angle(exit.azimuth);
      t[i] = exit.height;
      part[i] = static_cast<std::int32_t>(exit.part);
    }
    find_cells(tables_, cells_u, cells_v, whole_blocks(n), x.data(), t.data(), part.data(), cell.data());
    for (std::size_t i = 0; i < n; ++i) {
      observed_[set][static_cast<std::size_t>(cell[i])] += static_cast<double>(exits[first + i].weight);
    }
  }
}

void HeldOutTest::add(std::uint32_t part, const Columns& exits) {
  std::array<std::int32_t, at_once> parts, cell;
  parts.fill(static_cast<std::int32_t>(part));
  std::array<std::array<double, cells>, sets + 1> found{};  // the last is left out
  for (std::size_t first = 0; first < exits.azimuth.size(); first += at_once) {
    const std::size_t n = std::min(at_once, exits.azimuth.size() - first);
    find_cells(tables_, cells_u, cells_v, whole_blocks(n), exits.azimuth.data() + first, exits.height.data() + first,
               parts.data(), cell.data());
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t set = std::min<std::size_t>(exits.set[first + i], sets);
      found[set][static_cast<std::size_t>(cell[i]) - part * cells] += static_cast<double>(exits.weight[first + i]);
    }
  }
  for (std::size_t set = 0; set < sets; ++set) {
    for (std::size_t i = 0; i < cells; ++i) observed_[set][part * cells + i] += exits.unit * found[set][i];
  }
}

HeldOutCells HeldOutTest::found(std::uint32_t paths) const {
  HeldOutCells found{expected_, mass_, static_cast<double>(paths), observed_};
  for (std::vector<double>& of_set : found.observed) {
    for (double& light : of_set) light /= found.paths;
  }
  return found;
}

void HeldOutCells::add(const HeldOutCells& other) {
  const double all = paths + other.paths, before = mass > 0 ? paths / all / mass : 0,
               after = other.paths / all / other.mass;
  const auto join = [&](std::vector<double>& to, const std::vector<double>& from) {
    to.resize(std::max(to.size(), from.size()), 0.0);
    for (double& x : to) x *= before;
    for (std::size_t i = 0; i < from.size(); ++i) to[i] += after * from[i];
  };
  join(expected, other.expected);
  for (std::size_t s = 0; s < sets; ++s) join(observed[s], other.observed[s]);
  paths = all;
  mass = 1;
}

SampledTest HeldOutCells::result() const {
  // Let one cell have the mean m over the sets and the variance v. The mean of the products of two sets is then
  // m^2 - v/sets, with the variance 4 m^2 v/sets + 2 v^2/(sets (sets - 1)) for the true m and v.
  constexpr double n = sets, own_freedom = n - 1, freedom = own_freedom + pooled_freedom;
  constexpr double square_of_own = 1 + 2 * own_freedom / (freedom * freedom);  // mean of v^2 over its true value
  struct Cell {
    double mean, variance;
  };
  std::vector<Cell> found(observed[0].size());
  std::vector<double> variance(expected.size(), 0.0), light = variance;  // by part
  for (std::size_t cell = 0; cell < found.size(); ++cell) {
    const std::size_t part = cell / cells;
    double mean = 0, squares = 0;
    for (const std::vector<double>& of_set : observed) mean += of_set[cell] / n;
    for (const std::vector<double>& of_set : observed) {
      const double d = of_set[cell] - mean;
      squares += d * d;
    }
    found[cell] = {mean, squares / own_freedom};
    variance[part] += found[cell].variance;
    light[part] += mean;
  }
  double sum = 0, brighter = 0, of_misfit = 0, of_noise = 0;
  for (std::size_t cell = 0; cell < found.size(); ++cell) {
    const std::size_t part = cell / cells;
    const double light_expected = expected[part], per_mass = 1 / (light_expected * mass);
    if (!(light_expected > 0)) continue;
    const auto [mean, v] = found[cell];
    const double off = mean - light_expected, square = (off * off - v / n) * per_mass;
    // Variance is proportional to light, found or expected. The product of both estimates has no bias where the row is
    // right; where it is not, the misfit's share is larger.
    const double per_light = light[part] > 0 ? pooled_freedom * variance[part] / light[part] : 0;
    const double by_found = (own_freedom * v + per_light * mean) / freedom,
                 by_expected = (own_freedom * v + per_light * light_expected) / freedom;
    sum += square;
    brighter += off / mass;
    of_misfit += 4 * square * by_found / n * per_mass;
    of_noise += 2 * by_found * by_expected / (square_of_own * n * (n - 1)) * per_mass * per_mass;
  }
  // Cells share the paths: the contribution of a path to the sum has this mean, whose square is not variance. The
  // estimate of a squared error has no bias, nor has its sum over cells; only that sum is held at 0 or above.
  of_misfit -= 4 * (sum + brighter) * (sum + brighter) / (n * paths);
  return {sum, std::sqrt(std::max(of_misfit, 0.0) + of_noise)};
}

}  // namespace tress::inline v0_2::adaptive
