#include "fit/absorbed_error.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/pi.h"
#include "fit/known_error.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::size_t most_rates = 4;
constexpr std::uint64_t rows_a_measured = 8;
constexpr double darkest = 69;     // exp(-69) = 1e-30
constexpr double flattest = 1e-6;  // in E^2/(2 pi), of which rounding of floats is 1e-10

/// The light that absorption leaves, in units of the share that is left of the least absorbed ray. The relative error
/// does not depend on that scale, and the values fit into floats at any rate.
struct Absorption {
  double rate, least;
  float of_ray(float weight, float attribute) const {
    return static_cast<float>(weight * std::exp(-rate * (static_cast<double>(attribute) - least)));
  }
  float of_part(float weight, float mean, float variance) const {
    return static_cast<float>(weight * decayed_share(rate, mean, variance) * std::exp(rate * least));
  }
};

std::optional<Absorption> absorption_of(const TracedNodes& nodes, float rate) {
  if (nodes.size() == 0) return std::nullopt;
  const double least = std::ranges::min(nodes.attribute());
  if (rate * least > darkest) return std::nullopt;
  return Absorption{rate, least};
}

TracedNodes absorbed(const TracedNodes& nodes, const Absorption& absorption) {
  std::vector<TracedRay> rays(nodes.size());
  for (std::size_t j = 0; j < rays.size(); ++j) {
    const float attribute = nodes.attribute()[j];
    rays[j] = {nodes.azimuth()[j], absorption.of_ray(nodes.weight()[j], attribute), attribute};
  }
  return TracedNodes(rays, nodes.blur_rad());
}

/// The same as TracedNodes::variation(), whose lower bound is for rows without absorption.
double own_variation(const TracedNodes& nodes) {
  const double energy = nodes.energy(), mean = energy / two_pi;
  double sum = 0;
  for (const float g : nodes.grid()) sum += (g - mean) * (g - mean);
  return std::max(sum * two_pi / static_cast<double>(nodes.grid().size()), flattest * energy * energy / two_pi);
}

}  // namespace

std::vector<float> representative_rates(std::span<const float> rates) {
  if (rates.size() <= most_rates) return {rates.begin(), rates.end()};
  std::vector<float> chosen;
  for (std::size_t i = 0; i < most_rates; ++i) chosen.push_back(rates[i * (rates.size() - 1) / (most_rates - 1)]);
  return chosen;
}

bool stands_for_others(const SliceKey& slice, std::uint32_t node) {
  std::uint64_t mixed = mix_bits(slice.lobe);
  for (const float parameter : slice.used_parameters(SliceKey::usual_parameters))
    mixed = mix_bits(mixed) ^ std::bit_cast<std::uint32_t>(parameter + 0.0f);
  return mix_bits(mixed ^ std::uint64_t{node} << 32) % rows_a_measured == 0;
}

std::optional<double> absorbed_error(const Mixture& fit, const TracedNodes& nodes, float rate) {
  const std::optional<Absorption> absorption = absorption_of(nodes, rate);
  if (!absorption) return std::nullopt;
  Mixture colored = fit;
  for (std::size_t d = 0; d < fit.component_count; ++d) {
    Component& part = colored.components[d];
    part.weight = absorption->of_part(part.weight, part.attribute_mean, part.attribute_variance);
  }
  colored.uniform_weight =
      absorption->of_part(fit.uniform_weight, fit.uniform_attribute_mean, fit.uniform_attribute_variance);
  const TracedNodes target = absorbed(nodes, *absorption);
  return known_error(colored, target, target.grid()).seen * target.variation() / own_variation(target);
}

}  // namespace tress::inline v0_2::adaptive
