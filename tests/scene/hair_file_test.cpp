#include "scene/read/grooms/hair_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "scene/generate/generated_grooms.h"
#include "scene/read/assembly.h"
#include "scene/read/grooms/groom_formats.h"
#include "scene/read/input_files.h"
#include "scene/read/load_scene.h"

namespace tress::scene {
namespace {

using Bytes = std::vector<unsigned char>;

template <class T>
void put(Bytes* bytes, std::size_t offset, T value) {
  if (bytes->size() < offset + sizeof value) bytes->resize(offset + sizeof value);
  std::memcpy(bytes->data() + offset, &value, sizeof value);
}

/// Three strands of 3, 2 and 1 points, segments array, no thickness.
Bytes small_file() {
  Bytes bytes(128, 0);
  std::memcpy(bytes.data(), "HAIR", 4);
  put<std::uint32_t>(&bytes, 4, 3);
  put<std::uint32_t>(&bytes, 8, 6);
  put<std::uint32_t>(&bytes, 12, 3);
  put<std::uint16_t>(&bytes, 128, 2);
  put<std::uint16_t>(&bytes, 130, 1);
  put<std::uint16_t>(&bytes, 132, 0);
  for (std::size_t i = 0; i < 18; ++i) put<float>(&bytes, 134 + 4 * i, static_cast<float>(i));
  return bytes;
}

std::string message(const Bytes& bytes) {
  const auto hair = parse_hair_file(bytes, "x.hair");
  return hair ? "" : hair.error().message();
}

TEST(HairFile, ReadsStrands) {
  const auto hair = parse_hair_file(small_file(), "x.hair");
  ASSERT_TRUE(hair);
  EXPECT_EQ(hair->first_point, (std::vector<std::uint32_t>{0, 3, 5, 6}));
  EXPECT_EQ(hair->points[5], glm::vec3(15, 16, 17));
}

TEST(HairFile, ReadsColorsBehindThicknessAndTransparency) {
  auto bytes = small_file();
  put<float>(&bytes, 28, 0.25f);
  EXPECT_EQ(parse_hair_file(bytes, "x.hair")->default_color, glm::vec3(0.25f, 0, 0));
  put<std::uint32_t>(&bytes, 12, 1 + 2 + 4 + 8 + 16);
  const std::size_t thickness = bytes.size(), color = thickness + 2 * 4 * 6;
  for (std::size_t i = 0; i < 6; ++i) put<float>(&bytes, thickness + 4 * i, 0.1f);
  for (std::size_t i = 0; i < 6; ++i) put<float>(&bytes, thickness + 24 + 4 * i, 0.5f);
  for (std::size_t i = 0; i < 18; ++i) put<float>(&bytes, color + 4 * i, static_cast<float>(i) / 10);
  put<float>(&bytes, color + 4, std::nanf(""));
  const auto hair = parse_hair_file(bytes, "x.hair");
  ASSERT_TRUE(hair);
  ASSERT_EQ(hair->color.size(), 6u);
  EXPECT_EQ(hair->color[0], glm::vec3(0, 0, 0.2f));
  EXPECT_EQ(hair->color[2], glm::vec3(0.6f, 0.7f, 0.8f));
  EXPECT_EQ(hair->color[5], glm::vec3(1, 1, 1));

  std::vector<std::string> notes, warnings;
  const auto groom =
      assemble_groom(*hair, {.cm_per_unit = 1.0, .radius_cm = {}, .colors = true}, "x", &notes, &warnings);
  ASSERT_EQ(groom->color.size(), 5u);  // at points; the third strand has one point
  EXPECT_EQ(groom->color[2], hair->color[2]);
  EXPECT_EQ(groom->color[4], hair->color[4]);
}

TEST(HairFile, RefusesEveryTruncation) {
  const Bytes whole = small_file();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::string text = message(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    EXPECT_NE(text.find("x.hair: byte"), std::string::npos) << size;
  }
}

TEST(HairFile, RefusesDamageByByteAndExpectation) {
  auto bytes = small_file();
  bytes[0] = 'X';
  EXPECT_NE(message(bytes).find("byte 0: expected \"HAIR\""), std::string::npos);
  bytes = small_file();
  put<std::uint32_t>(&bytes, 4, 0xffffffffu);
  EXPECT_NE(message(bytes).find("4294967295 strands"), std::string::npos);
  bytes = small_file();
  put<std::uint32_t>(&bytes, 8, 0xffffffffu);
  EXPECT_NE(message(bytes).find("4294967295 points"), std::string::npos);
  bytes = small_file();
  put<std::uint16_t>(&bytes, 128, 65535);
  EXPECT_NE(message(bytes).find("byte 128"), std::string::npos);
  bytes = small_file();
  put<std::uint32_t>(&bytes, 12, 2);  // no segments array: the default must fit
  put<std::uint32_t>(&bytes, 16, 0xffffffffu);
  EXPECT_NE(message(bytes).find("byte 16"), std::string::npos);
}

TEST(HairFile, LeavesBrokenStrandsOut) {
  for (const float wrong : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 2e9f}) {
    auto bytes = small_file();
    put<float>(&bytes, 134 + 16, wrong);
    const auto hair = parse_hair_file(bytes, "x.hair");
    ASSERT_TRUE(hair) << hair.error().message();
    EXPECT_EQ(hair->broken, std::vector<std::uint32_t>{0});
    ASSERT_EQ(hair->ignored.size(), 1u);
    EXPECT_EQ(hair->ignored[0].name, "1 of 3 strands, the first 0");
    std::vector<std::string> notes, warnings;
    const auto groom = assemble_groom(*hair, {}, "x", &notes, &warnings);
    EXPECT_EQ(groom->strand_count(), 1u);  // the third has one point
    for (const glm::vec3& point : groom->points) EXPECT_LT(glm::length(point), 1e9f);
  }
  auto bytes = small_file();
  for (std::size_t i = 0; i < 18; i += 3) put<float>(&bytes, 134 + 4 * i, std::numeric_limits<float>::quiet_NaN());
  EXPECT_NE(message(bytes).find("none in any strand"), std::string::npos) << message(bytes);
}

TEST(GroomAssembly, WarnsOfDegenerateStrandsWithTheirNumber) {
  auto bytes = small_file();
  for (std::size_t i = 9; i < 15; ++i) put<float>(&bytes, 134 + 4 * i, 1.0f);  // strand 1 has no length
  const auto hair = parse_hair_file(bytes, "x.hair");
  ASSERT_TRUE(hair);
  std::vector<std::string> notes, warnings;
  const auto groom = assemble_groom(*hair, {}, "x.hair", &notes, &warnings);
  ASSERT_TRUE(groom);
  EXPECT_EQ(groom->strand_count(), 1u);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("2 of 3 strands are degenerate"), std::string::npos) << warnings[0];
}

TEST(GroomAssembly, StandsFilesWithYUpAndScalesTo30Centimetres) {
  GroomFile hair;
  hair.first_point = {0, 2};
  hair.points = {{0, 0, 0}, {0, 2, 1}};
  std::vector<std::string> notes, warnings;
  const auto groom = assemble_groom(hair, {.y_up = true, .cm_per_unit = {}, .radius_cm = {}}, "x", &notes, &warnings);
  ASSERT_TRUE(groom);
  EXPECT_EQ(groom->points[1], glm::vec3(0, -15, 30));
  EXPECT_FLOAT_EQ(groom->radius_cm[0], 0.004f);
  EXPECT_EQ(notes.size(), 2u);
}

/// The strands of a generated groom as a file would have them, z up or y up.
GroomFile file_of(const Groom& groom, bool y_up) {
  GroomFile hair;
  hair.first_point = groom.first_point;
  for (const glm::vec3& p : groom.points) hair.points.push_back(y_up ? glm::vec3(p.x, p.z, -p.y) : p);
  return hair;
}

TEST(GroomAssembly, SeesWhichAxisStrandsFallAlong) {
  for (const std::string& kind : generated_groom_kinds()) {
    const Groom groom = generate_groom({.kind = kind, .strands = 400, .seed = 3});
    EXPECT_FALSE(falls_along_y(file_of(groom, false))) << kind;
    EXPECT_TRUE(falls_along_y(file_of(groom, true))) << kind;
  }
  GroomFile strand;
  strand.first_point = {0, 2};
  strand.points = {{0, 0, 0}, {0, 2, 0}};
  EXPECT_FALSE(falls_along_y(strand));
  strand.points = {{1, 1, 1}, {1, 1, 1}};
  EXPECT_FALSE(falls_along_y(strand));
}

TEST(GroomAssembly, AnAxisThatIsSaidWinsAndAGuessIsSaid) {
  const Groom straight = generate_groom({.kind = "straight", .strands = 50, .seed = 3});
  for (const bool lies_along_y : {false, true}) {
    const GroomFile hair = file_of(straight, lies_along_y);
    const auto place = [&](GroomPlacement placement, const char* note) {
      placement.cm_per_unit = 1;
      std::vector<std::string> notes, warnings;
      const auto groom = assemble_groom(hair, placement, "x", &notes, &warnings);
      std::string all;
      for (const std::string& line : notes) all += line + "\n";
      EXPECT_EQ(all.find("for up") != std::string::npos, note[0] != 0) << all;
      EXPECT_NE(all.find(note), std::string::npos) << all;
      return groom->points;
    };
    EXPECT_EQ(place({.guess_up = true}, lies_along_y ? "y taken for up" : "--up y if"), straight.points);
    EXPECT_EQ(place({.y_up = lies_along_y, .guess_up = true}, ""), straight.points);
    EXPECT_EQ(place({.y_up = false, .guess_up = true}, ""), hair.points);
    EXPECT_EQ(place({}, lies_along_y ? "but the strands fall along y" : ""), hair.points);  // of a scene file
  }
}

TEST(HairFile, WhatNoPictureShowsIsNamed) {
  const auto ignored = [](const Bytes& bytes) {
    const auto hair = parse_hair_file(bytes, "x.hair");
    return hair && hair->ignored.size() == 1 ? hair->ignored[0].name + ": " + hair->ignored[0].why : "";
  };
  auto bytes = small_file();
  put<float>(&bytes, 20, -1.0f);
  EXPECT_EQ(ignored(bytes), "thickness of all strands: it is negative or no number and taken for none");
  bytes = small_file();
  put<float>(&bytes, 28, 1.5f);
  EXPECT_EQ(ignored(bytes), "1 of 1 colors: they are clamped to [0, 1]");
  put<std::uint32_t>(&bytes, 12, 1 + 2 + 16);  // colors of the points take its place
  for (std::size_t i = 0; i < 18; ++i) put<float>(&bytes, 206 + 4 * i, i == 4 ? -1.0f : i == 17 ? 3.0f : 1.0f);
  EXPECT_EQ(ignored(bytes), "2 of 6 colors: they are clamped to [0, 1]");
  bytes = small_file();
  bytes.resize(bytes.size() + 5);
  EXPECT_EQ(ignored(bytes), "5 bytes behind the arrays: no array is there");
}

/// A groom laid out as downloaded files are: no segments array, with or without thickness, and a comment.
Bytes groom_file(std::uint32_t strands, std::uint32_t points_a_strand, bool thickness) {
  const std::uint32_t points = strands * points_a_strand;
  Bytes bytes(128, 0);
  std::memcpy(bytes.data(), "HAIR", 4);
  put<std::uint32_t>(&bytes, 4, strands);
  put<std::uint32_t>(&bytes, 8, points);
  put<std::uint32_t>(&bytes, 12, thickness ? 6 : 2);
  put<std::uint32_t>(&bytes, 16, points_a_strand - 1);
  put<float>(&bytes, 20, 0.1f);
  std::memcpy(bytes.data() + 40, "a groom of a test", 17);
  bytes.resize(128 + points * (thickness ? 16 : 12));
  for (std::uint32_t i = 0; i < points; ++i) {
    const std::uint32_t strand = i / points_a_strand;
    const float along = static_cast<float>(i % points_a_strand) / static_cast<float>(points_a_strand - 1);
    const float x[] = {static_cast<float>(strand % 17), static_cast<float>(strand / 17) + along, 10 - 9 * along};
    for (std::size_t axis = 0; axis < 3; ++axis) put<float>(&bytes, 128 + 12 * i + 4 * axis, x[axis]);
  }
  for (std::uint32_t i = 0; thickness && i < points; ++i) put<float>(&bytes, 128 + 12 * points + 4 * i, 0.1f);
  return bytes;
}

void expect_counts(const std::filesystem::path& file, std::uint32_t strands, std::size_t points) {
  const auto scene = load_scene(file);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->grooms.at(0).strand_count(), strands) << file;
  EXPECT_EQ(scene->grooms.at(0).points.size(), points) << file;
  EXPECT_FALSE(scene->notes.empty());
}

TEST(BareGrooms, LoadWithTheirCounts) {
  std::string folder = (std::filesystem::temp_directory_path() / "tress_grooms_XXXXXX").string();
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  const std::filesystem::path file = std::filesystem::path(folder) / "a.hair";
  for (const auto& [strands, points_a_strand, thickness] :
       {std::tuple{300u, 16u, false}, std::tuple{1000u, 4u, true}, std::tuple{1u, 2u, false}}) {
    const Bytes bytes = groom_file(strands, points_a_strand, thickness);
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    expect_counts(file, strands, std::size_t{strands} * points_a_strand);
  }
  std::filesystem::remove_all(folder);
  // Grooms that nobody here made, where they are beside the checkout.
  const std::filesystem::path found = TRESS_SOURCE_DIR "/../shared/data/grooms";
  if (!std::filesystem::exists(found)) return;
  expect_counts(found / "straight.hair", 10000, 160000);
  expect_counts(found / "bear.hair", 48113, 192452);
  expect_counts(found / "ponytail.hair", 4933, 78928);
}

}  // namespace
}  // namespace tress::scene
