// Files larger than what readers keep at a time: what has been read is let go, and nothing is read wrongly for it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "scene/read/grooms/groom_formats.h"
#include "scene/read/grooms/hair_file.h"
#include "scene/read/grooms/usd_file.h"
#include "scene/read/mapped_file.h"

namespace tress::scene {
namespace {

using Bytes = std::vector<unsigned char>;

/// Parts of a file, and how much of it they are.
struct Progress {
  std::size_t bytes = 0;
  std::span<const unsigned char> whole;
  void operator()(std::span<const unsigned char> part) {
    EXPECT_GE(part.data(), whole.data());
    EXPECT_LE(part.data() + part.size(), whole.data() + whole.size());
    bytes += part.size();
  }
};

TEST(LargeGroom, AHairFileIsLetGoAsItIsRead) {
  constexpr std::uint32_t strands = 100'000, segments = 19;
  constexpr std::size_t points = std::size_t{strands} * (segments + 1);
  Bytes bytes(128 + 12 * points);
  const std::uint32_t header[] = {strands, points, 2, segments};
  std::memcpy(bytes.data(), "HAIR", 4);
  std::memcpy(bytes.data() + 4, header, sizeof header);
  for (std::size_t i = 0; i < 3 * points; ++i) {
    const float x = static_cast<float>(i % 4096) / 64;
    std::memcpy(bytes.data() + 128 + 4 * i, &x, 4);
  }
  Progress progress{.whole = bytes};
  const auto groom = parse_hair_file(bytes, "large.hair", std::ref(progress));
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_GT(progress.bytes, bytes.size() / 2);
  ASSERT_EQ(groom->points.size(), points);
  for (const std::size_t i : {std::size_t{0}, points / 2, points - 1})
    EXPECT_EQ(groom->points[i].y, static_cast<float>((3 * i + 1) % 4096) / 64);
}

TEST(LargeGroom, AUsdTextTakesMemoryForItsPointsOnce) {
  constexpr int strands = 50'000, points = 12;
  std::string text = "#usda 1.0\ndef BasisCurves \"h\"\n{\n token type = \"linear\"\n int[] curveVertexCounts = [";
  for (int s = 0; s < strands; ++s) text += s ? ", 12" : "12";
  text += "]\n point3f[] points = [";
  for (int i = 0; i < strands * points; ++i)
    text += fmt::format("{}({}.015625, 0.123456789, -1.5)", i ? ", " : "", i % 97);
  text += "]\n}\n";
  const Bytes bytes(text.begin(), text.end());
  Progress progress{.whole = bytes};
  const auto groom = read_usda({.bytes = bytes, .name = "large.usda", .done_with = std::ref(progress)});
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_GT(progress.bytes, bytes.size() / 2);
  ASSERT_EQ(groom->points.size(), std::size_t{strands} * points);
  EXPECT_LE(groom->points.capacity(), groom->points.size() + 1);
  for (const std::size_t i : {std::size_t{0}, groom->points.size() - 1})
    EXPECT_EQ(groom->points[i], glm::vec3(static_cast<float>(i % 97) + 0.015625f, 0.123456789f, -1.5f));
}

TEST(LargeGroom, WhatAMappingLetGoIsReadAgain) {
  const auto file = std::filesystem::path(testing::TempDir()) / "tress_let_go";
  Bytes bytes(100'000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<unsigned char>(i * 31 >> 3);
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  const auto mapped = MappedFile::open(file, "a file", bytes.size());
  ASSERT_TRUE(mapped) << mapped.error().message();
  for (const std::size_t at : {std::size_t{0}, std::size_t{1}, std::size_t{5000}, std::size_t{99'999}}) {
    mapped->let_go(mapped->bytes().subspan(at));
    EXPECT_TRUE(std::ranges::equal(mapped->bytes(), bytes)) << at;
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace tress::scene
