#include "fit/exit_columns.h"

#include <algorithm>
#include <numbers>

#include "fit/ribbon_kernels.h"
#include "tress/adaptive/mixture.h"

namespace tress::adaptive {
namespace {

constexpr float pi = std::numbers::pi_v<float>;

constexpr float farthest = 2 * Ribbon::largest_mode;  // beyond, no knot follows

std::uint32_t bin_of(float x) {
  const float at = (x + pi) * (static_cast<float>(ExitColumns::bins) / (2 * pi));
  return std::min(static_cast<std::uint32_t>(at), ExitColumns::bins - 1);
}

}  // namespace

double ExitColumns::azimuth(std::uint32_t bin) { return std::numbers::pi * (2 * static_cast<double>(bin) / bins - 1); }

ExitColumns sort_exits(std::span<const SampledExit> exits, std::uint32_t part) {
  ExitColumns columns;
  columns.begin.assign(ExitColumns::bins + 1, 0);
  std::vector<std::uint32_t> at(ExitColumns::bins, 0);
  for (const SampledExit& exit : exits) {
    if (exit.part == part) ++at[bin_of(wrap_angle(exit.azimuth))];
  }
  std::uint32_t before = 0;
  for (std::uint32_t bin = 0; bin < ExitColumns::bins; ++bin) {
    columns.begin[bin] = before;
    before += at[bin];
    at[bin] = columns.begin[bin];
  }
  columns.begin.back() = before;
  for (auto* column : {&columns.x, &columns.t, &columns.w, &columns.attribute}) {
    column->assign(before + ribbon_lanes, 0.0f);
  }
  for (const SampledExit& exit : exits) {
    if (exit.part != part) continue;
    const float x = wrap_angle(exit.azimuth);
    const std::uint32_t i = at[bin_of(x)]++;
    columns.x[i] = x;
    columns.t[i] = std::clamp(exit.height, -farthest, farthest);
    columns.w[i] = exit.weight;
    columns.attribute[i] = exit.attribute;
  }
  return columns;
}

}  // namespace tress::adaptive
