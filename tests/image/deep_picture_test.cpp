#include "image/deep_picture.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "support/deep_reader.h"

namespace tress::image {
namespace {

std::filesystem::path deep_file(const std::string& name) {
  const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
  return std::filesystem::path(testing::TempDir()) /
         ("tress_deep_" + test + "_" + std::to_string(getpid()) + "_" + name);
}

/// 3 x 2 pixels of 10 x 8 with 2, 0, 1, 0, 0, 3 samples.
Picture deep_header() {
  Picture header;
  header.width = 3;
  header.height = 2;
  header.left = 4;
  header.top = 5;
  header.whole_width = 10;
  header.whole_height = 8;
  header.metadata["scene"] = "a.json";
  return header;
}

DeepPicture six_samples() {
  DeepPicture deep;
  deep.counts = {2, 0, 1, 0, 0, 3};
  for (int i = 0; i < 6; ++i) {
    const auto x = static_cast<float>(i);
    deep.samples.push_back({{x, x + 0.25f, x + 0.5f}, x / 8, x + 10, x + 10.5f});
  }
  return deep;
}

TEST(DeepExr, HasEverySampleToTheBitInItsWindow) {
  const auto file = deep_file("a.exr");
  const DeepPicture written = six_samples();
  ASSERT_FALSE(write_deep_exr(file, written, deep_header()));
  const test::ReadDeep read = test::read_deep(file.string());
  EXPECT_EQ(read.window, (Window{4, 5, 3, 2}));
  EXPECT_EQ(read.whole_width, 10);
  EXPECT_EQ(read.whole_height, 8);
  EXPECT_EQ(read.type, Imf::DEEPSCANLINE);
  EXPECT_EQ(read.compression, Imf::ZIPS_COMPRESSION);
  EXPECT_EQ(read.channels, (std::vector<std::string>{"A", "B", "G", "R", "Z", "ZBack"}));
  EXPECT_EQ(read.metadata.at("scene"), "a.json");
  std::size_t next = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    ASSERT_EQ(read.pixels[i].size(), written.counts[i]) << i;
    for (const DeepSample& sample : read.pixels[i]) {
      const DeepSample& expected = written.samples[next++];
      EXPECT_EQ(sample.color, expected.color);
      EXPECT_EQ(sample.alpha, expected.alpha);
      EXPECT_EQ(sample.front_cm, expected.front_cm);
      EXPECT_EQ(sample.back_cm, expected.back_cm);
    }
  }
  std::filesystem::remove(file);
}

TEST(DeepExr, RefusesWhatDoesNotFit) {
  const auto file = deep_file("a.exr");
  DeepPicture fewer = six_samples(), other = six_samples(), infinite = six_samples();
  fewer.samples.pop_back();
  other.counts.pop_back();
  infinite.samples[3].back_cm = INFINITY;
  Picture outside = deep_header();
  outside.left = 8;
  const auto message = [&](const DeepPicture& deep, const Picture& header) {
    const auto error = write_deep_exr(file, deep, header);
    return error ? error->message() : "";
  };
  EXPECT_NE(message(fewer, deep_header()).find("5 of 6 pixels"), std::string::npos);
  EXPECT_NE(message(other, deep_header()).find("of 5 pixels"), std::string::npos);
  EXPECT_NE(message(infinite, deep_header()).find("sample 3"), std::string::npos);
  EXPECT_NE(message(six_samples(), outside).find("window"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_TRUE(write_deep_exr(deep_file("no such folder") / "a.exr", six_samples(), deep_header()));
}

}  // namespace
}  // namespace tress::image
