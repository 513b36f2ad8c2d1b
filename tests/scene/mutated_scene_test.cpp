// Damaged scene files: read or refused with a message, never a crash, a hang or memory without bound.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "scene/read/scene_file.h"
#include "tress/base/random.h"

namespace tress::scene {
namespace {

/// The scenes of the project, and one that has a little of everything.
std::vector<std::string> whole_texts() {
  std::vector<std::string> texts{R"({
    "camera": {"frames": [{"frame": 1, "eye": [0, -50, 3]}, {"frame": 9, "eye": [5, -50, 3], "vertical_fov_deg": 20}]},
    "image": {"width": 64, "height": 32, "samples": 4}, "environment_visible": false,
    "environment": {"sky": {"zenith": [0.1, 0.2, 0.4], "sun": {"azimuth_deg": 30, "elevation_deg": 40, "angle_deg": 2,
      "irradiance": [3, 3, 2.5]}}, "rotate_deg": 20, "scale": 1.5},
    "lights": [{"sphere": {"center": [1, 2, 3], "radius_cm": 4, "radiance": [5, 6, 7]}},
      {"rectangle": {"center": [0, 0, 10], "look_at": [0, 0, 0], "width_cm": 6, "height_cm": 2, "radiance": [1, 1, 1]}}],
    "meshes": [{"file": "head.obj", "up": "y", "cm_per_unit": 2.54, "translate": [0, 0, 1], "albedo": [0.2, 0.2, 0.2]}],
    "materials": [{"name": "a", "eta": 1.5, "gain": {"R": 2, "GLINT": 3}, "tint": {"TT": [1, 0.5, 0.25]},
      "melanin": {"eumelanin": 1.3}, "azimuthal_sigma_deg": {"TT": 5}, "fresnel": "none"}],
    "grooms": [{"generate": "straight", "strands": 100, "material": "a"}, {"file": "b.hair", "up": "y"}]})"};
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(TRESS_SOURCE_DIR) / "scenes"))
    if (entry.path().extension() == ".json" && entry.path().filename() != "schema.json") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    std::ifstream stream(file);
    texts.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return texts;
}

Result<SceneDescription> parse(const std::string& text) {
  return parse_scene_file(std::vector<unsigned char>(text.begin(), text.end()), "s.json");
}

void mutate(std::string* text, const std::vector<std::string>& texts, RandomStream& random) {
  static const std::string splices[] = {"1e999", "-1e999",  "NaN",  "null",     "-",          "99999999999999999999",
                                        "[[[[",  "{\"a\":", "\"",   "\\ud800",  "\xff\xfe",   std::string(1, '\0'),
                                        "[]",    "{}",      "true", "1e-400",   "0x10",       ",",
                                        "]}",    "-0",      "2.5",  "\"file\"", "\"frames\"", "1000000"};
  const std::size_t at = random.next_bits() % (text->size() + 1);
  const std::size_t size = std::min<std::size_t>(random.next_bits() % 12, text->size() - at);
  switch (random.next_bits() % 6) {
    case 0:
      if (at < text->size()) (*text)[at] = static_cast<char>(random.next_bits());
      break;
    case 1:
      text->erase(at, size);
      break;
    case 2:
      text->insert(at, text->substr(at, size));
      break;
    case 3:
      text->replace(at, size, splices[random.next_bits() % std::size(splices)]);
      break;
    case 4: {  // another number, word or text of any of the scenes
      const std::string& other = texts[random.next_bits() % texts.size()];
      text->replace(at, size, other.substr(random.next_bits() % other.size(), random.next_bits() % 40));
      break;
    }
    default:
      if (random.next_bits() % 8 == 0) text->resize(at);
  }
}

/// Seed 41; 20,000 texts with one to four changes. The description stays as small as its text.
TEST(MutatedScene, IsReadOrRefusedByName) {
  const auto texts = whole_texts();
  for (const auto& text : texts) ASSERT_TRUE(parse(text)) << parse(text).error().message();
  RandomStream random(41);
  int read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text = texts[random.next_bits() % texts.size()];
    for (auto n = random.next_bits() % 4 + 1; n > 0; --n) mutate(&text, texts, random);
    const auto scene = parse(text);
    if (!scene) {
      const auto& error = scene.error();
      ASSERT_EQ(error.file, "s.json");
      ASSERT_FALSE(error.place.empty() && error.expected.empty()) << text;
      ASSERT_LT(error.message().size(), 1000u) << error.message();
      continue;
    }
    ++read;
    ASSERT_LE(scene->grooms.size() + scene->materials.size() + scene->lights.size() + scene->camera.keys.size(),
              text.size());
    ASSERT_GE(scene->image.width, 1);
    ASSERT_GT(scene->camera.camera.vertical_fov_deg, 0);
  }
  EXPECT_GT(read, 300);
  EXPECT_LT(read, 19000);
}

TEST(MutatedScene, RefusesDeepAndLongDocuments) {
  const std::string groom = R"("grooms": [{"generate": "single_fiber"}])";
  EXPECT_FALSE(parse(std::string(1'000'000, '[')));
  EXPECT_FALSE(parse(R"({"lights": )" + std::string(100'000, '[') + std::string(100'000, ']') + ", " + groom + "}"));
  std::string many = R"({"lights": [)";
  for (int i = 0; i < 200'000; ++i) many += "0,";
  const auto scene = parse(many + "0], " + groom + "}");
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().message(), "s.json: /lights: expected an array of at most 1024, found an array of 200001");
}

}  // namespace
}  // namespace tress::scene
