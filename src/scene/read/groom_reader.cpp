#include "scene/read/groom_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>

#include "scene/read/grooms/given_basis.h"
#include "scene/read/scene_file.h"
#include "scene/read/source_reader.h"

namespace tress::scene {
namespace {

constexpr std::size_t most_looks = 64;
constexpr std::uint64_t most_generated_points = 100'000'000;
constexpr Taper usual_generated_taper{.root = 1, .tip = 0.4};

/// The keys that shape any kind of groom, each once.
std::vector<std::string> shape_keys() {
  std::vector<std::string> keys;
  for (const std::string& kind : generated_groom_kinds())
    for (const ShapeParameter& parameter : shape_parameters(kind))
      if (std::find(keys.begin(), keys.end(), parameter.key) == keys.end()) keys.push_back(parameter.key);
  return keys;
}

void read_recipe(const JsonReader& json, GroomRecipe* recipe) {
  if (const auto x = json.integer("strands")) recipe->strands = static_cast<std::uint32_t>(*x);
  recipe->seed = static_cast<std::uint64_t>(json.integer("seed").value_or(0));
  recipe->radius_cm = json.number("radius_cm").value_or(recipe->radius_cm);
  std::vector<std::string> keys;
  for (const ShapeParameter& parameter : shape_parameters(recipe->kind)) {
    keys.push_back(parameter.key);
    if (const auto x = json.number(parameter.key)) recipe->shape[parameter.key] = *x;
  }
  for (const std::string& key : shape_keys())
    if (json.has(key) && std::find(keys.begin(), keys.end(), key) == keys.end())
      json.fail(key, fmt::format("a key that shapes \"{}\" ({})", recipe->kind, fmt::join(keys, ", ")), "another");
  const std::uint64_t points =
      std::uint64_t{recipe->strands.value_or(usual_strands(recipe->kind))} * points_per_strand(*recipe);
  if (points > most_generated_points)
    json.fail(json.has("strands") ? "strands" : "",
              fmt::format("at most {} points, at {} a strand", most_generated_points, points_per_strand(*recipe)),
              fmt::format("{}", points));
}

Taper read_taper(const JsonReader& json, Taper taper) {
  if (!json.has("taper")) return taper;
  const auto given = json.child("taper");
  if (!given.object()) return taper;
  return {.root = given.number("root").value_or(1), .tip = given.number("tip").value_or(1)};
}

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

std::vector<GroomLook> read_looks(const JsonReader& json, const std::vector<Material>& materials) {
  std::vector<GroomLook> looks;
  float sum = 0;
  for (const auto& item : json.items("looks", most_looks)) {
    if (!item.object() || !item.need({"material", "share"})) return looks;
    looks.push_back(
        {read_material_reference(item, materials), read_source(item, "share", read_number(glm::vec3(1.0f)))});
    if (looks.back().share.kind == Source::Kind::constant) sum += looks.back().share.value.x;
  }
  if (sum > 1 + 1e-6f) json.fail("looks", "shares of at most 1 together", fmt::format("{:g}", sum));
  return looks;
}

/// The attributes of the file that the materials and the shares of a groom use, each once.
std::vector<std::string> attributes_of(const GroomDescription& groom, const std::vector<Material>& materials) {
  std::vector<std::string> names;
  const auto add = [&](std::uint32_t material) {
    if (material >= materials.size()) return;
    for (const std::string& name : attributes_of(materials[material]))
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  add(groom.material);
  for (const GroomLook& look : groom.looks) {
    add(look.material);
    look.share.add_attributes(&names);
  }
  return names;
}

}  // namespace

GroomDescription read_groom(const JsonReader& json, const std::vector<Material>& materials) {
  GroomDescription groom;
  if (!json.object() || !json.at_most_one({"file", "generate"})) return groom;
  groom.name = json.text("name");
  groom.file = json.text("file");
  const auto kind = json.choice("generate", generated_groom_kinds());
  if (!json.has("file") && !json.has("generate")) json.fail("", "one of file, generate", "neither");
  if (kind) {
    for (const char* key : {"up", "cm_per_unit", "points_per_strand", "normals", "widths"})
      if (json.has(key)) json.fail(key, "this key beside \"file\" only", "it beside \"generate\"");
    groom.recipe.kind = *kind;
    read_recipe(json, &groom.recipe);
    groom.taper = read_taper(json, *kind == "single_fiber" ? Taper{} : usual_generated_taper);
  } else {
    std::vector<std::string> generated = shape_keys();
    generated.insert(generated.begin(), {"strands", "seed"});
    for (const std::string& key : generated)
      if (json.has(key)) json.fail(key, "this key beside \"generate\" only", "it beside \"file\"");
    if (const auto up = json.choice("up")) groom.placement.y_up = *up == "y";
    groom.placement.cm_per_unit = json.number("cm_per_unit");
    groom.placement.normals = json.boolean("normals").value_or(true);
    if (const auto points = json.integer("points_per_strand"))
      groom.points_per_strand = static_cast<std::uint32_t>(*points);
    groom.placement.radius_cm = json.number("radius_cm");
    if (const auto text = json.text("widths")) {
      const auto use = width_use_of(*text);
      if (!use) json.fail("widths", width_use_words, "\"" + text->substr(0, 64) + "\"");
      groom.placement.widths = use.value_or(WidthUse{});
    }
    groom.taper = read_taper(json, {});
  }
  if (const auto basis = json.choice("basis", basis_names())) {
    groom.placement.basis = kind_of_basis(*basis);
    if (kind && (*basis == "bezier" || *basis == "hermite"))
      json.fail("basis", "another basis beside \"generate\", whose points are on the strands", "\"" + *basis + "\"");
  }
  groom.path = read_path(json);
  for (const auto& item : json.items("instances", most_instances)) {
    if (!item.object()) return groom;
    groom.instances.push_back(read_path(item));
  }
  if (json.has("instances") && groom.instances.empty()) json.fail("instances", "one instance or more", "none");
  groom.visibility = read_visibility(json);
  groom.material = read_material_reference(json, materials);
  groom.looks = read_looks(json, materials);
  const std::vector<std::string> attributes = attributes_of(groom, materials);
  if (attributes.size() > 1)
    json.fail("looks", "one attribute of the file in all materials and shares",
              fmt::format("\"{}\"", fmt::join(attributes, "\", \"")));
  for (const std::string& name : attributes) {
    groom.placement.colors = true;
    groom.placement.attribute = name;
    if (!kind) continue;
    json.fail(groom.looks.empty() ? "material" : "looks", "colors and numbers, beside \"generate\"",
              name.empty() ? "\"color\": \"file\"" : "an attribute of a file");
  }
  return groom;
}

}  // namespace tress::scene
