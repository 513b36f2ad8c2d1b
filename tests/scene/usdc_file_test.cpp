// Binary USD: each text of crates/ gives the same strands as a crate of any version, and no byte of one can do harm.
// The crates are made by tests/scene/grooms/crate_writer.py.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/groom_fixture.h"
#include "scene/read/groom_files.h"
#include "scene/read/grooms/groom_formats.h"
#include "scene/read/grooms/usd_file.h"

namespace tress::scene {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

namespace fs = std::filesystem;
using Bytes = std::vector<unsigned char>;

Bytes bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

fs::path text_of(const fs::path& crate) {
  for (const char* folder : {".", "bases", "../faults"})
    if (const fs::path text = fixture(folder) / crate.filename().replace_extension(".usda"); fs::exists(text))
      return text;
  return {};
}

std::vector<std::string> names_of(const std::vector<IgnoredAttribute>& ignored) {
  std::vector<std::string> names;
  for (const IgnoredAttribute& one : ignored) names.push_back(one.name + ": " + one.why);
  return names;
}

void expect_same(const GroomFile& crate, const GroomFile& text, const std::string& name) {
  EXPECT_EQ(crate.cm_per_unit, text.cm_per_unit) << name;
  EXPECT_EQ(crate.y_up, text.y_up) << name;
  EXPECT_EQ(crate.basis, text.basis) << name;
  EXPECT_EQ(crate.first_point, text.first_point) << name;
  EXPECT_EQ(crate.points, text.points) << name;
  EXPECT_EQ(crate.width, text.width) << name;
  EXPECT_EQ(crate.default_width, text.default_width) << name;
  EXPECT_EQ(crate.color, text.color) << name;
  EXPECT_EQ(crate.normal, text.normal) << name;
  EXPECT_EQ(crate.id, text.id) << name;
  EXPECT_EQ(crate.root_uv, text.root_uv) << name;
  EXPECT_EQ(crate.broken, text.broken) << name;
  EXPECT_EQ(crate.remarks, text.remarks) << name;
  EXPECT_EQ(crate.materials, text.materials) << name;
  EXPECT_EQ(crate.is_animated, text.is_animated) << name;
  EXPECT_EQ(names_of(crate.ignored), names_of(text.ignored)) << name;
  ASSERT_EQ(crate.shared.size(), text.shared.size()) << name;
  for (std::size_t i = 0; i < text.shared.size(); ++i) EXPECT_EQ(crate.shared[i].places, text.shared[i].places) << name;
  ASSERT_EQ(crate.parts.size(), text.parts.size()) << name;
  for (std::size_t i = 0; i < text.parts.size(); ++i) {
    EXPECT_EQ(crate.parts[i].name, text.parts[i].name) << name;
    EXPECT_EQ(crate.parts[i].strands, text.parts[i].strands) << name;
    EXPECT_EQ(crate.parts[i].instances, text.parts[i].instances) << name;
    EXPECT_EQ(crate.parts[i].curve, text.parts[i].curve) << name;
  }
}

TEST(UsdcFile, EveryCrateHasTheStrandsOfItsText) {
  int crates = 0;
  for (const auto& entry : fs::directory_iterator(fixture("crates"))) {
    if (entry.path().extension() != ".usdc") continue;
    const std::string name = entry.path().filename().string();
    const fs::path text = name == "types_8.usdc" ? fixture("types.usda") : text_of(entry.path());
    ASSERT_FALSE(text.empty()) << name;
    for (const std::optional<double> frame : {std::optional<double>(), {0.0}, {1.0}, {1.5}, {2.0}, {9.0}}) {
      const auto read = read_groom_file(entry.path(), {}, frame), expected = read_groom_file(text, {}, frame);
      ASSERT_TRUE(read) << read.error().message();
      ASSERT_TRUE(expected) << expected.error().message();
      expect_same(*read, *expected, name);
    }
    ++crates;
  }
  EXPECT_EQ(crates, 23);
}

TEST(UsdcFile, EveryTruncationIsRefused) {
  const Bytes whole = bytes_of(fixture("crates/types.usdc"));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const auto groom = read_usdc({.bytes = cut, .name = "cut.usdc"});
    ASSERT_FALSE(groom) << size;  // the table of contents is at the end
    EXPECT_THAT(groom.error().message(), HasSubstr("cut.usdc: ")) << size;
  }
}

/// Points may come from what is packed, but not more than all bytes of the file allow (usd_file.cpp).
TEST(UsdcFile, EveryChangedByteIsRefusedOrRead) {
  for (const char* name : {"crates/types.usdc", "crates/flatinst.usdc", "crates/same.usdz"}) {
    Bytes bytes = bytes_of(fixture(name));
    const bool is_archive = std::string(name).ends_with(".usdz");
    int read = 0;
    for (unsigned char& byte : bytes)
      for (const unsigned change : {0x01u, 0x80u, 0xffu}) {
        const unsigned char before = byte;
        byte = static_cast<unsigned char>(byte ^ change);
        const auto groom = (is_archive ? read_usdz : read_usdc)({.bytes = bytes, .name = "changed.usd"});
        byte = before;
        if (groom)
          EXPECT_LE(groom->points.size(), 2 * bytes.size() + 16);
        else
          EXPECT_THAT(groom.error().message(), HasSubstr("changed.usd"));
        read += groom ? 1 : 0;
      }
    EXPECT_GT(read, 100) << name;
  }
}

TEST(UsdcFile, ValuesOfTypesThatAreNotReadAreNamed) {
  const auto groom = read_groom_file(fixture("unread.usdc"));
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_THAT(names_of(groom->ignored),
              ElementsAre("primvars:displayColor: values of the crate's type 12 are not read"));
}

TEST(UsdcFile, OfAnArchiveTheFirstLayerIsRead) {
  const auto archive = read_groom_file(fixture("crates/same.usdz")),
             crate = read_groom_file(fixture("crates/same.usdc")),
             of_text = read_groom_file(fixture("crates/same_text.usdz"));
  ASSERT_TRUE(archive) << archive.error().message();
  ASSERT_TRUE(of_text) << of_text.error().message();
  EXPECT_EQ(archive->points, crate->points);
  EXPECT_EQ(of_text->points, crate->points);
  EXPECT_THAT(names_of(archive->ignored),
              UnorderedElementsAre("textures/a.png: of a .usdz the first layer and those that it needs are read",
                                   "b.usda: of a .usdz the first layer and those that it needs are read"));
}

/// Sublayers, references to a default prim and to a path, and layers that these refer to.
TEST(UsdcFile, LayersOfAnArchiveAreFollowed) {
  const auto groom = read_groom_file(fixture("crates/package.usdz"));
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_EQ(groom->cm_per_unit, 1);
  ASSERT_EQ(groom->parts.size(), 4u);
  EXPECT_EQ(groom->parts[0].name, "/a/h");
  EXPECT_EQ(groom->parts[1].name, "/b/h");
  EXPECT_EQ(groom->points[0], glm::vec3(0));
  EXPECT_EQ(groom->parts[2].name, "/b/deep");
  EXPECT_EQ(groom->parts[3].name, "/b/more");
  EXPECT_EQ(groom->points[2], glm::vec3(1, 0, 0));
  EXPECT_EQ(groom->points[4], glm::vec3(1, 8, 0));
  EXPECT_EQ(groom->points[6], glm::vec3(10, 0, 0));
  EXPECT_THAT(groom->width,
              ElementsAre(1, 2, 0.5f, 0.25f, width_not_said, width_not_said, width_not_said, width_not_said))
      << "a sublayer is stronger than what a prim refers to";
  EXPECT_EQ(groom->color_at(0, 0), glm::vec3(1, 0, 0));
  EXPECT_THAT(names_of(groom->ignored),
              UnorderedElementsAre("b: what a sublayer refers to is added to what the layer above refers to",
                                   "looks/none.usda: this sublayer is not in the archive, or in itself",
                                   "/c: what it refers to is not there: @geo/none.usda@/m",
                                   "a.png: of a .usdz the first layer and those that it needs are read",
                                   "spare.usda: of a .usdz the first layer and those that it needs are read"));
}

TEST(UsdcFile, ALayerInAnArchiveIsNamedAsUsdNamesIt) {
  Bytes bytes = bytes_of(fixture("crates/same.usdz"));
  const std::string mark = "PXR-USDC";
  const auto layer = std::search(bytes.begin(), bytes.end(), mark.begin(), mark.end());
  ASSERT_NE(layer, bytes.end());
  layer[9] = 99;  // the version
  const auto groom = read_usdz({.bytes = bytes, .name = "a.usdz"});
  ASSERT_FALSE(groom);
  EXPECT_THAT(groom.error().message(),
              HasSubstr("a.usdz[groom/same.usdc]: byte 10 (the version): expected version 0.4"));
}

}  // namespace
}  // namespace tress::scene
