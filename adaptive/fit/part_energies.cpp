#include "fit/part_energies.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "base/pi.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr float darkest = 1e-37f;
constexpr double least_decay = 1e-6, most_decay = 1 - 1e-6;  ///< an exponent is searched for between them
constexpr double largest_exponent = 16, near_enough = 1e-6;
constexpr int most_steps = 24;
constexpr std::size_t all_knots = Ribbon::main_knots + Ribbon::broad_knots;

/// A knot's share of the ribbon's light, and the logarithm of its decay.
struct Share {
  double light, log_decay;
};

void put_shares(std::span<const RibbonKnot> knots, std::size_t rate, std::span<Share> shares) {
  const auto gap = [&](std::size_t from, std::size_t to) {
    const double width = static_cast<double>(knots[to].azimuth) - static_cast<double>(knots[from].azimuth);
    return width < 0 ? width + two_pi : width;
  };
  double before = gap(knots.size() - 1, 0);
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const double after = gap(k, (k + 1) % knots.size());
    shares[k] = {0.5 * (before + after) * static_cast<double>(knots[k].density),
                 static_cast<double>(std::log(std::clamp(knots[k].decays[rate], darkest, 1.0f)))};
    before = after;
  }
}

void raise(std::span<RibbonKnot> knots, std::size_t rate, std::span<const Share> shares, double c) {
  for (std::size_t k = 0; k < knots.size(); ++k) {
    float& decay = knots[k].decays[rate];
    if (decay > 0) decay = std::exp(static_cast<float>(c * shares[k].log_decay));
  }
}

/// Finds c such that the sum of light e^(c log_decay) is `left` of all light. The logarithm of the sum falls with c and
/// is convex, so this uses Newton's method, kept within a bracket.
double exponent_for(std::span<const Share> shares, double left) {
  double all = 0;
  for (const Share& share : shares) all += share.light;
  const double wanted = std::log(std::clamp(left, least_decay, most_decay) * all);
  double low = 1 / largest_exponent, high = largest_exponent, c = 1;
  for (int i = 0; i < most_steps; ++i) {
    double sum = 0, slope = 0;
    for (const Share& share : shares) {
      const double kept = share.light * static_cast<double>(std::exp(static_cast<float>(c * share.log_decay)));
      sum += kept;
      slope += kept * share.log_decay;
    }
    const double off = std::log(std::max(sum, std::numeric_limits<double>::min())) - wanted;
    (off > 0 ? low : high) = c;
    double next = c - off * sum / slope;
    if (!(next > low && next < high)) next = std::sqrt(low * high);
    if (std::abs(next - c) < near_enough * c) return next;
    c = next;
  }
  return c;
}

}  // namespace

void PartEnergies::add(const RowExits& exits, std::uint64_t paths) {
  for (std::uint32_t p = 0; p < light_.size(); ++p) {
    light_[p].clear += exits.part[p].light;
    for (std::size_t r = 0; r < rates; ++r) light_[p].left[r] += exits.part[p].left[r];
  }
  paths_ += paths;
}

double PartEnergies::mass(std::uint32_t part) const { return light_[part].clear / static_cast<double>(paths_); }

double PartEnergies::total_mass() const {
  double mass = 0;
  for (const Light& light : light_) mass += light.clear;
  return mass / static_cast<double>(paths_);
}

bool PartEnergies::has_mass() const {
  const auto all = static_cast<float>(total_mass());
  return all > 0 && std::isfinite(all);
}

Ribbon PartEnergies::mended(const Ribbon& ribbon, std::uint32_t part) const {
  std::array<RibbonKnot, Ribbon::main_knots> main;
  std::array<RibbonKnot, Ribbon::broad_knots> broad;
  std::ranges::copy(ribbon.main(), main.begin());
  std::ranges::copy(ribbon.broad(), broad.begin());
  const Light& light = light_[part];
  for (std::size_t r = 0; r < rates; ++r) {
    std::array<Share, all_knots> shares;
    const auto of_main = std::span(shares).first<Ribbon::main_knots>();
    const auto of_broad = std::span(shares).last<Ribbon::broad_knots>();
    put_shares(main, r, of_main);
    put_shares(broad, r, of_broad);
    const double c = exponent_for(shares, light.left[r] / light.clear);
    raise(main, r, of_main, c);
    raise(broad, r, of_broad, c);
  }
  return Ribbon(main, ribbon.main_law(), broad);
}

}  // namespace tress::inline v0_2::adaptive
