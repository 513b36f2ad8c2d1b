#include "scene/model/strand_fibers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/pi.h"
#include "scene/model/parameters.h"
#include "tress/base/random.h"
#include "tress/fiber/parameter_ranges.h"
#include "tress/fiber/rounded_shape.h"

namespace tress::scene {
namespace {

using fiber::ShapeSteps;

/// Absorptions of a source below this become 0 or this.
constexpr double least_absorption = 0.01;
/// If there are too many distinct fibers, the steps of a source's colors become coarser, up to this ratio.
constexpr double largest_color_ratio = 5;
/// The approximate number of stations of a strand that varies along its length, or one for each point.
constexpr std::size_t usual_stations = 32;
/// A node's widths vary by whole steps of this.
constexpr double width_step = 0.05;
constexpr int as_given = std::numeric_limits<int>::min(), clear = as_given + 1;

/// How a number of a fiber is rounded, by FiberNumber.
struct NumberGrid {
  const char* key;  ///< in a material
  float fiber::FiberParameters::* member;
  fiber::ParameterRange range;
  double steps_a_unit;  ///< 0: powers of color_ratio, from least_absorption on
};
constexpr fiber::ParameterRange tilt_range{fiber::tilt_range_deg.least * degree, fiber::tilt_range_deg.most* degree};
constexpr std::array<NumberGrid, fiber_numbers> grids{
    {{"eccentricity", &fiber::FiberParameters::eccentricity, fiber::eccentricity_range, 1 / ShapeSteps::eccentricity},
     {"tilt_deg", &fiber::FiberParameters::tilt, tilt_range, 1 / ShapeSteps::tilt},
     {"medulla/radius", &fiber::FiberParameters::medulla_radius, fiber::medulla_radius_range, 1 / ShapeSteps::medulla},
     {"medulla/scattering", &fiber::FiberParameters::medulla_scattering, fiber::medulla_scattering_range, 0},
     {"medulla/asymmetry", &fiber::FiberParameters::medulla_asymmetry, fiber::medulla_asymmetry_range,
      1 / ShapeSteps::medulla},
     {"medulla/absorption", &fiber::FiberParameters::medulla_absorption, fiber::medulla_absorption_range, 0},
     {"cortex/scattering", &fiber::FiberParameters::cortex_scattering, fiber::cortex_scattering_range, 0},
     {"cortex/asymmetry", &fiber::FiberParameters::cortex_asymmetry, fiber::cortex_asymmetry_range,
      1 / ShapeSteps::medulla},
     {"wetness", &fiber::FiberParameters::wetness, fiber::wetness_range, 1 / ShapeSteps::wetness}}};
constexpr auto the_eccentricity = static_cast<std::size_t>(FiberNumber::eccentricity);
constexpr auto first_late = static_cast<std::size_t>(FiberNumber::cortex_scattering);  // drawn after the gains

/// An array with the same item in all places.
template <std::size_t n, class Item>
constexpr std::array<Item, n> filled(const Item& item) {
  std::array<Item, n> items{};
  items.fill(item);
  return items;
}

/// What distinguishes the fibers of one material: whole numbers, or as_given if the material does not vary.
struct FiberKey {
  std::uint32_t material = 0;
  std::array<int, fiber_numbers> steps = filled<fiber_numbers>(as_given);  ///< of its numbers, on their grids
  int roughness_deg = as_given, width_steps = as_given;
  std::array<int, 3> sigma_deg = filled<3>(as_given), color_power = filled<3>(as_given);  ///< colors: rounded down
  /// By lobe and channel: powers of color_ratio on the material's gain.
  std::array<std::array<int, 3>, fiber::lobe_count> gain_power = filled<fiber::lobe_count>(filled<3>(as_given));

  friend auto operator<=>(const FiberKey&, const FiberKey&) = default;
};

std::uint64_t hash_of(const std::string& name) {
  std::uint64_t hash = 0;
  for (const unsigned char c : name) hash = mix_bits(hash ^ (c + 0x9e3779b97f4a7c15ull));
  return hash;
}

/// Returns x (1 + half_range y), y uniform in [-1, 1).
double varied(double x, double half_range, RandomStream& random) {
  return x * (1 + half_range * (2 * double{random.next()} - 1));
}

/// Rounds a gain to a power of color_ratio, which 1 is, or to `clear`.
int round_gain(double x, double u) {
  constexpr int least_power = -25;  // 0.01
  const double least = std::pow(color_ratio, least_power);
  if (x >= least) return static_cast<int>(round_to_power(x, color_ratio, u));
  return u < x / least ? least_power : clear;
}

/// By channel, the share in 65536ths of the hits whose absorption is the next one above that of the key.
using Above = std::array<std::uint16_t, 3>;

/// The random values of a strand: its key without the material's sources, and the numbers that round those.
struct StrandDraws {
  FiberKey key;
  Above above{};
  double width, width_u, sigma_u;  ///< factor on the roughness and the widths, and the numbers that round both
  double factor;                   ///< on the absorption
  double eccentricity;             ///< added to that of a source
  double gain_u;                   ///< the number that rounds all gains
  std::array<double, fiber_numbers> number_u;  ///< the numbers that round those of sources
};

/// Rounds an absorption or a coefficient >= 0 to a power of the ratio times least_absorption, or to `clear`.
int round_absorption(double x, double ratio, double u) {
  const double in_least = x / least_absorption;
  if (in_least >= 1) return static_cast<int>(round_to_power(in_least, ratio, u));
  return u < in_least ? 0 : clear;
}

/// Rounds an absorption down, and leaves the rest to hits. x > 0: to a power of the ratio.
void set_power(double x, double ratio, int* power, std::uint16_t* above) {
  const auto low = static_cast<int>(round_to_power(x, ratio, 1));
  const double below = std::pow(ratio, low);
  const auto share = std::lround(65536 * (x - below) / (below * ratio - below));
  *power = low + (share < 65536 ? 0 : 1);
  *above = static_cast<std::uint16_t>(share % 65536);
}

/// The same to a power times least_absorption, or to `clear`; x below 0, of a sum or a normal distribution, counts as
/// 0.
void set_absorption(double x, double ratio, int* power, std::uint16_t* above) {
  const double in_least = std::max(x, 0.0) / least_absorption;
  const auto share = std::lround(65536 * in_least);
  if (share >= 65536) return set_power(std::max(in_least, 1.0), ratio, power, above);
  *power = clear;
  *above = static_cast<std::uint16_t>(share);
}

/// Sets a key's roughness; the material's widths follow it as they follow its own.
void set_roughness(const fiber::FiberParameters& fiber, double roughness, const StrandDraws& draws, FiberKey* key) {
  key->roughness_deg = static_cast<int>(round_stochastically(roughness / degree, draws.width_u));
  fiber::FiberParameters rounded = fiber;
  rounded.roughness = static_cast<float>(key->roughness_deg * degree);
  const auto sigmas = fiber::azimuthal_sigmas(rounded);
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma =
        fiber.azimuthal_sigma[i] ? *fiber.azimuthal_sigma[i] * (roughness / fiber.roughness) : double{sigmas[i]};
    key->sigma_deg[i] = static_cast<int>(round_stochastically(std::round(1e4 * sigma / degree) / 1e4, draws.sigma_u));
  }
}

/// Draws all numbers of a strand, whatever varies, so that one variation does not change another.
StrandDraws draws_of(const Scene& scene, const Groom& groom, std::uint32_t strand, double ratio) {
  const Material& material = scene.materials[groom.material];
  const StrandVariation& variation = material.variation;
  const fiber::FiberParameters& fiber = material.fiber;
  RandomStream random(variation.seed, hash_of(material.name), strand);
  StrandDraws draws;
  FiberKey& key = draws.key;
  key.material = groom.material;

  draws.eccentricity = variation.eccentricity * (2 * double{random.next()} - 1);
  draws.number_u[the_eccentricity] = random.next();
  if (variation.eccentricity > 0)
    key.steps[the_eccentricity] = static_cast<int>(round_stochastically(
        1 / ShapeSteps::eccentricity * (fiber.eccentricity + draws.eccentricity), draws.number_u[the_eccentricity]));

  draws.width = varied(1, variation.width, random);
  draws.width_u = random.next();
  draws.sigma_u = random.next();
  if (variation.width > 0 && material.has_node_widths)
    key.width_steps = static_cast<int>(round_stochastically(draws.width / width_step, draws.width_u));
  else if (variation.width > 0)
    set_roughness(fiber, fiber.roughness * draws.width, draws, &key);

  draws.factor = varied(1, variation.color, random);
  if (variation.color > 0 && !material.pigment)
    for (std::size_t c = 0; c < 3; ++c) set_power(draws.factor, ratio, &key.color_power[c], &draws.above[c]);
  for (std::size_t n = the_eccentricity + 1; n < first_late; ++n) draws.number_u[n] = random.next();
  draws.gain_u = random.next();
  for (std::size_t n = first_late; n < fiber_numbers; ++n) draws.number_u[n] = random.next();
  return draws;
}

/// The strand of a place, whose place along it is not set. salt: of the material.
StrandPlace strand_place(const Groom& groom, std::uint32_t strand, std::uint64_t salt) {
  StrandPlace place;
  if (!groom.root_uv.empty()) place.root_uv = groom.root_uv[strand];
  place.strand = mix_bits(salt ^ static_cast<std::uint64_t>(groom.strand_id(strand)));
  if (!groom.color.empty() && groom.color.size() != groom.points.size()) place.attribute = groom.color[strand];
  return place;
}

/// The lengths from the root to the points of a strand that is drawn between its first and its last segment.
std::vector<float> lengths_of(const Groom& groom, std::uint32_t strand) {
  const StrandSegments segments(groom.basis);
  const std::uint32_t begin = groom.first_point[strand] + segments.first;
  const std::uint32_t steps = segments.count(groom.first_point[strand + 1] - groom.first_point[strand]);
  std::vector<float> length{0};
  for (std::uint32_t i = 0; i < steps * segments.points_a_segment; ++i)
    length.push_back(length.back() + glm::distance(groom.points[begin + i], groom.points[begin + i + 1]));
  return length;
}

/// Calls visit(place) for the stations of a strand, root first. If the strand has none, calls it once, without a place
/// along the strand. Lengths are those of the polygon of its points.
template <class Visit>
void for_each_station(const Groom& groom, std::uint32_t strand, std::uint32_t stations_a_segment, std::uint64_t salt,
                      Visit&& visit) {
  StrandPlace place = strand_place(groom, strand, salt);
  if (stations_a_segment == 0) return visit(place);
  const StrandSegments segments(groom.basis);
  const std::uint32_t begin = groom.first_point[strand] + segments.first;
  const std::uint32_t steps = segments.count(groom.first_point[strand + 1] - groom.first_point[strand]);
  const std::vector<float> length = lengths_of(groom, strand);
  const std::uint32_t stations = steps * stations_a_segment;
  for (std::uint32_t station = 0; station <= stations; ++station) {
    const std::uint32_t along = station * segments.points_a_segment;
    const std::uint32_t i = std::min(along / stations_a_segment, static_cast<std::uint32_t>(length.size() - 2));
    const float share = static_cast<float>(along - i * stations_a_segment) / float(stations_a_segment);
    place.root_cm = glm::mix(length[i], length[i + 1], share);
    place.tip_cm = length.back() - place.root_cm;
    place.share = length.back() > 0 ? place.root_cm / length.back() : float(station) / float(stations);
    if (groom.color.size() == groom.points.size())
      place.attribute = glm::mix(groom.color[begin + i], groom.color[begin + i + 1], share);
    visit(place);
  }
}

/// Multiplies all widths of a node's fiber by the factor.
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

fiber::FiberParameters fiber_of(const Scene& scene, const FiberKey& key, double ratio) {
  const bool from_source = scene.materials[key.material].pigment.has_value();
  fiber::FiberParameters fiber = scene.materials[key.material].fiber;
  for (std::size_t n = 0; n < fiber_numbers; ++n) {
    if (key.steps[n] == as_given) continue;
    const NumberGrid& grid = grids[n];
    const double number = grid.steps_a_unit > 0   ? key.steps[n] / grid.steps_a_unit
                          : key.steps[n] == clear ? 0
                                                  : least_absorption * std::pow(color_ratio, key.steps[n]);
    fiber.*grid.member = static_cast<float>(std::clamp(number, grid.range.least, grid.range.most));
  }
  if (key.roughness_deg != as_given) {
    const double roughness = std::clamp(key.roughness_deg * degree, 0.01, 1.0);
    for (auto& lambda : fiber.longitudinal_lambda)
      if (lambda) *lambda *= static_cast<float>(roughness / fiber.roughness);
    fiber.roughness = static_cast<float>(roughness);
    for (std::size_t i = 0; i < 3; ++i)
      fiber.azimuthal_sigma[i] = static_cast<float>(std::clamp(key.sigma_deg[i], 1, 45) * degree);
  }
  for (std::size_t p = 0; p < fiber.gain.size(); ++p)
    for (int c = 0; c < 3; ++c) {
      const int power = key.gain_power[p][static_cast<std::size_t>(c)];
      if (power != as_given)
        fiber.gain[p][c] = std::min(fiber.gain[p][c] * (power == clear ? 0.0f : float(std::pow(color_ratio, power))),
                                    static_cast<float>(fiber::gain_range.most));
    }
  if (key.width_steps != as_given) widen(key.width_steps * width_step, &fiber);
  for (std::size_t c = 0; c < 3; ++c) {
    const int power = key.color_power[c];
    if (power == as_given) continue;
    float& sigma_a = fiber.sigma_a[static_cast<int>(c)];
    sigma_a =
        power == clear ? 0.0f : static_cast<float>((from_source ? least_absorption : sigma_a) * std::pow(ratio, power));
  }
  return fiber;
}

/// Checks that every varied value stays in the range of its parameter.
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

/// Whether test(source) is true for any source of the fiber but for its absorption.
template <class Test>
bool any_fiber_source(const Material& material, const Test& test) {
  const auto passes = [&](const std::optional<Source>& source) { return source && test(*source); };
  return passes(material.roughness) || std::ranges::any_of(material.numbers, passes) ||
         std::ranges::any_of(material.gain, passes) || std::ranges::any_of(material.tint, passes);
}

bool has_fiber_sources(const Material& material) {
  return any_fiber_source(material, [](const Source&) { return true; });
}

bool varies(const Scene& scene, const Groom& groom) {
  const Material& material = scene.materials[groom.material];
  const StrandVariation& variation = material.variation;
  return variation.eccentricity > 0 || variation.width > 0 || variation.color > 0 || material.pigment ||
         has_fiber_sources(material);
}

/// The varying absorption of a groom's strands; null if the material's own applies.
const Pigment* pigment_of(const Scene& scene, const Groom& groom) {
  const Material& material = scene.materials[groom.material];
  return material.pigment && (!groom.color.empty() || attributes_of(material).empty()) ? &*material.pigment : nullptr;
}

bool varies_along(const Groom& groom, const Source& source) {
  return source.varies_along(!groom.color.empty() && groom.color.size() == groom.points.size());
}

/// The number of stations in a segment of a strand that varies along its length.
std::uint32_t usual_stations_of(const Groom& groom) {
  const StrandSegments segments(groom.basis);
  std::size_t all = 0;
  for (std::uint32_t s = 0; s < groom.strand_count(); ++s)
    all += segments.count(groom.first_point[s + 1] - groom.first_point[s]);
  return all == 0 ? 1 : static_cast<std::uint32_t>((usual_stations * groom.strand_count() + all - 1) / all);
}

/// The number of stations in a segment of the groom's strands; 0 if they do not vary along their length.
std::uint32_t stations_of(const Scene& scene, const Groom& groom) {
  const Pigment* pigment = pigment_of(scene, groom);
  const Material& material = scene.materials[groom.material];
  const auto along = [&](const Source& source) { return varies_along(groom, source); };
  const bool varies = (pigment && (along(pigment->source) || (pigment->dye && along(*pigment->dye)))) ||
                      any_fiber_source(material, along);
  return varies ? usual_stations_of(groom) : 0;
}

/// Sets the presence of the groom from its material; leaves it empty if it is 1 everywhere, or comes from an attribute
/// that the file does not have.
void assign_presence(const Material& material, Groom* groom) {
  groom->presence.clear();
  groom->presence_stations = 0;
  if (!material.presence) return;
  std::vector<std::string> attributes;
  material.presence->add_attributes(&attributes);
  if (!attributes.empty() && groom->color.empty()) return;
  if (varies_along(*groom, *material.presence)) groom->presence_stations = usual_stations_of(*groom);
  const std::uint64_t salt = hash_of(material.name);
  for (std::uint32_t strand = 0; strand < groom->strand_count(); ++strand)
    for_each_station(*groom, strand, groom->presence_stations, salt, [&](const StrandPlace& place) {
      groom->presence.push_back(std::clamp(material.presence->at(place).x, 0.0f, 1.0f));
    });
  if (std::ranges::all_of(groom->presence, [](float presence) { return presence == 1; })) groom->presence.clear();
}

/// Sets the numbers of a fiber that have sources, and the key's rounded ones.
void set_numbers(const Material& material, const StrandPlace& place, const StrandDraws& draws, FiberKey* key,
                 fiber::FiberParameters* fiber) {
  for (std::size_t n = 0; n < fiber_numbers; ++n) {
    if (!material.numbers[n]) continue;
    const NumberGrid& grid = grids[n];
    const double number =
        std::clamp(material.numbers[n]->at(place).x + (n == the_eccentricity ? draws.eccentricity : 0),
                   grid.range.least, grid.range.most);
    key->steps[n] = grid.steps_a_unit > 0
                        ? static_cast<int>(round_stochastically(grid.steps_a_unit * number, draws.number_u[n]))
                        : round_absorption(number, color_ratio, draws.number_u[n]);
    fiber->*grid.member = static_cast<float>(number);
  }
  for (std::size_t p = 0; p < material.gain.size(); ++p) {
    if (!material.gain[p] && !material.tint[p]) continue;
    glm::vec3 gain = material.tint[p] ? material.tint[p]->at(place) : glm::vec3(1.0f);
    if (material.gain[p]) gain *= material.gain[p]->at(place).x;
    for (int c = 0; c < 3; ++c) key->gain_power[p][static_cast<std::size_t>(c)] = round_gain(gain[c], draws.gain_u);
  }
}

/// The error if a source changes the eccentricity along strands, whose shape has one.
std::optional<Error> fault_of_eccentricity(const Scene& scene, const Groom& groom) {
  const std::optional<Source>& source = scene.materials[groom.material].numbers[the_eccentricity];
  if (!source || !varies_along(groom, *source)) return std::nullopt;
  return Error{scene.source, fmt::format("/materials/{}/eccentricity", groom.material),
               "one eccentricity for the whole of a strand", "a source that varies along strands of " + groom.name};
}

/// Calls visit(groom, key, above) for the strands of all grooms, and for each station of those that vary along their
/// length; once for a groom that does not vary. Stops when it returns false.
template <class Visit>
void for_each_key(const Scene& scene, double ratio, Visit&& visit) {
  for (std::size_t g = 0; g < scene.grooms.size(); ++g) {
    const Groom& groom = scene.grooms[g];
    const Material& material = scene.materials[groom.material];
    const Pigment* pigment = pigment_of(scene, groom);
    const std::uint64_t salt = hash_of(material.name);
    const std::uint32_t count = varies(scene, groom) ? groom.strand_count() : std::min(groom.strand_count(), 1u);
    for (std::uint32_t s = 0; s < count; ++s) {
      StrandDraws draws = draws_of(scene, groom, s, ratio);
      if (pigment == nullptr && !has_fiber_sources(material)) {
        if (!visit(g, draws.key, draws.above)) return;
        continue;
      }
      bool goes_on = true;
      fiber::FiberParameters fiber = material.fiber;
      for_each_station(groom, s, groom.stations_a_segment, salt, [&](const StrandPlace& place) {
        set_numbers(material, place, draws, &draws.key, &fiber);
        if (material.roughness) {
          const double roughness = std::clamp(material.roughness->at(place).x * draws.width, 0.01, 1.0);
          set_roughness(material.fiber, roughness, draws, &draws.key);
          fiber.roughness = static_cast<float>(roughness);
        }
        const glm::vec3 sigma_a = pigment ? pigment->at(place, fiber) : glm::vec3(0.0f);
        for (std::size_t c = 0; pigment && c < 3; ++c)
          set_absorption(sigma_a[static_cast<int>(c)] * draws.factor, ratio, &draws.key.color_power[c],
                         &draws.above[c]);
        goes_on = goes_on && visit(g, draws.key, draws.above);
      });
      if (!goes_on) return;
    }
  }
}

/// The key with the next absorption above in the channels that are bits of `channels`.
FiberKey raised(FiberKey key, std::size_t channels) {
  for (std::size_t c = 0; c < 3; ++c) {
    if ((channels >> c & 1) == 0) continue;
    int& power = key.color_power[c];
    power = power == clear ? 0 : power + 1;
  }
  return key;
}

/// The fibers of a scene by their keys, and those of each strand or station of a groom, in their order.
struct Assignment {
  std::map<FiberKey, std::uint32_t> keys;
  std::vector<std::vector<std::uint32_t>> fibers;
  std::vector<std::vector<Above>> above;
  std::vector<std::array<std::uint32_t, 8>> fibers_above;  ///< as in the scene
};

/// If there are more than `most` fibers, only some are returned.
Assignment assignment(const Scene& scene, double ratio, std::size_t most) {
  Assignment all{.keys = {},
                 .fibers = std::vector<std::vector<std::uint32_t>>(scene.grooms.size()),
                 .above = std::vector<std::vector<Above>>(scene.grooms.size()),
                 .fibers_above = {}};
  /// A key that places have: its number in the order of places, and which of the keys above it their hits have, as
  /// bits.
  struct Lower {
    std::uint32_t index;
    std::uint8_t raised;
  };
  std::map<FiberKey, Lower> lower;
  auto last = lower.end();
  for_each_key(scene, ratio, [&](std::size_t groom, const FiberKey& key, const Above& above) {
    if (last == lower.end() || key != last->first)
      last = lower.try_emplace(key, Lower{static_cast<std::uint32_t>(lower.size()), 0}).first;
    for (const std::uint16_t share : above) {  // u below the share raises all channels whose share is as large
      std::size_t channels = 0;
      for (std::size_t c = 0; c < 3; ++c) channels |= std::size_t{above[c] >= share ? 1u : 0u} << c;
      if (share > 0) last->second.raised |= static_cast<std::uint8_t>(1u << channels);
    }
    all.fibers[groom].push_back(last->second.index);
    all.above[groom].push_back(above);
    return lower.size() <= most;
  });
  for (const auto& [key, of_key] : lower) {
    all.keys.emplace(key, 0);
    for (std::size_t channels = 1; channels < 8; ++channels)
      if ((of_key.raised >> channels & 1) != 0) all.keys.emplace(raised(key, channels), 0);
  }
  std::uint32_t next = 0;
  for (auto& [key, index] : all.keys) index = next++;
  std::vector<std::uint32_t> order(lower.size());
  all.fibers_above.resize(all.keys.size());
  for (const auto& [key, of_key] : lower) {
    const std::uint32_t own = order[of_key.index] = all.keys.at(key);
    all.fibers_above[own].fill(own);
    for (std::size_t channels = 1; channels < 8; ++channels)
      if ((of_key.raised >> channels & 1) != 0) all.fibers_above[own][channels] = all.keys.at(raised(key, channels));
  }
  for (auto& fibers : all.fibers)
    for (std::uint32_t& fiber : fibers) fiber = order[fiber];
  return all;
}

/// Each shape of a material's strands costs some 0.2 s of CPU. From eight shapes on they share the paths of eight, down
/// to an eighth for each, because their noise is not visible among other strands of their material. Only the material
/// decides, so that other materials do not change it.
std::map<std::uint32_t, float> energy_path_shares(const Scene& scene, const std::map<FiberKey, std::uint32_t>& keys) {
  std::map<std::uint32_t, std::set<std::tuple<std::array<int, fiber_numbers>, int, int>>> shapes;
  for (const auto& [key, index] : keys) {
    const bool has_glint = scene.materials[key.material].fiber.split_glint;
    shapes[key.material].insert({key.steps, key.roughness_deg, has_glint ? key.sigma_deg[1] : as_given});
  }
  std::map<std::uint32_t, float> shares;
  for (const auto& [material, of_material] : shapes) {
    shares[material] = std::clamp(8 / static_cast<float>(of_material.size()), 0.125f, 1.0f);
  }
  return shares;
}

}  // namespace

std::vector<std::string> attributes_of(const Material& material) {
  std::vector<std::string> names;
  for_each_source(material, [&](const Source& source) { source.add_attributes(&names); });
  return names;
}

void apply_thickness(const Material& material, Groom* groom) {
  if (!material.thickness) return;
  const std::uint64_t salt = hash_of(material.name);
  const std::uint32_t first = StrandSegments(groom->basis).first;
  for (std::uint32_t strand = 0; strand < groom->strand_count(); ++strand) {
    StrandPlace place = strand_place(*groom, strand, salt);
    const std::vector<float> length = lengths_of(*groom, strand);
    for (std::uint32_t i = groom->first_point[strand]; i < groom->first_point[strand + 1]; ++i) {
      // Control points beyond the ends of an open curve are as its ends.
      const std::uint32_t from_root = i - std::min(i, groom->first_point[strand] + first);
      place.root_cm = length[std::min<std::size_t>(from_root, length.size() - 1)];
      place.tip_cm = length.back() - place.root_cm;
      place.share = length.back() > 0 ? place.root_cm / length.back() : 0;
      if (groom->color.size() == groom->points.size()) place.attribute = groom->color[i];
      const float factor = std::max(material.thickness->at(place).x, 0.0f);
      groom->radius_cm[i] *= factor;
      for (StrandMoment& moment : groom->later)
        if (!moment.radius_cm.empty()) moment.radius_cm[i] *= factor;
    }
  }
}

float length_share(const Groom& groom, std::uint32_t strand, float place) {
  const StrandSegments segments(groom.basis);
  const std::uint32_t begin = groom.first_point[strand] + segments.first;
  const std::uint32_t steps =
      segments.count(groom.first_point[strand + 1] - groom.first_point[strand]) * segments.points_a_segment;
  const float along =
      std::clamp(place * static_cast<float>(segments.points_a_segment), 0.0f, static_cast<float>(steps));
  const std::uint32_t last = std::min(static_cast<std::uint32_t>(along), steps - 1);
  float before = 0, all = 0;
  for (std::uint32_t i = 0; i < steps; ++i) {
    const float length = glm::distance(groom.points[begin + i], groom.points[begin + i + 1]);
    all += length;
    if (i < last) before += length;
    if (i == last) before += (along - static_cast<float>(i)) * length;
  }
  return all > 0 ? std::min(before / all, 1.0f) : along / static_cast<float>(steps);
}

std::optional<Error> assign_fibers(Scene* scene) {
  for (std::size_t m = 0; m < scene->materials.size(); ++m)
    if (auto error = check(*scene, m)) return error;
  bool any_varies = false, any_source = false;
  std::size_t along = 0, bytes = 0;  // number of stations along strands, and their memory
  for (Groom& groom : scene->grooms) {
    if (auto error = fault_of_eccentricity(*scene, groom)) return error;
    any_varies = any_varies || varies(*scene, groom);
    any_source = any_source || pigment_of(*scene, groom) != nullptr;
    groom.stations_a_segment = stations_of(*scene, groom);
    assign_presence(scene->materials[groom.material], &groom);
    if (groom.stations_a_segment == 0) continue;
    const std::size_t stations = groom.first_station(groom.strand_count());
    along += stations;
    const std::size_t above = pigment_of(*scene, groom) != nullptr ? sizeof(Above) : 0;
    bytes += stations * (sizeof(std::uint32_t) + above) + groom.color.size() * sizeof(glm::vec3);
  }

  double ratio = color_ratio;
  const auto is_coarsest = [&] { return !any_source || ratio * ratio > largest_color_ratio; };
  const auto assigned_now = [&] { return assignment(*scene, ratio, is_coarsest() ? SIZE_MAX : most_fibers); };
  Assignment assigned = assigned_now();
  while (assigned.keys.size() > most_fibers && !is_coarsest()) {
    ratio *= ratio;
    assigned = assigned_now();
  }
  const std::map<FiberKey, std::uint32_t>& keys = assigned.keys;
  if (keys.size() > most_fibers) {
    std::map<std::uint32_t, std::size_t> by_material;
    for (const auto& [key, index] : keys) ++by_material[key.material];
    const auto most = std::max_element(by_material.begin(), by_material.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    const Material& material = scene->materials[most->first];
    const auto source = std::ranges::find_if(material.numbers, [](const auto& number) { return bool(number); });
    const char* place = material.roughness                 ? "roughness"
                        : source != material.numbers.end() ? grids[std::size_t(source - material.numbers.begin())].key
                        : has_fiber_sources(material)      ? "gain"
                                                           : "variation";
    return Error{scene->source, fmt::format("/materials/{}/{}", most->first, place),
                 fmt::format("at most {} distinct fibers in the scene", most_fibers),
                 fmt::format("{}, {} of them of this material", keys.size(), most->second)};
  }
  scene->fibers.clear();
  const std::map<std::uint32_t, float> shares = energy_path_shares(*scene, keys);
  for (const auto& [key, index] : keys) {
    scene->fibers.push_back(fiber_of(*scene, key, ratio));
    scene->fibers.back().energy_path_share = shares.at(key.material);
  }
  bool any_between = false;
  for (std::size_t g = 0; g < scene->grooms.size(); ++g) {
    Groom& groom = scene->grooms[g];
    groom.fiber = std::move(assigned.fibers[g]);
    if (!varies(*scene, groom) && !groom.fiber.empty()) groom.fiber.resize(groom.strand_count(), groom.fiber.front());
    groom.above.clear();
    const bool is_between = std::ranges::any_of(assigned.above[g], [](const Above& above) { return above != Above{}; });
    if (is_between) groom.above = std::move(assigned.above[g]);
    any_between = any_between || is_between;
  }
  scene->fibers_above.clear();
  if (any_between) scene->fibers_above = std::move(assigned.fibers_above);
  if (any_varies)
    scene->notes.push_back(fmt::format(
        "strands vary: {} distinct fibers{}", scene->fibers.size(),
        along == 0 ? ""
                   : fmt::format(", at {} places along the strands ({:.1f} MB)", along, double(bytes) / (1 << 20))));
  if (ratio > color_ratio)
    scene->notes.push_back(fmt::format("absorptions that vary are rounded to steps of {:.0f} %", 100 * (ratio - 1)));
  return std::nullopt;
}

}  // namespace tress::scene
