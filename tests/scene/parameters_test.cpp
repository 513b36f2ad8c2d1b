// One table of parameters: what scenes/schema.json, scenes/KEYS.md and the readers say is what it says.
#include "scene/model/parameters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "scene/parameter_documents.h"
#include "scene/read/load_scene.h"

namespace tress::scene {
namespace {

std::filesystem::path scenes() { return std::filesystem::path(TRESS_SOURCE_DIR) / "scenes"; }

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(Parameters, HaveASentenceEachAndARangeWithoutGaps) {
  std::set<std::string> names;
  for (const Parameter& parameter : parameters()) {
    const std::string name(parameter.key.empty() ? parameter.option : parameter.key);
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_FALSE(parameter.sentence.empty()) << name;
    const bool of_numbers = parameter.kind != ValueKind::choice && parameter.kind != ValueKind::text &&
                            parameter.kind != ValueKind::flag && parameter.kind != ValueKind::only_true;
    EXPECT_EQ(parameter.range.least < parameter.range.most, of_numbers) << name;
    if (!parameter.option.empty()) {
      EXPECT_EQ(&option_parameter(parameter.option), &parameter) << name;
    }
    if (!parameter.key.empty()) {
      EXPECT_EQ(parameter_at(parameter.key), &parameter) << name;
    }
  }
  EXPECT_EQ(parameter_at("/materials/17/eta"), parameter_at("/materials/N/eta"));
  EXPECT_EQ(parameter_at("/materials/0/gain/GLINT"), parameter_at("/materials/N/gain"));
  EXPECT_EQ(parameter_at("/materials/0/gain/GLINTS"), nullptr);
  EXPECT_EQ(parameter_at("/materials/0/eta/R"), nullptr);
  EXPECT_EQ(parameter_at("/camera/frames/3/eye"), parameter_at("/camera/eye"));
  EXPECT_EQ(parameter_at("eta"), nullptr);
}

TEST(Parameters, KeysOfAnObjectAreThoseOfTheTable) {
  using Keys = std::vector<std::string>;
  EXPECT_EQ(keys_at("/materials/17/cortex"), (Keys{"scattering", "asymmetry"}));
  EXPECT_EQ(keys_at("/materials/17/medulla"), (Keys{"radius", "scattering", "asymmetry", "absorption"}));
  EXPECT_EQ(keys_at("/materials/0/azimuthal_sigma_deg"), (Keys{"TT", "TRT", "TRRT"}));
  EXPECT_EQ(keys_at("/environment/sky/sun"), keys_at("/lights/0/distant"));
  EXPECT_EQ(keys_at("/environment/shadow_link"), (Keys{"include", "exclude"}));
  EXPECT_EQ(keys_at("/lights/0/frames/3"), (Keys{"frame", "scale", "rotate_deg", "translate"}));
  EXPECT_EQ(keys_at("").front(), "$schema");
  EXPECT_EQ(std::ranges::count(keys_at(""), "SOURCE"), 0);
  EXPECT_EQ(choices_of(*parameter_at("/materials/0/longitudinal_shape")), (Keys{"logistic", "gaussian", "cauchy"}));
  EXPECT_TRUE(choices_of(*parameter_at("/materials/0/eta")).empty());
  EXPECT_TRUE(keys_at("/materials/0/eta").empty());
  EXPECT_TRUE(keys_at("/materials/0/longitudinal_shape").empty());
}

// TRESS_REWRITE=1 in the environment writes both documents as the table has them, in place of comparing.
void expect_document(const char* name, const std::string& wanted) {
  const auto file = std::filesystem::path(TRESS_SOURCE_DIR) / "scenes" / name;
  if (std::getenv("TRESS_REWRITE") != nullptr) std::ofstream(file) << wanted;
  EXPECT_EQ(text_of(file), wanted) << "TRESS_REWRITE=1 " << testing::internal::GetArgvs()[0]
                                   << " --gtest_filter=Parameters.* writes it";
}

TEST(Parameters, TheSchemaHasTheirRangesAndSentences) {
  auto schema = nlohmann::ordered_json::parse(text_of(scenes() / "schema.json"));
  EXPECT_GT(describe_values(&schema, ""), 100);
  expect_document("schema.json", schema.dump(1) + "\n");
}

/// A key of the table that the schema lacks is added to it as it was.
TEST(Parameters, TheSchemaGetsTheKeysThatItLacks) {
  const auto schema = nlohmann::ordered_json::parse(text_of(scenes() / "schema.json"));
  const nlohmann::ordered_json::json_pointer properties("/properties/materials/items/properties");
  for (const char* key : {"eta", "presence", "twist", "root_angle_deg", "sigma_a", "glint", "name", "fresnel"}) {
    auto lacks = schema;
    lacks[properties].erase(key);
    ASSERT_GT(describe_values(&lacks, ""), 100);
    EXPECT_EQ(lacks[properties][key], schema[properties][key]) << key;
  }
}

TEST(Parameters, TheTablesOfTheManualAreTheirs) {
  std::string manual = text_of(scenes() / "KEYS.md");
  ASSERT_TRUE(replace_table(scene_keys_as_markdown(), &manual));
  ASSERT_TRUE(replace_table(generated_grooms_as_markdown(), &manual));
  expect_document("KEYS.md", manual);
}

/// What a message says of a range is the range: both ends are taken, what is next to them is not.
TEST(Parameters, OptionsOverASceneTakeTheEndsOfTheirRangesAndNothingBeyond) {
  const auto file = scenes() / "furnace.json";
  using Set = void (*)(Overrides&, double);
  const std::vector<std::pair<const char*, Set>> options{
      {"--color", [](Overrides& o, double x) { o.color = glm::vec3(static_cast<float>(x)); }},
      {"--melanin", [](Overrides& o, double x) { o.melanin = {0.0f, static_cast<float>(x)}; }},
      {"--sigma-a", [](Overrides& o, double x) { o.sigma_a = glm::vec3(0, 0, static_cast<float>(x)); }},
      {"--eccentricity", [](Overrides& o, double x) { o.eccentricity = static_cast<float>(x); }},
      {"--roughness", [](Overrides& o, double x) { o.roughness = static_cast<float>(x); }},
      {"--cm-per-unit", [](Overrides& o, double x) { o.cm_per_unit = x; }},
      {"--spp", [](Overrides& o, double x) { o.samples = static_cast<int>(x); }},
      {"--resolution", [](Overrides& o, double x) { o.width = static_cast<int>(x), o.height = 1; }}};
  for (const auto& [option, set] : options) {
    const Parameter& parameter = option_parameter(option);
    const double step = parameter.kind == ValueKind::whole ? 1 : 1e-3 * (parameter.range.most - parameter.range.least);
    for (const double x : {parameter.range.least, parameter.range.most}) {
      Overrides overrides;
      set(overrides, x);
      const auto scene = load_scene(file, overrides);
      EXPECT_TRUE(scene) << option << " " << x << ": " << scene.error().message();
    }
    for (const double x : {parameter.range.least - step, parameter.range.most + step}) {
      Overrides overrides;
      set(overrides, x);
      const auto scene = load_scene(file, overrides);
      ASSERT_FALSE(scene) << option << " " << x;
      EXPECT_EQ(scene.error().place, option);
      EXPECT_EQ(scene.error().expected, words(parameter));
    }
  }
  Overrides large;
  large.width = large.height = 65536;
  ASSERT_FALSE(load_scene(file, large));
  EXPECT_EQ(load_scene(file, large).error().place, "--resolution");
}

}  // namespace
}  // namespace tress::scene
