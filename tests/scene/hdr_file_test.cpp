#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "image/picture.h"
#include "scene/read/environment_file.h"
#include "scene/read/input_files.h"
#include "tress/base/random.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb_image_write.h>

namespace tress::scene {
namespace {

using Bytes = std::vector<unsigned char>;

void append(void* to, void* data, int size) {
  const auto* bytes = static_cast<unsigned char*>(data);
  static_cast<Bytes*>(to)->insert(static_cast<Bytes*>(to)->end(), bytes, bytes + size);
}

/// Encoded by stb: run-length from a width of 8 on, flat below.
Bytes encoded(int width, int height, const std::vector<float>& rgb) {
  Bytes bytes;
  stbi_write_hdr_to_func(append, &bytes, width, height, 3, rgb.data());
  return bytes;
}

/// Radiances over many powers of two, with runs, zeros and noise.
std::vector<float> radiances(int width, int height) {
  RandomStream random(21);
  std::vector<float> rgb(static_cast<std::size_t>(width * height) * 3);
  for (std::size_t i = 0; i < rgb.size(); ++i)
    rgb[i] = i / 90 % 3 == 0 ? 2.5f : i % 7 == 0 ? 0.0f : std::exp2(30 * random.next() - 15);
  return rgb;
}

std::string refusal(const Bytes& bytes, std::size_t most_pixels = 1 << 20) {
  const auto picture = parse_hdr_file(bytes, "a.hdr", most_pixels);
  return picture ? "" : picture.error().message();
}

Bytes file_of(const std::string& text) { return {text.begin(), text.end()}; }

/// A mantissa has 8 bits for the largest channel of a pixel and is cut off, not rounded: off by less than max/128.
TEST(HdrFile, ReadsWhatAnotherProgramWrote) {
  for (const int width : {1, 7, 8, 127, 300}) {
    const int height = 5;
    const auto rgb = radiances(width, height);
    const auto picture = parse_hdr_file(encoded(width, height, rgb), "a.hdr", 1 << 20);
    ASSERT_TRUE(picture) << picture.error().message();
    ASSERT_EQ(picture->width, width);
    ASSERT_EQ(picture->height, height);
    for (std::size_t i = 0; i < picture->pixels.size(); ++i) {
      const float largest = std::max({rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]});
      for (int c = 0; c < 3; ++c) {
        const float written = rgb[3 * i + static_cast<std::size_t>(c)];
        ASSERT_LE(picture->pixels[i][c], written) << width << " " << i;
        ASSERT_GT(picture->pixels[i][c], written - largest / 128 - 1e-30f) << width << " " << i;
      }
    }
  }
}

TEST(HdrFile, RefusesDamageByName) {
  const auto whole = encoded(40, 6, radiances(40, 6));
  ASSERT_EQ(refusal(whole), "");
  for (std::size_t size = 0; size < whole.size(); ++size)
    ASSERT_NE(refusal(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))), "") << size;
  EXPECT_NE(refusal(whole, 239).find("at most 239 pixels"), std::string::npos);
  const std::string start = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
  const std::pair<std::string, std::string> wrong[] = {
      {"P6\n", "a.hdr: byte 0: expected #?RADIANCE"},
      {"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd", "expected FORMAT=32-bit_rle_rgbe"},
      {"#?RADIANCE\nno end of the header", "a line of the header"},
      {start + "+Y 1 +X 1\nabcd", "a size such as"},
      {start + "-Y 0 +X 1\nabcd", "a size such as"},
      {start + "-Y 99999999999999999999 +X 1\nabcd", "a size such as"},
      {start + "-Y 2147483647 +X 2147483647\nabcd", "pixels"},
      {start + "-Y 1000 +X 1000\nabcd", "1000 scan lines"},
      {start + std::string("-Y 1 +X 8\n\2\2\0\x09 pad pad", 10 + 12), "a scan line of 8, found 9"},
      {start + std::string("-Y 1 +X 8\n\2\2\0\x08\x0a\x01\x01\x01\x01\x01", 10 + 10), "a run of 1..8 pixels, found 10"},
      {start + std::string("-Y 1 +X 8\n\2\2\0\x08\0\0\0\0\0\0", 10 + 10), "a run of 1..8 pixels, found 0"}};
  for (const auto& [text, why] : wrong)
    EXPECT_NE(refusal(file_of(text)).find(why), std::string::npos) << refusal(file_of(text));
}

/// Seed 23: 20,000 files with some bytes changed are read or refused, and every value read is finite.
TEST(HdrFile, SurvivesChangedBytes) {
  const auto whole = encoded(40, 6, radiances(40, 6));
  RandomStream random(23);
  int read = 0;
  for (int i = 0; i < 20000; ++i) {
    auto bytes = whole;
    for (auto n = random.next_bits() % 4 + 1; n > 0; --n)
      bytes[random.next_bits() % bytes.size()] = static_cast<unsigned char>(random.next_bits());
    const auto picture = parse_hdr_file(bytes, "a.hdr", 1 << 20);
    if (!picture) continue;
    ++read;
    for (const auto& p : picture->pixels) ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  }
  EXPECT_GT(read, 100);
}

struct TemporaryFile {
  std::filesystem::path path;
  explicit TemporaryFile(const std::string& name) : path(std::filesystem::path(testing::TempDir()) / name) {}
  ~TemporaryFile() { std::filesystem::remove(path); }
};

/// The same map through both formats, each under the other's name.
TEST(EnvironmentFile, FindsTheFormatByContent) {
  image::Picture picture;
  picture.width = 8;
  picture.height = 4;
  std::vector<float> rgb(96);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<float>(1 << i % 3);
  for (std::size_t c = 0; c < 3; ++c) {
    image::Channel channel{std::string(1, "RGB"[c]), {}};
    for (std::size_t i = 0; i < 32; ++i) channel.pixels.push_back(rgb[3 * i + c]);
    picture.channels.push_back(channel);
  }
  const TemporaryFile hdr("tress_map_of_hdr.exr"), exr("tress_map_of_exr.hdr");
  ASSERT_FALSE(image::write_exr(exr.path, picture));
  const auto bytes = encoded(8, 4, rgb);
  std::ofstream(hdr.path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  for (const auto& file : {hdr.path, exr.path}) {
    std::vector<std::string> warnings;
    const auto environment = load_environment(file, 0, 2, &warnings);
    ASSERT_TRUE(environment) << environment.error().message();
    EXPECT_EQ(environment->radiance({0, 0, 1}), glm::vec3(2, 4, 8));
    EXPECT_TRUE(warnings.empty());
  }
  const TemporaryFile neither("tress_map.exr");
  std::ofstream(neither.path) << "neither of them";
  std::vector<std::string> warnings;
  EXPECT_NE(load_environment(neither.path, 0, 1, &warnings).error().message(), "");
  EXPECT_NE(load_environment(testing::TempDir(), 0, 1, &warnings).error().message().find("a directory"),
            std::string::npos);
}

TEST(EnvironmentFile, RefusesAbsurdRadianceAndWarnsOfOddShapes) {
  std::vector<float> rgb(3 * 16, 1.0f);
  const auto load = [&](std::vector<std::string>* warnings) {
    const TemporaryFile file("tress_odd.hdr");
    const auto bytes = encoded(4, 4, rgb);
    std::ofstream(file.path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    const auto environment = load_environment(file.path, 0, 1, warnings);
    return environment ? std::string() : environment.error().message();
  };
  std::vector<std::string> warnings;
  EXPECT_EQ(load(&warnings), "");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("twice as wide as high"), std::string::npos);
  rgb[3 * 5 + 1] = 1e20f;
  EXPECT_NE(load(&warnings).find("channel G, pixel (1, 1): expected a radiance of at most 1e+12"), std::string::npos);
}

}  // namespace
}  // namespace tress::scene
