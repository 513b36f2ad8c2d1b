#include "fit/row_exits.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/pi.h"
#include "fit/exit_sums.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr float farthest = 2 * Ribbon::largest_mode;  // knots do not follow an exit beyond it

std::uint32_t bin_of(float x) {
  const float at = (x + pi_f) * (static_cast<float>(RowExits::bins) / (2 * pi_f));
  return std::min(static_cast<std::uint32_t>(at), RowExits::bins - 1);
}

/// Adds up a part and scales its weights.
void add_up(RowExits& exits, RowExits::Part& part) {
  double squares = 0;
  for (std::uint32_t i = part.begin.front(); i < part.begin.back(); ++i) {
    const double w = static_cast<double>(exits.w[i]);
    part.light += w;
    squares += w * w;
    for (std::size_t r = 0; r < RowExits::rates; ++r) part.left[r] += w * static_cast<double>(exits.decay[r][i]);
  }
  if (!(part.light > 0) || !(squares > 0)) return;
  part.count = part.light * part.light / squares;
  const double scale = part.count / part.light;
  for (std::uint32_t i = part.begin.front(); i < part.begin.back(); ++i) {
    exits.w[i] = static_cast<float>(scale * static_cast<double>(exits.w[i]));
  }
  part.directions = sum_of_directions(exits, part.begin.front(), part.begin.back());
  for (double& direction : part.directions) direction /= part.count;
}

}  // namespace

double RowExits::azimuth(std::uint32_t bin) { return pi * (2 * static_cast<double>(bin) / bins - 1); }

void sort_exits(std::span<const ExitSet> sets, std::uint32_t parts, RowExits& row) {
  const auto place_of = [](const SampledExit& exit) {
    return exit.part * RowExits::bins + bin_of(wrap_angle(exit.azimuth));
  };
  row.parts = parts;
  row.part = {};
  std::array<std::uint32_t, RowExits::most_parts * RowExits::bins> at{};
  for (const ExitSet& set : sets) {
    for (const SampledExit& exit : set.exits) ++at[place_of(exit)];
  }
  std::uint32_t before = 0;
  for (std::uint32_t p = 0; p < RowExits::most_parts; ++p) {
    for (std::uint32_t bin = 0; bin < RowExits::bins; ++bin) {
      row.part[p].begin[bin] = before;
      before += std::exchange(at[p * RowExits::bins + bin], before);
    }
    row.part[p].begin.back() = before;
  }
  for (auto* column : {&row.x, &row.t, &row.w, &row.decay[0], &row.decay[1]})
    column->resize(before + RowExits::padding);
  row.set.resize(before);
  for (std::size_t s = 0; s < sets.size(); ++s) {
    for (std::size_t j = 0; j < sets[s].exits.size(); ++j) {
      const SampledExit& exit = sets[s].exits[j];
      const std::uint32_t i = at[place_of(exit)]++;
      row.x[i] = wrap_angle(exit.azimuth);
      row.t[i] = std::clamp(exit.height, -farthest, farthest);
      row.w[i] = exit.weight;
      row.decay[1][i] = exit.attribute;
      row.set[i] = j < sets[s].taught ? RowExits::taught : static_cast<std::uint8_t>(s);
    }
  }
  write_decays(row.decay[1].data(), before, row.decay[0].data(), row.decay[1].data());
  for (RowExits::Part& part : row.part) add_up(row, part);
}

RowExits sort_exits(std::span<const SampledExit> exits, std::uint32_t parts) {
  RowExits row;
  const ExitSet all{exits};
  sort_exits({&all, 1}, parts, row);
  return row;
}

RowExits thin_exits(const RowExits& exits) {
  constexpr std::uint32_t many = 2048, every = 4;
  RowExits thin;
  thin.parts = exits.parts;
  for (auto* column : {&thin.x, &thin.t, &thin.w}) column->resize(exits.x.size());
  std::uint32_t size = 0;
  for (std::size_t p = 0; p < RowExits::most_parts; ++p) {
    const RowExits::Part& from = exits.part[p];
    RowExits::Part& to = thin.part[p];
    const std::uint32_t step = from.begin.back() - from.begin.front() >= many ? every : 1;
    std::uint32_t i = from.begin.front();
    for (std::uint32_t bin = 0; bin < RowExits::bins; ++bin) {
      to.begin[bin] = size;
      for (; i < from.begin[bin + 1]; i += step) {
        thin.x[size] = exits.x[i];
        thin.t[size] = exits.t[i];
        thin.w[size++] = exits.w[i];
        to.count += static_cast<double>(exits.w[i]);
      }
    }
    to.begin.back() = size;
  }
  for (auto* column : {&thin.x, &thin.t, &thin.w}) column->resize(size + RowExits::padding, 0.0f);
  return thin;
}

}  // namespace tress::inline v0_2::adaptive
