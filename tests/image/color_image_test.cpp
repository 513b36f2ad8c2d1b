// Color pictures of a scene: values by hand, and what is refused.
#include "image/color_image.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "image/picture.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb_image_write.h>

namespace tress::image {
namespace {

using Bytes = std::vector<unsigned char>;

void append(void* context, void* data, int size) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  static_cast<Bytes*>(context)->insert(static_cast<Bytes*>(context)->end(), bytes, bytes + size);
}

Bytes png(int width, int height, int channels, const Bytes& values) {
  Bytes file;
  stbi_write_png_to_func(append, &file, width, height, channels, values.data(), width * channels);
  return file;
}

void big_endian(std::uint32_t x, Bytes* bytes) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes->push_back(static_cast<unsigned char>(x >> shift));
}

void chunk(const std::string& type, const Bytes& data, Bytes* file) {
  big_endian(static_cast<std::uint32_t>(data.size()), file);
  file->insert(file->end(), type.begin(), type.end());
  file->insert(file->end(), data.begin(), data.end());
  big_endian(0, file);  // the decoder does not look at sums
}

/// One row of RGB of 16 bits, by hand: a stored block.
Bytes png_of_16_bits(const std::vector<std::uint16_t>& values, std::uint32_t width, std::uint32_t height) {
  Bytes file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, header, data{0x78, 0x01, 0x01};
  big_endian(width, &header);
  big_endian(height, &header);
  header.insert(header.end(), {16, 2, 0, 0, 0});
  const auto length = static_cast<std::uint16_t>(1 + 2 * values.size());
  for (const std::uint16_t x : {length, static_cast<std::uint16_t>(~length)}) {
    data.push_back(static_cast<unsigned char>(x & 255));
    data.push_back(static_cast<unsigned char>(x >> 8));
  }
  data.push_back(0);  // no filter
  for (const std::uint16_t x : values) {
    data.push_back(static_cast<unsigned char>(x >> 8));
    data.push_back(static_cast<unsigned char>(x & 255));
  }
  big_endian(0, &data);
  chunk("IHDR", header, &file);
  chunk("IDAT", data, &file);
  chunk("IEND", {}, &file);
  return file;
}

// IEC 61966-2-1: 128 of 255 is 0.2158605 in linear light, 10 is 0.0030353.
TEST(ColorImage, APngIsDecodedToLinearLightTopRowFirst) {
  const auto image = parse_png(png(2, 2, 3, {0, 10, 255, 128, 128, 128, 255, 0, 0, 0, 255, 0}), "a.png");
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ(image->width, 2);
  EXPECT_EQ(image->height, 2);
  EXPECT_EQ(image->pixels[0].x, 0);
  EXPECT_NEAR(image->pixels[0].y, 0.0030353, 1e-7);
  EXPECT_EQ(image->pixels[0].z, 1);
  EXPECT_NEAR(image->pixels[1].x, 0.2158605, 1e-6);
  EXPECT_EQ(image->pixels[2], glm::vec3(1, 0, 0));
  EXPECT_EQ(image->pixels[3], glm::vec3(0, 1, 0));
}

TEST(ColorImage, GreyBecomesRgbAndAlphaIsLeftOut) {
  const auto grey = parse_png(png(1, 1, 1, {128}), "a.png");
  ASSERT_TRUE(grey);
  EXPECT_NEAR(grey->pixels[0].z, 0.2158605, 1e-6);
  const auto clear = parse_png(png(1, 1, 4, {255, 0, 255, 0}), "a.png");
  ASSERT_TRUE(clear);
  EXPECT_EQ(clear->pixels[0], glm::vec3(1, 0, 1));
}

TEST(ColorImage, SixteenBitsKeepTheirSteps) {
  const auto image = parse_png(png_of_16_bits({0, 65535, 32896, 32897, 1, 2}, 2, 1), "a.png");
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ(image->pixels[0].x, 0);
  EXPECT_EQ(image->pixels[0].y, 1);
  EXPECT_NEAR(image->pixels[0].z, 0.2158605, 1e-6);  // 32896 = 128 * 257
  EXPECT_GT(image->pixels[1].x, image->pixels[0].z);
  EXPECT_NEAR(image->pixels[1].z / image->pixels[1].y, 2, 1e-5);
}

TEST(ColorImage, APngThatEndsEarlyIsRefused) {
  const Bytes whole = png(3, 3, 3, Bytes(27, 77));
  for (std::size_t size = 0; size + 12 < whole.size(); ++size) {
    const auto image = parse_png(std::span(whole).first(size), "a.png");
    ASSERT_FALSE(image) << size;
    EXPECT_NE(image.error().message().find("a.png"), std::string::npos);
  }
}

// A claim of 65535 x 65535 pixels in a hundred bytes takes no memory.
TEST(ColorImage, ClaimsAreHeldAgainstTheFile) {
  const auto image = parse_png(png_of_16_bits({1, 2, 3}, 65535, 65535), "a.png");
  ASSERT_FALSE(image);
  EXPECT_NE(image.error().message().find("65535 x 65535"), std::string::npos) << image.error().message();
  EXPECT_FALSE(parse_png(png_of_16_bits({1, 2, 3}, 0, 1), "a.png"));
  EXPECT_FALSE(parse_png(png_of_16_bits({1, 2, 3}, 4, 4), "a.png"));
  Bytes long_chunk = png_of_16_bits({1, 2, 3}, 1, 1);
  long_chunk[8 + 25] = 0x60;  // the length of IDAT, which is 1.6 GB then
  const auto refused = parse_png(long_chunk, "a.png");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("byte 33"), std::string::npos) << refused.error().message();
  EXPECT_FALSE(parse_png(Bytes{'G', 'I', 'F', '8', '9', 'a'}, "a.gif"));
}

// A display window is a claim of the header: it takes no memory unless the data fill a share of it.
TEST(ColorImage, ADisplayWindowIsHeldAgainstItsData) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "wide_display_window.exr";
  Picture picture;
  picture.width = 8;
  picture.height = 4;
  for (const char* name : {"R", "G", "B"}) picture.channels.push_back({name, std::vector<float>(32, 1.0f)});
  picture.whole_width = 1 << 13;
  picture.whole_height = 1 << 11;
  ASSERT_FALSE(write_exr(file, picture));
  const auto moderate = read_exr_color(file);
  ASSERT_TRUE(moderate) << moderate.error().message();
  EXPECT_EQ(moderate->pixels.size(), std::size_t{1} << 24);
  picture.whole_height += 1;
  ASSERT_FALSE(write_exr(file, picture));
  const auto refused = read_exr_color(file);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("displayWindow"), std::string::npos) << refused.error().message();
  EXPECT_NE(refused.error().message().find("8192 x 2049"), std::string::npos) << refused.error().message();
  picture.whole_width = (1 << 17) + 1;
  picture.whole_height = 4;
  ASSERT_FALSE(write_exr(file, picture));
  const auto long_side = read_exr_color(file);
  ASSERT_FALSE(long_side);
  EXPECT_NE(long_side.error().message().find("131073 x 4"), std::string::npos) << long_side.error().message();
}

TEST(ColorImage, ALargeDisplayWindowNeedsBytes) {
  // A share of 1 / 64 has data, but the data are black, which compresses to a few thousand bytes.
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "flat_card.exr";
  Picture picture;
  picture.width = 1 << 10;
  picture.height = 1 << 9;
  for (const char* name : {"R", "G", "B"})
    picture.channels.push_back({name, std::vector<float>(std::size_t{1} << 19, 0.0f)});
  picture.whole_width = 1 << 13;
  picture.whole_height = 1 << 12;
  ASSERT_FALSE(write_exr(file, picture));
  ASSERT_LT(std::filesystem::file_size(file) * 4096, std::size_t{1} << 25);
  const auto refused = read_exr_color(file);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("8192 x 4096"), std::string::npos) << refused.error().message();
}

}  // namespace
}  // namespace tress::image
