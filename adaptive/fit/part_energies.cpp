#include "fit/part_energies.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace tress::adaptive {
namespace {

constexpr double least_decay = 1e-6, most_decay = 1 - 1e-6;  ///< between them an exponent is looked for
constexpr double largest_exponent = 16;

/// A knot's share of the ribbon's light, and the logarithm of what is left of it.
struct Share {
  double light, log_decay;
};

void add_shares(std::span<const RibbonKnot> knots, std::size_t rate, std::vector<Share>& shares) {
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const auto gap = [&](std::size_t from, std::size_t to) {
      const double width = static_cast<double>(knots[to].azimuth) - static_cast<double>(knots[from].azimuth);
      return width < 0 ? width + 2 * std::numbers::pi : width;
    };
    const double hat = 0.5 * (gap((k + knots.size() - 1) % knots.size(), k) + gap(k, (k + 1) % knots.size()));
    shares.push_back({hat * static_cast<double>(knots[k].density),
                      std::log(std::clamp(static_cast<double>(knots[k].decays[rate]), least_decay, 1.0))});
  }
}

/// c such that sum light e^(c log_decay) is `left` of all light: the sum falls with c.
double exponent_for(const std::vector<Share>& shares, double left) {
  double all = 0;
  for (const Share& share : shares) all += share.light;
  left = std::clamp(left, least_decay, most_decay);
  double low = 1 / largest_exponent, high = largest_exponent;
  for (int i = 0; i < 24; ++i) {
    const double c = std::sqrt(low * high);
    double sum = 0;
    for (const Share& share : shares) sum += share.light * std::exp(c * share.log_decay);
    (sum > left * all ? low : high) = c;
  }
  return std::sqrt(low * high);
}

}  // namespace

void PartEnergies::add(std::span<const SampledExit> exits, std::uint64_t paths) {
  for (const SampledExit& exit : exits) {
    Light& light = light_[exit.part];
    light.clear += static_cast<double>(exit.weight);
    for (std::size_t r = 0; r < rates; ++r)
      light.left[r] += static_cast<double>(exit.weight * std::exp(-Ribbon::decay_rates[r] * exit.attribute));
  }
  paths_ += paths;
}

double PartEnergies::mass(std::uint32_t part) const { return light_[part].clear / static_cast<double>(paths_); }

double PartEnergies::total_mass() const {
  double mass = 0;
  for (const Light& light : light_) mass += light.clear;
  return mass / static_cast<double>(paths_);
}

Ribbon PartEnergies::mended(const Ribbon& ribbon, std::uint32_t part) const {
  std::array<RibbonKnot, Ribbon::main_knots> main;
  std::array<RibbonKnot, Ribbon::broad_knots> broad;
  std::ranges::copy(ribbon.main(), main.begin());
  std::ranges::copy(ribbon.broad(), broad.begin());
  const Light& light = light_[part];
  for (std::size_t r = 0; r < rates; ++r) {
    std::vector<Share> shares;
    add_shares(main, r, shares);
    add_shares(broad, r, shares);
    const auto c = static_cast<float>(exponent_for(shares, light.left[r] / light.clear));
    for (RibbonKnot& knot : main) knot.decays[r] = std::pow(knot.decays[r], c);
    for (RibbonKnot& knot : broad) knot.decays[r] = std::pow(knot.decays[r], c);
  }
  return Ribbon(main, ribbon.main_law(), broad);
}

}  // namespace tress::adaptive
