#include "scene/groom_reader.h"

#include <fmt/format.h>

#include <cstdint>

namespace tress::scene {
namespace {

constexpr std::int64_t most_generated_strands = 1'000'000;

std::uint32_t read_material_reference(const JsonReader& json, const std::vector<Material>& materials) {
  if (!json.has("material")) return 0;
  std::vector<std::string> names;
  for (const auto& material : materials) names.push_back(material.name);
  const auto name = json.text("material");
  for (std::uint32_t m = 0; name && m < names.size(); ++m)
    if (names[m] == *name) return m;
  if (name)
    json.fail("material", fmt::format("a name of /materials (the nearest is \"{}\")", nearest_name(*name, names)),
              fmt::format("\"{}\"", name->substr(0, 64)));
  return 0;
}

}  // namespace

GroomDescription read_groom(const JsonReader& json, const std::vector<Material>& materials) {
  GroomDescription groom;
  if (!json.object({"file", "generate", "strands", "seed", "length_cm", "radius_cm", "up", "cm_per_unit", "material"}))
    return groom;
  if (!json.at_most_one({"file", "generate"})) return groom;
  groom.file = json.text("file");
  const auto kind = json.choice("generate", generated_groom_kinds());
  if (!json.has("file") && !json.has("generate")) json.fail("", "one of file, generate", "neither");
  for (const char* key : {"up", "cm_per_unit"})
    if (kind && json.has(key)) json.fail(key, "this key beside \"file\" only", "it beside \"generate\"");
  for (const char* key : {"strands", "seed", "length_cm"})
    if (groom.file && json.has(key)) json.fail(key, "this key beside \"generate\" only", "it beside \"file\"");
  if (const auto up = json.choice("up", {"y", "z"})) groom.placement.y_up = *up == "y";
  groom.placement.cm_per_unit = json.number("cm_per_unit", 1e-6, 1e6);
  const auto radius = json.number("radius_cm", 1e-4, 1);
  groom.placement.radius_cm = radius;
  groom.recipe.kind = kind.value_or("");
  if (const auto x = json.integer("strands", 1, most_generated_strands))
    groom.recipe.strands = static_cast<std::uint32_t>(*x);
  groom.recipe.seed = static_cast<std::uint64_t>(json.integer("seed", 0, INT64_MAX).value_or(0));
  groom.recipe.length_cm = json.number("length_cm", 0.1, 1000);
  groom.recipe.radius_cm = radius.value_or(groom.recipe.radius_cm);
  groom.material = read_material_reference(json, materials);
  return groom;
}

}  // namespace tress::scene
