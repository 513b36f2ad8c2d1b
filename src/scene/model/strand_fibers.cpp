#include "scene/model/strand_fibers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scene/model/parameters.h"
#include "tress/base/random.h"
#include "tress/fiber/lock_color.h"
#include "tress/fiber/parameter_ranges.h"
#include "tress/fiber/principled_hair.h"

namespace tress::scene {
namespace {

constexpr double degree = std::numbers::pi / 180;
/// Absorptions of a file below it are 0 or this.
constexpr double least_absorption = 0.01;
/// Steps of a file's colors become coarser, up to this, until the distinct fibers are few enough.
constexpr double largest_color_ratio = 5;
/// A node's widths vary by whole steps of this.
constexpr double width_step = 0.05;
constexpr int as_given = std::numeric_limits<int>::min(), clear = as_given + 1;

/// What tells the fibers of one material apart: whole numbers, as_given where the material does not vary.
struct FiberKey {
  std::uint32_t material = 0;
  int eccentricity_percent = as_given, roughness_deg = as_given, width_steps = as_given;
  std::array<int, 3> sigma_deg{as_given, as_given, as_given};
  std::array<int, 3> color_power{as_given, as_given, as_given};

  friend auto operator<=>(const FiberKey&, const FiberKey&) = default;
};

std::uint64_t hash_of(const std::string& name) {
  std::uint64_t hash = 0;
  for (const unsigned char c : name) hash = mix_bits(hash ^ (c + 0x9e3779b97f4a7c15ull));
  return hash;
}

/// x (1 + half_range y), y uniform in [-1, 1).
double varied(double x, double half_range, RandomStream& random) {
  return x * (1 + half_range * (2 * double{random.next()} - 1));
}

/// The seven numbers of a strand are drawn whatever varies, so that one variation does not change another.
FiberKey key_of(const Scene& scene, const Groom& groom, std::uint32_t strand, double ratio) {
  const Material& material = scene.materials[groom.material];
  const StrandVariation& variation = material.variation;
  const fiber::FiberParameters& fiber = material.fiber;
  RandomStream random(variation.seed, hash_of(material.name), strand);
  FiberKey key;
  key.material = groom.material;

  const double eccentricity = fiber.eccentricity + variation.eccentricity * (2 * double{random.next()} - 1);
  const auto percent = static_cast<int>(round_stochastically(100 * eccentricity, random.next()));
  if (variation.eccentricity > 0) key.eccentricity_percent = percent;

  const double width = varied(1, variation.width, random), width_u = random.next(), sigma_u = random.next();
  if (variation.width > 0 && material.has_node_widths) {
    key.width_steps = static_cast<int>(round_stochastically(width / width_step, width_u));
  } else if (variation.width > 0) {
    key.roughness_deg = static_cast<int>(round_stochastically(fiber.roughness * width / degree, width_u));
    fiber::FiberParameters rounded = fiber;
    rounded.roughness = static_cast<float>(key.roughness_deg * degree);
    const auto sigmas = fiber::azimuthal_sigmas(rounded);
    for (std::size_t i = 0; i < 3; ++i) {
      const double sigma = fiber.azimuthal_sigma[i] ? *fiber.azimuthal_sigma[i] * width : double{sigmas[i]};
      key.sigma_deg[i] = static_cast<int>(round_stochastically(std::round(1e4 * sigma / degree) / 1e4, sigma_u));
    }
  }

  const double factor = varied(1, variation.color, random), color_u = random.next();
  if (material.color_from_file) {
    if (groom.color.empty()) return key;
    const glm::vec3 sigma_a = material.principled_roughness ? fiber::sigma_a_of_principled_color(
                                                                  groom.color[strand], *material.principled_roughness)
                                                            : fiber::sigma_a_of_lock(groom.color[strand], fiber);
    for (std::size_t c = 0; c < 3; ++c) {
      const double x = sigma_a[static_cast<int>(c)] * factor / least_absorption;
      key.color_power[c] = x >= 1 ? static_cast<int>(round_to_power(x, ratio, color_u)) : color_u < x ? 0 : clear;
    }
  } else if (variation.color > 0) {
    key.color_power.fill(static_cast<int>(round_to_power(factor, ratio, color_u)));
  }
  return key;
}

/// All widths of a node's fiber times the factor.
void widen(double factor, fiber::FiberParameters* fiber) {
  const auto scale = [factor](float& width, const fiber::ParameterRange& degrees) {
    width = static_cast<float>(std::clamp(factor * width, degrees.least * degree, degrees.most * degree));
  };
  for (auto& lambda : fiber->longitudinal_lambda) scale(*lambda, fiber::longitudinal_lambda_range_deg);
  for (auto& sigma : fiber->azimuthal_sigma) scale(*sigma, fiber::azimuthal_sigma_range_deg);
  if (!fiber->published_widths) return;
  for (float& lambda : fiber->published_widths->longitudinal_lambda)
    scale(lambda, fiber::longitudinal_lambda_range_deg);
  for (float& sigma : fiber->published_widths->azimuthal_sigma) scale(sigma, fiber::azimuthal_sigma_range_deg);
}

fiber::FiberParameters fiber_of(const Scene& scene, const FiberKey& key, bool from_file, double ratio) {
  fiber::FiberParameters fiber = scene.materials[key.material].fiber;
  if (key.eccentricity_percent != as_given)
    fiber.eccentricity = std::clamp(static_cast<float>(key.eccentricity_percent) / 100, 0.5f, 1.0f);
  if (key.roughness_deg != as_given) {
    const double roughness = std::clamp(key.roughness_deg * degree, 0.01, 1.0);
    for (auto& lambda : fiber.longitudinal_lambda)
      if (lambda) *lambda *= static_cast<float>(roughness / fiber.roughness);
    fiber.roughness = static_cast<float>(roughness);
    for (std::size_t i = 0; i < 3; ++i)
      fiber.azimuthal_sigma[i] = static_cast<float>(std::clamp(key.sigma_deg[i], 1, 45) * degree);
  }
  if (key.width_steps != as_given) widen(key.width_steps * width_step, &fiber);
  for (std::size_t c = 0; c < 3; ++c) {
    const int power = key.color_power[c];
    if (power == as_given) continue;
    float& sigma_a = fiber.sigma_a[static_cast<int>(c)];
    sigma_a =
        power == clear ? 0.0f : static_cast<float>((from_file ? least_absorption : sigma_a) * std::pow(ratio, power));
  }
  return fiber;
}

/// Whether every varied value stays where its parameter may be.
std::optional<Error> check(const Scene& scene, std::size_t index) {
  const Material& material = scene.materials[index];
  const StrandVariation& variation = material.variation;
  const fiber::FiberParameters& fiber = material.fiber;
  const auto wrong = [&](const char* key, std::string expected, std::string found) {
    return Error{scene.source, fmt::format("/materials/{}/variation/{}", index, key), std::move(expected),
                 std::move(found)};
  };
  constexpr double rounding = 1e-6;
  const double low_e = double{fiber.eccentricity} - variation.eccentricity + rounding,
               high_e = double{fiber.eccentricity} + variation.eccentricity - rounding;
  if (variation.eccentricity > 0 && (low_e < 0.5 || high_e > 1))
    return wrong("eccentricity", "eccentricities within " + words(*parameter_at("/materials/0/eccentricity")),
                 fmt::format("{:.4g}..{:.4g}", low_e, high_e));
  if (!(variation.width > 0) || material.has_node_widths) return std::nullopt;
  double narrowest = fiber.roughness / degree / 2, widest = 0;
  for (const auto& sigma : fiber.azimuthal_sigma) {
    if (!sigma) continue;
    narrowest = std::min(narrowest, *sigma / degree);
    widest = std::max(widest, *sigma / degree);
  }
  narrowest *= 1 - variation.width;
  widest *= 1 + variation.width;
  if (narrowest < 1 - rounding || widest > 45 + rounding)
    return wrong("width", "azimuthal sigmas within 1..45 degrees",
                 fmt::format("{:.4g}..{:.4g}", narrowest, std::max(widest, narrowest)));
  if (fiber.roughness * (1 + variation.width) > 57 * degree)
    return wrong("width", "roughness of at most 0.99", fmt::format("{:.4g}", fiber.roughness * (1 + variation.width)));
  // Lambdas follow the roughness, which is rounded to whole degrees.
  const double alpha = fiber.roughness / degree, least = std::floor(alpha * (1 - variation.width) + rounding) / alpha,
               most = std::ceil(alpha * (1 + variation.width) - rounding) / alpha;
  for (const auto& lambda : fiber.longitudinal_lambda) {
    if (!lambda || (*lambda * least >= (0.25 - rounding) * degree && *lambda * most <= (45 + rounding) * degree))
      continue;
    return wrong("width", "longitudinal lambdas within 0.25..45 degrees",
                 fmt::format("{:.4g}..{:.4g}", *lambda * least / degree, *lambda * most / degree));
  }
  return std::nullopt;
}

bool varies(const Scene& scene, const Groom& groom) {
  const Material& material = scene.materials[groom.material];
  const StrandVariation& variation = material.variation;
  return variation.eccentricity > 0 || variation.width > 0 || variation.color > 0 || material.color_from_file;
}

/// Calls visit(groom, strand, key) for the strands of all grooms; once, with strand 0, for a groom that does not vary.
template <class Visit>
void for_each_key(const Scene& scene, double ratio, Visit&& visit) {
  for (std::size_t g = 0; g < scene.grooms.size(); ++g) {
    const Groom& groom = scene.grooms[g];
    const std::uint32_t count = varies(scene, groom) ? groom.strand_count() : std::min(groom.strand_count(), 1u);
    for (std::uint32_t s = 0; s < count; ++s) visit(g, s, key_of(scene, groom, s, ratio));
  }
}

/// The fibers of all strands, in the order of their keys.
std::map<FiberKey, std::uint32_t> distinct_keys(const Scene& scene, double ratio) {
  std::map<FiberKey, std::uint32_t> keys;
  for_each_key(scene, ratio, [&](std::size_t, std::uint32_t, const FiberKey& key) { keys.try_emplace(key, 0); });
  std::uint32_t next = 0;
  for (auto& [key, index] : keys) index = next++;
  return keys;
}

/// Each shape that the strands of a material take costs some .2 s of CPU. From eight on they share the paths of eight,
/// down to an eighth for each: among other strands of their material their noise is lost. The material alone decides,
/// so that no other one changes it.
std::map<std::uint32_t, float> energy_path_shares(const Scene& scene, const std::map<FiberKey, std::uint32_t>& keys) {
  std::map<std::uint32_t, std::set<std::array<int, 3>>> shapes;
  for (const auto& [key, index] : keys) {
    const bool has_glint = scene.materials[key.material].fiber.split_glint;
    shapes[key.material].insert({key.eccentricity_percent, key.roughness_deg, has_glint ? key.sigma_deg[1] : as_given});
  }
  std::map<std::uint32_t, float> shares;
  for (const auto& [material, of_material] : shapes) {
    shares[material] = std::clamp(8 / static_cast<float>(of_material.size()), 0.125f, 1.0f);
  }
  return shares;
}

}  // namespace

std::optional<Error> assign_fibers(Scene* scene) {
  for (std::size_t m = 0; m < scene->materials.size(); ++m)
    if (auto error = check(*scene, m)) return error;
  bool any_varies = false, any_file = false;
  for (const Groom& groom : scene->grooms) {
    any_varies = any_varies || varies(*scene, groom);
    any_file = any_file || (scene->materials[groom.material].color_from_file && !groom.color.empty());
  }

  double ratio = color_ratio;
  auto keys = distinct_keys(*scene, ratio);
  while (any_file && keys.size() > most_fibers && ratio * ratio <= largest_color_ratio) {
    ratio *= ratio;
    keys = distinct_keys(*scene, ratio);
  }
  if (keys.size() > most_fibers) {
    std::map<std::uint32_t, std::size_t> by_material;
    for (const auto& [key, index] : keys) ++by_material[key.material];
    const auto most = std::max_element(by_material.begin(), by_material.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    return Error{scene->source, fmt::format("/materials/{}/variation", most->first),
                 fmt::format("at most {} distinct fibers in the scene", most_fibers),
                 fmt::format("{}, {} of them of this material", keys.size(), most->second)};
  }
  scene->fibers.clear();
  const std::map<std::uint32_t, float> shares = energy_path_shares(*scene, keys);
  for (const auto& [key, index] : keys) {
    scene->fibers.push_back(fiber_of(*scene, key, scene->materials[key.material].color_from_file, ratio));
    scene->fibers.back().energy_path_share = shares.at(key.material);
  }
  std::vector<std::vector<std::uint32_t>> fiber_of_strand(scene->grooms.size());
  for_each_key(*scene, ratio, [&](std::size_t groom, std::uint32_t, const FiberKey& key) {
    fiber_of_strand[groom].push_back(keys.at(key));
  });
  for (std::size_t g = 0; g < scene->grooms.size(); ++g) {
    Groom& groom = scene->grooms[g];
    groom.fiber = std::move(fiber_of_strand[g]);
    if (!groom.fiber.empty()) groom.fiber.resize(groom.strand_count(), groom.fiber.front());
  }
  if (any_varies) scene->notes.push_back(fmt::format("strands vary: {} distinct fibers", scene->fibers.size()));
  if (ratio > color_ratio)
    scene->notes.push_back(fmt::format("absorptions of the file rounded to steps of {:.0f} %", 100 * (ratio - 1)));
  return std::nullopt;
}

}  // namespace tress::scene
