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
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/bands.h"
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
/// Gains below color_ratio to this become 0 or that.
constexpr int least_gain_power = -25;
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

/// What of a fiber may vary, as places in FiberKey::steps: FiberNumber, then these.
constexpr std::size_t the_roughness = fiber_numbers, the_widths = the_roughness + 1, the_color = the_widths + 1,
                      the_gains = the_color + 3, varying = the_gains + 3 * fiber::lobe_count;

/// What distinguishes the fibers of one material.
struct FiberKey {
  std::uint32_t material = 0;
  /// Numbers on their grids, the roughness in degrees, factors of width in steps, and powers of a ratio: of the
  /// absorption by channel, of the gains by lobe and channel. Or as_given where the material does not vary.
  std::array<int, varying> steps;

  FiberKey() { steps.fill(as_given); }
  friend auto operator<=>(const FiberKey&, const FiberKey&) = default;
};

/// A key whose steps are rounded down, and for each the share in 65536ths of the hits that have the next step.
struct BetweenSteps {
  FiberKey key;
  std::array<std::uint16_t, varying> above{};
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

/// The random values of a strand.
struct StrandDraws {
  double width;           ///< factor on the roughness and the widths
  double factor;          ///< on the absorption
  double eccentricity;    ///< added to that of the material or a source
  double eccentricity_u;  ///< the number that rounds it
};

/// Sets a place to the whole step below a value, and the share of the hits that have the step above.
void set_steps(double x, std::size_t place, BetweenSteps* between) {
  const double whole = std::floor(x);
  const auto share = std::lround(65536 * (x - whole));
  between->key.steps[place] = static_cast<int>(whole) + (share < 65536 ? 0 : 1);
  between->above[place] = static_cast<std::uint16_t>(share % 65536);
}

/// The same with powers of a ratio; x > 0.
void set_power(double x, double ratio, std::size_t place, BetweenSteps* between) {
  const auto low = static_cast<int>(round_to_power(x, ratio, 1));
  const double below = std::pow(ratio, low);
  set_steps(low + (x - below) / (below * ratio - below), place, between);
}

/// The same with powers of a ratio times `least`, or `clear`. x below 0, of a sum or a normal distribution, counts as
/// 0.
void set_coefficient(double x, double least, double ratio, std::size_t place, BetweenSteps* between) {
  const double in_least = std::max(x, 0.0) / least;
  if (in_least >= 1) return set_power(in_least, ratio, place, between);
  set_steps(in_least, place, between);  // from `clear` to the power 0
  int& step = between->key.steps[place];
  step = step == 0 ? clear : 0;
}

/// The next step above that of a place.
int raised(int step) { return step == clear ? 0 : step + 1; }

/// Draws all numbers of a strand, whatever varies, so that one variation does not change another.
StrandDraws draws_of(const Material& material, std::uint32_t strand) {
  const StrandVariation& variation = material.variation;
  RandomStream random(variation.seed, hash_of(material.name), strand);
  StrandDraws draws;
  draws.eccentricity = variation.eccentricity * (2 * double{random.next()} - 1);
  draws.eccentricity_u = random.next();
  draws.width = varied(1, variation.width, random);
  random.next();  // two numbers that rounded widths for whole strands, so that strands keep their colors
  random.next();
  draws.factor = varied(1, variation.color, random);
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
  if (const int degrees = key.steps[the_roughness]; degrees != as_given) {
    const double roughness = std::clamp(degrees * degree, 0.01, 1.0);
    const auto factor = static_cast<float>(roughness / fiber.roughness);
    for (auto& lambda : fiber.longitudinal_lambda)
      if (lambda) *lambda *= factor;
    for (auto& sigma : fiber.azimuthal_sigma)
      if (sigma) sigma = std::clamp(*sigma * factor, static_cast<float>(degree), static_cast<float>(45 * degree));
    fiber.roughness = static_cast<float>(roughness);
  }
  for (std::size_t p = 0; p < fiber.gain.size(); ++p)
    for (int c = 0; c < 3; ++c) {
      const int power = key.steps[the_gains + 3 * p + static_cast<std::size_t>(c)];
      if (power == as_given) continue;
      const float factor = power == clear ? 0.0f : float(std::pow(color_ratio, power + least_gain_power));
      fiber.gain[p][c] = std::min(fiber.gain[p][c] * factor, static_cast<float>(fiber::gain_range.most));
    }
  if (scene.materials[key.material].spectral)
    for (glm::vec3& gain : fiber.gain) gain = bands_of_rgb(gain);
  if (const int steps = key.steps[the_widths]; steps != as_given) widen(steps * width_step, &fiber);
  for (int c = 0; c < 3; ++c) {
    const int power = key.steps[the_color + static_cast<std::size_t>(c)];
    if (power == as_given) continue;
    float& sigma_a = fiber.sigma_a[c];
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

/// Sets what varies from strand to strand, without the material's sources.
void set_variation(const Material& material, const StrandDraws& draws, double ratio, BetweenSteps* between) {
  const StrandVariation& variation = material.variation;
  if (variation.eccentricity > 0) {
    const double eccentricity = material.fiber.eccentricity + draws.eccentricity;
    between->key.steps[the_eccentricity] =
        static_cast<int>(round_stochastically(1 / ShapeSteps::eccentricity * eccentricity, draws.eccentricity_u));
  }
  if (variation.width > 0 && material.has_node_widths)
    set_steps(draws.width / width_step, the_widths, between);
  else if (variation.width > 0)
    set_steps(material.fiber.roughness * draws.width / degree, the_roughness, between);
  if (variation.color > 0 && !material.pigment)
    for (std::size_t c = 0; c < 3; ++c) set_power(draws.factor, ratio, the_color + c, between);
}

/// Sets what has sources, but for the absorption, rounded in the key and as it is in the fiber.
void set_from_sources(const Material& material, const StrandPlace& place, const StrandDraws& draws,
                      BetweenSteps* between, fiber::FiberParameters* fiber) {
  for (std::size_t n = 0; n < fiber_numbers; ++n) {
    if (!material.numbers[n]) continue;
    const NumberGrid& grid = grids[n];
    const double number =
        std::clamp(material.numbers[n]->at(place).x + (n == the_eccentricity ? draws.eccentricity : 0),
                   grid.range.least, grid.range.most);
    if (n == the_eccentricity)
      between->key.steps[n] = static_cast<int>(round_stochastically(grid.steps_a_unit * number, draws.eccentricity_u));
    else if (grid.steps_a_unit > 0)
      set_steps(grid.steps_a_unit * number, n, between);
    else
      set_coefficient(number, least_absorption, color_ratio, n, between);
    fiber->*grid.member = static_cast<float>(number);
  }
  if (material.roughness) {
    const double roughness = std::clamp(material.roughness->at(place).x * draws.width, 0.01, 1.0);
    set_steps(roughness / degree, the_roughness, between);
    fiber->roughness = static_cast<float>(roughness);
  }
  for (std::size_t p = 0; p < material.gain.size(); ++p) {
    if (!material.gain[p] && !material.tint[p]) continue;
    glm::vec3 gain = material.tint[p] ? material.tint[p]->at(place) : glm::vec3(1.0f);
    if (material.gain[p]) gain *= material.gain[p]->at(place).x;
    for (std::size_t c = 0; c < 3; ++c)
      set_coefficient(gain[int(c)], std::pow(color_ratio, least_gain_power), color_ratio, the_gains + 3 * p + c,
                      between);
  }
}

/// The error if a source changes the eccentricity along strands, whose shape has one.
std::optional<Error> fault_of_eccentricity(const Scene& scene, const Groom& groom) {
  const std::optional<Source>& source = scene.materials[groom.material].numbers[the_eccentricity];
  if (!source || !varies_along(groom, *source)) return std::nullopt;
  return Error{scene.source, fmt::format("/materials/{}/eccentricity", groom.material),
               "one eccentricity for the whole of a strand", "a source that varies along strands of " + groom.name};
}

/// Calls visit(groom, between) for the strands of all grooms, and for each station of those that vary along their
/// length; once for a groom that does not vary. Stops when it returns false.
template <class Visit>
void for_each_place(const Scene& scene, double ratio, Visit&& visit) {
  for (std::size_t g = 0; g < scene.grooms.size(); ++g) {
    const Groom& groom = scene.grooms[g];
    const Material& material = scene.materials[groom.material];
    const Pigment* pigment = pigment_of(scene, groom);
    const std::uint64_t salt = hash_of(material.name);
    const std::uint32_t count = varies(scene, groom) ? groom.strand_count() : std::min(groom.strand_count(), 1u);
    for (std::uint32_t s = 0; s < count; ++s) {
      const StrandDraws draws = draws_of(material, s);
      BetweenSteps between;
      between.key.material = groom.material;
      set_variation(material, draws, ratio, &between);
      if (pigment == nullptr && !has_fiber_sources(material)) {
        if (!visit(g, between)) return;
        continue;
      }
      bool goes_on = true;
      fiber::FiberParameters fiber = material.fiber;
      for_each_station(groom, s, groom.stations_a_segment, salt, [&](const StrandPlace& place) {
        set_from_sources(material, place, draws, &between, &fiber);
        const glm::vec3 sigma_a = pigment ? pigment->at(place, fiber) : glm::vec3(0.0f);
        for (std::size_t c = 0; pigment && c < 3; ++c)
          set_coefficient(sigma_a[int(c)] * draws.factor, least_absorption, ratio, the_color + c, &between);
        goes_on = goes_on && visit(g, between);
      });
      if (!goes_on) return;
    }
  }
}

/// One number u rounds all values of a hit: up where u is below the share of hits that have the next step. For all but
/// the absorption u is turned by this, in 65536ths, so that the absorption and the gains, which multiply, are not
/// rounded up together: at s (1 - s) = 1/6 their covariance vanishes on average over both shares.
constexpr std::uint32_t turn_of_others = 13851;

/// The steps that are raised from one value of u on, as bits, in ascending order from 0.
struct Raised {
  std::uint32_t from, places;
};

void set_raised(const BetweenSteps& between, std::vector<Raised>* raised) {
  static_assert(varying <= 32);
  std::array<std::pair<std::uint32_t, std::uint32_t>, 2 * varying> turns;  // where a bit changes
  std::size_t count = 0;
  std::uint32_t places = 0;
  for (std::size_t place = 0; place < varying; ++place) {
    const std::uint32_t share = between.above[place], bit = 1u << place;
    if (share == 0) continue;
    const std::uint32_t begin = place >= the_color && place < the_gains ? 0 : 65536 - turn_of_others;
    if (begin == 0 || begin + share > 65536) places |= bit;
    if (begin > 0) turns[count++] = {begin, bit};
    if (begin + share != 65536) turns[count++] = {(begin + share) % 65536, bit};
  }
  std::sort(turns.begin(), turns.begin() + std::ptrdiff_t(count));
  raised->assign(1, {0, places});
  for (std::size_t i = 0; i < count; ++i) {
    places ^= turns[i].second;
    if (turns[i].first != raised->back().from)
      raised->push_back({turns[i].first, places});
    else
      raised->back().places = places;
  }
}

/// The fibers of a scene by their keys, and those of the hits on its grooms.
struct Assignment {
  std::map<FiberKey, std::uint32_t> keys;
  std::vector<std::vector<FiberChoice>> choices;  ///< by groom: of one place after the other, each beginning at 0
};

/// If there are more than `most` fibers, only some are returned, and no choices. most: at most 65536.
Assignment assignment(const Scene& scene, double ratio, std::size_t most) {
  Assignment all;
  all.choices.resize(scene.grooms.size());
  std::map<FiberKey, std::uint32_t> lower;                     // the numbers of keys that are rounded down
  std::unordered_map<std::uint64_t, std::uint32_t> of_raised;  // the number of a lower key with raised steps
  auto last = lower.end();
  std::vector<Raised> raises;
  for_each_place(scene, ratio, [&](std::size_t groom, const BetweenSteps& between) {
    if (last == lower.end() || between.key != last->first)
      last = lower.try_emplace(between.key, static_cast<std::uint32_t>(lower.size())).first;
    set_raised(between, &raises);
    for (const Raised& now : raises) {
      const auto [of, is_new] = of_raised.try_emplace(std::uint64_t{last->second} << 32 | now.places, 0);
      if (is_new) {
        FiberKey key = between.key;
        for (std::size_t place = 0; place < varying; ++place)
          if ((now.places >> place & 1) != 0) key.steps[place] = raised(key.steps[place]);
        of->second = all.keys.try_emplace(key, static_cast<std::uint32_t>(all.keys.size())).first->second;
      }
      all.choices[groom].push_back({static_cast<std::uint16_t>(now.from), static_cast<std::uint16_t>(of->second)});
    }
    return all.keys.size() <= most;
  });
  if (all.keys.size() > most) return all;
  std::vector<std::uint16_t> order(all.keys.size());
  std::uint32_t next = 0;
  for (auto& [key, index] : all.keys) {
    order[index] = static_cast<std::uint16_t>(next);
    index = next++;
  }
  for (auto& choices : all.choices)
    for (FiberChoice& choice : choices) choice.fiber = order[choice.fiber];
  return all;
}

/// Gives all places of a groom as many choices.
void set_choices(const std::vector<FiberChoice>& choices, Groom* groom) {
  std::uint32_t most = 0, now = 0;
  for (const FiberChoice& choice : choices) {
    now = choice.from == 0 ? 1 : now + 1;
    most = std::max(most, now);
  }
  groom->choices_a_station = choices.size() > 1 ? most : 0;
  groom->choices.clear();
  for (std::size_t i = 0; i < choices.size(); ++i) {
    groom->choices.push_back(choices[i]);
    if (i + 1 < choices.size() && choices[i + 1].from != 0) continue;
    while (groom->choices.size() % most != 0) groom->choices.push_back(choices[i]);
  }
}

/// Each shape of a material's strands costs some 0.2 s of CPU. From eight shapes on they share the paths of eight, down
/// to an eighth for each, because their noise is not visible among other strands of their material. Only the material
/// decides, so that other materials do not change it.
std::map<std::uint32_t, float> energy_path_shares(const std::map<FiberKey, std::uint32_t>& keys) {
  std::map<std::uint32_t, std::set<std::vector<int>>> shapes;
  for (const auto& [key, index] : keys)
    shapes[key.material].insert({key.steps.begin(), key.steps.begin() + the_roughness + 1});
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
    bytes += groom.color.size() * sizeof(glm::vec3);
  }

  double ratio = color_ratio;
  const auto is_coarsest = [&] { return !any_source || ratio * ratio > largest_color_ratio; };
  const auto assigned_now = [&] { return assignment(*scene, ratio, is_coarsest() ? 65536 : most_fibers); };
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
  const std::map<std::uint32_t, float> shares = energy_path_shares(keys);
  for (const auto& [key, index] : keys) {
    scene->fibers.push_back(fiber_of(*scene, key, ratio));
    scene->fibers.back().energy_path_share = shares.at(key.material);
  }
  for (std::size_t g = 0; g < scene->grooms.size(); ++g) {
    Groom& groom = scene->grooms[g];
    set_choices(assigned.choices[g], &groom);
    assigned.choices[g] = {};
    if (groom.stations_a_segment > 0) bytes += sizeof(FiberChoice) * groom.choices.size();
  }
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
