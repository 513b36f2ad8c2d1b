#include "scene/generate/generated_grooms.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "base/pi.h"
#include "scene/generate/head_grooms.h"
#include "scene/model/parameters.h"

namespace tress::scene {
namespace {

struct Kind {
  std::string name;
  std::uint32_t strands;
  std::uint32_t points;  ///< per strand, at least
  Groom (*generate)(const GroomShape&);
  std::vector<ShapeParameter> parameters;
};

constexpr double points_per_wave = 10;
constexpr std::uint32_t most_points_per_strand = 512;

/// Makes a shape parameter with the key's range in the parameter table.
ShapeParameter shape(const char* key, double usual) {
  const Range& range = parameter_at(std::string("/grooms/0/") + key)->range;
  return {key, range.least, range.most, usual};
}
ShapeParameter length(double usual) { return shape("length_cm", usual); }
ShapeParameter clump(double usual) { return shape("clump", usual); }
ShapeParameter frizz(double usual) { return shape("frizz", usual); }
ShapeParameter length_variation(double usual) { return shape("length_variation", usual); }
ShapeParameter wavelength(double usual) { return shape("wavelength_cm", usual); }
ShapeParameter curl_diameter(double usual) { return shape("curl_diameter_cm", usual); }

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all{
      {"curly_lock",
       5513,
       72,
       curly_lock,
       {length(24), length_variation(0.14), wavelength(3.85), curl_diameter(1.9), clump(0.8), frizz(0.15)}},
      {"straight", 19226, 28, head_groom, {length(32), length_variation(0.1), clump(0.45), frizz(0.15)}},
      {"wavy",
       19226,
       28,
       head_groom,
       {length(30), length_variation(0.14), wavelength(6), shape("wave_amplitude_cm", 0.55), clump(0.7), frizz(0.25)}},
      {"curly",
       19226,
       28,
       head_groom,
       {length(24), length_variation(0.2), wavelength(4), curl_diameter(1.7), clump(0.9), frizz(0.15)}},
      {"layered",
       100000,
       40,
       layered_hair,
       {length(30), length_variation(0.2), wavelength(9), shape("wave_amplitude_cm", 0.55), curl_diameter(0),
        clump(0.6), frizz(0.12)}},
      {"curtain",
       60000,
       48,
       curtain,
       {length(26), length_variation(0.2), wavelength(8), shape("wave_amplitude_cm", 0.8), curl_diameter(0),
        shape("width_cm", 12), clump(0.6), frizz(0.1)}},
      {"fur_ball",
       40000,
       14,
       fur_ball,
       {length(2.2), length_variation(0.3), shape("ball_radius_cm", 5), clump(0.6), frizz(0.25)}},
      {"single_fiber", 1, 16, single_fiber, {length(10)}}};
  return all;
}

const Kind& groom_kind(const std::string& name) {
  const auto found = std::find_if(kinds().begin(), kinds().end(), [&](const Kind& kind) { return kind.name == name; });
  assert(found != kinds().end());
  return found == kinds().end() ? kinds().back() : *found;
}

/// Root uv of strands around the origin: longitude, with +y (the face) at 0.5, and latitude.
void map_round(Groom* groom) {
  for (std::size_t s = 0; s < groom->root_uv.size(); ++s) {
    const glm::vec3 root = glm::normalize(groom->points[groom->first_point[s]]);
    groom->root_uv[s] = {std::clamp(0.5f + std::atan2(-root.x, root.y) / (2 * pi_f), 0.0f, 1.0f),
                         0.5f + std::asin(std::clamp(root.z, -1.0f, 1.0f)) / pi_f};
  }
}

/// Root uv of strands that hang: the roots' box seen from above, with x to the right and y upwards.
void map_flat(Groom* groom) {
  constexpr float large = std::numeric_limits<float>::max();
  glm::vec2 least(large), most(-large);
  for (std::size_t s = 0; s < groom->root_uv.size(); ++s) {
    groom->root_uv[s] = glm::vec2(groom->points[groom->first_point[s]]);
    least = glm::min(least, groom->root_uv[s]);
    most = glm::max(most, groom->root_uv[s]);
  }
  for (glm::vec2& uv : groom->root_uv) {
    for (int i = 0; i < 2; ++i) uv[i] = most[i] > least[i] ? (uv[i] - least[i]) / (most[i] - least[i]) : 0.5f;
  }
}

}  // namespace

const std::vector<std::string>& generated_groom_kinds() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Kind& kind : kinds()) all.push_back(kind.name);
    return all;
  }();
  return names;
}

const std::vector<ShapeParameter>& shape_parameters(const std::string& kind) { return groom_kind(kind).parameters; }
std::uint32_t usual_strands(const std::string& kind) { return groom_kind(kind).strands; }

std::uint32_t points_per_strand(const GroomRecipe& recipe) {
  const Kind& kind = groom_kind(recipe.kind);
  double length_cm = 0, wavelength_cm = 0;
  for (const ShapeParameter& parameter : kind.parameters) {
    const auto given = recipe.shape.find(parameter.key);
    const double value = given == recipe.shape.end() ? parameter.usual : given->second;
    if (parameter.key == "length_cm") length_cm = value;
    if (parameter.key == "wavelength_cm") wavelength_cm = value;
  }
  if (!(wavelength_cm > 0)) return kind.points;
  const double wanted = std::min<double>(points_per_wave * length_cm / wavelength_cm, most_points_per_strand);
  return std::max(kind.points, static_cast<std::uint32_t>(wanted));
}

Groom generate_groom(const GroomRecipe& recipe) {
  const Kind& kind = groom_kind(recipe.kind);
  GroomShape shape;
  shape.strands = recipe.strands.value_or(kind.strands);
  shape.seed = recipe.seed;
  shape.radius_cm = static_cast<float>(recipe.radius_cm);
  shape.points = points_per_strand(recipe);
  for (const ShapeParameter& parameter : kind.parameters) {
    const auto given = recipe.shape.find(parameter.key);
    shape.values[parameter.key] = given == recipe.shape.end() ? parameter.usual : given->second;
  }
  Groom groom = kind.generate(shape);
  groom.name = recipe.kind;
  groom.root_uv.resize(groom.strand_count());
  const bool is_round = kind.generate == head_groom || kind.generate == layered_hair || kind.generate == fur_ball;
  is_round ? map_round(&groom) : map_flat(&groom);
  return groom;
}

}  // namespace tress::scene
