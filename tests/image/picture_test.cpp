#include "image/picture.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#include <stb_image.h>

namespace tress::image {
namespace {

/// Of the running test alone: tests run side by side, in processes of their own.
std::filesystem::path temporary(const std::string& name) {
  const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
  return std::filesystem::path(testing::TempDir()) / ("tress_picture_" + test + "_" + name);
}

Picture gradient() {
  Picture picture;
  picture.width = 37;
  picture.height = 300;
  for (const char* name : {"A", "B", "G", "R", "TT.G", "ais.exact"}) {
    Channel channel{name, {}};
    for (int i = 0; i < 37 * 300; ++i) channel.pixels.push_back(0.001f * static_cast<float>(i % 997) + 0.1f);
    picture.channels.push_back(channel);
  }
  picture.metadata = {{"tress.scene", "a.json"}, {"tress.seed", "3"}};
  picture.matrices["worldToCamera"] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16.5f};
  picture.screen_width = 0.75f;
  return picture;
}

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(Exr, RoundTripKeepsEveryBitLayerAndText) {
  const auto file = temporary("round.exr");
  const Picture written = gradient();
  ASSERT_FALSE(write_exr(file, written));
  const auto read = read_exr(file);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_TRUE(compare(written, *read, "a", "b")->identical);
  for (const auto& [key, value] : written.metadata) EXPECT_EQ(read->metadata.at(key), value);
  EXPECT_EQ(read->matrices, written.matrices);
  EXPECT_EQ(read->screen_width, written.screen_width);
}

// Half where that is enough: not of Z and variance, not beyond the largest half (as a sun in the backdrop has), not of
// a layer that is so dark that its halves would be coarse. Of a layer all channels are alike.
TEST(Exr, HalvesHoldWhatTheyCanAndTheRestKeepsItsBits) {
  const auto file = temporary("half.exr");
  Picture picture;
  picture.width = 2;
  picture.height = 1;
  const auto add = [&](const char* name, float a, float b) { picture.channels.push_back({name, {a, b}}); };
  add("A", 1, 0.3f), add("R", 0.1f, 65504), add("G", -0.1f, 1e-9f), add("B", 0, 0);
  add("sun.R", 1e6f, 0.3f), add("sun.G", 0.1f, 0.3f);
  add("dark.R", 1e-3f, 1e-5f);
  add("Z", 33.3f, 1e9f), add("variance.R", 0.1f, 1e-12f);
  ASSERT_FALSE(write_exr(file, picture, Precision::half));
  const auto read = read_exr(file);
  ASSERT_TRUE(read) << read.error().message();
  for (const char* name : {"sun.R", "sun.G", "dark.R", "Z", "variance.R"})
    EXPECT_EQ(read->find(name)->pixels, picture.find(name)->pixels) << name;
  EXPECT_EQ(read->find("R")->pixels, (std::vector<float>{0.0999755859375f, 65504}));
  EXPECT_EQ(read->find("G")->pixels, (std::vector<float>{-0.0999755859375f, 0}));
  EXPECT_EQ(read->find("A")->pixels, (std::vector<float>{1, 0.300048828125f}));
}

// dark_beauty_half: alpha says nothing of how bright R, G, B are.
TEST(Exr, DarkBeautyKeepsItsValues) {
  const auto file = temporary("dark.exr");
  Picture picture;
  picture.width = 2;
  picture.height = 1;
  for (const char* name : {"R", "G", "B"}) picture.channels.push_back({name, {1.0007e-7f, 3e-8f}});
  picture.channels.push_back({"A", {1, 0.5f}});
  ASSERT_FALSE(write_exr(file, picture, Precision::half));
  const auto read = read_exr(file);
  ASSERT_TRUE(read) << read.error().message();
  for (const char* name : {"R", "G", "B", "A"}) EXPECT_EQ(read->find(name)->pixels, picture.find(name)->pixels) << name;
}

TEST(Picture, KeepsBeautyAndTheLayersThatAreNamed) {
  Picture picture = gradient();
  EXPECT_EQ(layer_of("R"), "beauty");
  EXPECT_EQ(layer_of("R.R"), "R");
  EXPECT_EQ(layer_of("Z"), "Z");
  keep_layers({"TT", "Z"}, &picture);
  ASSERT_EQ(picture.channels.size(), 5u);
  EXPECT_EQ(picture.channels.back().name, "TT.G");
}

TEST(Exr, RoundTripKeepsWhereAPartLies) {
  const auto file = temporary("part.exr");
  Picture part = gradient();
  part.left = 5;
  part.top = 11;
  part.whole_width = 100;
  part.whole_height = 400;
  ASSERT_FALSE(write_exr(file, part));
  const auto read = read_exr(file);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->window(), part.window());
  EXPECT_EQ(read->whole(), part.whole());
  EXPECT_TRUE(compare(part, *read, "a", "b")->identical);
  part.left = 64;  // one pixel outside
  const auto error = write_exr(file, part);
  ASSERT_TRUE(error);
  EXPECT_NE(error->message().find("37 x 300 from (64, 11)"), std::string::npos) << error->message();
}

TEST(Exr, RefusesEveryTruncationAndGarbage) {
  const auto file = temporary("whole.exr"), part = temporary("part.exr");
  ASSERT_FALSE(write_exr(file, gradient()));
  const std::string whole = bytes_of(file);
  for (std::size_t size = 0; size + 1 < whole.size(); size += 64) {
    std::ofstream(part, std::ios::binary) << whole.substr(0, size);
    const auto read = read_exr(part);
    ASSERT_FALSE(read) << size;
    EXPECT_NE(read.error().message().find("part.exr"), std::string::npos);
  }
  // A flipped byte may leave a readable picture; it must not crash.
  for (std::size_t at = 0; at < std::min<std::size_t>(whole.size(), 900); ++at) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ 0xff);
    std::ofstream(part, std::ios::binary) << flipped;
    (void)read_exr(part);
  }
  EXPECT_FALSE(read_exr(std::filesystem::path(testing::TempDir())));
  EXPECT_FALSE(read_exr(temporary("missing.exr")));
}

TEST(Exr, RefusesAPictureLargerThanItsFileCanHold) {
  const auto file = temporary("wide.exr");
  ASSERT_FALSE(write_exr(file, gradient()));
  std::string bytes = bytes_of(file);
  const auto window = bytes.find("dataWindow");
  ASSERT_NE(window, std::string::npos);
  bytes[window + 11 + 6 + 4 + 8 + 1] = '\xff';  // name, "box2i", size, min: the second byte of max.x, 36 becomes 65316
  std::ofstream(file, std::ios::binary) << bytes;
  const auto read = read_exr(file);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message().find("65317 x 300"), std::string::npos) << read.error().message();
}

// OpenEXR allocates what a header claims before it looks at the file: 1.6 GB for an attribute, 137 GB for blocks.
TEST(Exr, RefusesHeadersThatAskForMoreThanTheFileHas) {
  const auto file = temporary("claims.exr");
  Picture small = gradient();
  small.channels.resize(1);
  ASSERT_FALSE(write_exr(file, small));
  const std::string whole = bytes_of(file);
  const auto attribute = [](const std::string& name, const std::string& type, std::uint32_t size, std::string value) {
    std::string text = name + '\0' + type + '\0';
    for (int i = 0; i < 4; ++i) text += static_cast<char>(size >> 8 * i);
    return text + value;
  };
  const auto channel = [](char name) {
    std::string text(18, '\0');
    text[0] = name;
    return text;
  };
  const std::string zero(4, '\0'), one("\1\0\0\0", 4), many("\0\0\1\0", 4), full(4, '\xff'), far("\xff\x3f\0\0", 4);
  const std::pair<std::string, std::string> claims[] = {
      {attribute("extra", "opaque", 0x61643131, ""), "header extra: expected a value of at most"},
      {attribute("extra", "v2i", 9, many + many + '\0'), "header extra: expected a v2i of 8 bytes"},
      {attribute("extra", "chlist", 37, channel('G') + '\0' + channel('B')),
       "header extra: expected a chlist of 19 bytes"},
      {attribute("extra", "chlist", 18, channel('G') + channel('B') + '\0'),
       "header extra: expected a chlist of 37 bytes"},
      {attribute("extra", "preview", 8, full + full), "header extra: expected a value that fits into the file"},
      {attribute("extra", "preview", 8, many + many), "header extra: expected a value that fits into the file"},
      {attribute("tiles", "tiledesc", 9, many + many + '\0'), "header tiles: expected 1 to"},
      {attribute("tiles", "tiledesc", 9, one + zero + '\0'), "header tiles: expected 1 to"},
      {attribute("dataWindow", "box2i", 16, zero + zero + far + far) +
           attribute("tiles", "tiledesc", 9, one + one + '\0'),
       "header dataWindow: expected a picture of at most"}};
  for (const auto& [claim, reason] : claims) {
    std::string bytes = whole;
    // Before the attributes that are there; the last of a name counts, so its own data window is renamed.
    if (claim.starts_with("dataWindow")) bytes[bytes.find("dataWindow")] = 'D';
    bytes.insert(8, claim);
    std::ofstream(file, std::ios::binary) << bytes;
    const auto read = read_exr(file);
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().message().find(reason), std::string::npos) << read.error().message();
  }
}

TEST(Exr, RefusesNaNByChannelAndPixelAndLeavesTheFile) {
  const auto file = temporary("nan.exr");
  ASSERT_FALSE(write_exr(file, gradient()));
  const std::string before = bytes_of(file);
  Picture bad = gradient();
  bad.channels[3].pixels[37 * 2 + 5] = std::numeric_limits<float>::quiet_NaN();
  const auto error = write_exr(file, bad);
  ASSERT_TRUE(error);
  EXPECT_NE(error->message().find("channel R, pixel (5, 2)"), std::string::npos) << error->message();
  EXPECT_EQ(bytes_of(file), before);
  EXPECT_TRUE(write_exr(temporary("no_folder") / "x.exr", gradient()));
}

/// Bytes of the pixels of a PNG, `channels` of them each.
std::vector<int> decoded(const std::filesystem::path& file, int* channels) {
  int width = 0, height = 0;
  unsigned char* data = stbi_load(file.c_str(), &width, &height, channels, 0);
  std::vector<int> bytes(data, data + (data ? width * height * *channels : 0));
  stbi_image_free(data);
  return bytes;
}

// sRGB of 0.5 is 188, of 0.25 137, of 0.18 118. Transparent, a pixel that is half covered by 0.5 (premultiplied 0.25)
// has the color of what covers it; opaque it has what R, G, B have, or mid-grey behind where the picture has no
// backdrop.
TEST(Preview, HasStraightAlphaIfAskedAndElseWhatIsBehind) {
  Picture picture;
  picture.width = 3;
  picture.height = 1;
  for (const char* name : {"R", "G", "B"}) picture.channels.push_back({name, {0.5f, 0.25f, 0}});
  picture.channels.push_back({"A", {1, 0.5f, 0}});
  const auto file = temporary("a.png");
  int channels = 0;
  ASSERT_FALSE(write_png(file, picture, {.alpha = true}));
  EXPECT_EQ(decoded(file, &channels), (std::vector{188, 188, 188, 255, 188, 188, 188, 128, 0, 0, 0, 0}));
  EXPECT_EQ(channels, 4);
  ASSERT_FALSE(write_png(file, picture));
  EXPECT_EQ(decoded(file, &channels), (std::vector{188, 188, 188, 158, 158, 158, 118, 118, 118}));
  picture.channels.push_back({"background.R", {0, 0, 0}});
  ASSERT_FALSE(write_png(file, picture, {.exposure_stops = 1}));
  EXPECT_EQ(decoded(file, &channels), (std::vector{255, 255, 255, 188, 188, 188, 0, 0, 0}));
  ASSERT_FALSE(write_png(file, picture));
  EXPECT_EQ(decoded(file, &channels), (std::vector{188, 188, 188, 137, 137, 137, 0, 0, 0}));
}

TEST(Preview, ShowsALayerInPlaceOfThePictureWhereThereIsOne) {
  Picture picture;
  picture.width = picture.height = 1;
  for (const char* name : {"R", "G", "B", "background.R"}) picture.channels.push_back({name, {0.5f}});
  const auto file = temporary("a.png");
  int channels = 0;
  ASSERT_FALSE(write_png(file, picture, {.layer = "clean"}));
  EXPECT_EQ(decoded(file, &channels), (std::vector{188, 188, 188}));
  for (const char* name : {"clean.R", "clean.G", "clean.B"}) picture.channels.push_back({name, {0.25f}});
  ASSERT_FALSE(write_png(file, picture, {.layer = "clean"}));
  EXPECT_EQ(decoded(file, &channels), (std::vector{137, 137, 137}));
  ASSERT_FALSE(write_png(file, picture));
  EXPECT_EQ(decoded(file, &channels), (std::vector{188, 188, 188}));
}

// A disk that fills up anywhere in the file, its last bytes included, by a limit on file sizes in a child of its own:
// never a picture without its end, which is where the offsets of its rows stand.
TEST(Picture, IsTheOldOneWhereTheNewOneHasNoRoom) {
  const auto folder = temporary("room");
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  const std::filesystem::path exr = folder / "a.exr", png = folder / "a.png";
  for (const auto& file : {exr, png}) std::ofstream(file) << "old";
  const auto save = [](const std::filesystem::path& file) {
    return file.extension() == ".exr" ? write_exr(file, gradient()) : write_png(file, gradient());
  };
  for (const auto& file : {exr, png}) {
    ASSERT_FALSE(save(folder / ("whole" + file.extension().string())));
    const std::uintmax_t size = std::filesystem::file_size(folder / ("whole" + file.extension().string()));
    std::filesystem::remove(folder / ("whole" + file.extension().string()));
    for (const std::uintmax_t room : {std::uintmax_t{0}, size / 3, size - 8191, size - 300, size - 1}) {
      if (room >= size) continue;
      const pid_t child = fork();
      ASSERT_GE(child, 0);
      if (child == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit limit{room, room};
        if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(2);
        const std::optional<Error> error = save(file);
        _exit(error && error->file == file.string() && !error->found.empty() ? 0 : 1);
      }
      int status = 0;
      ASSERT_EQ(waitpid(child, &status, 0), child);
      ASSERT_TRUE(WIFEXITED(status));
      EXPECT_EQ(WEXITSTATUS(status), 0) << file << ", room for " << room << " of " << size;
      EXPECT_EQ(bytes_of(file), "old") << file << ", room for " << room << " of " << size;
    }
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 2) << "nothing else is left";
  std::filesystem::remove_all(folder);
}

TEST(Picture, ReplacesWhatALinkPointsToAndNoDevice) {
  const auto folder = temporary("links");
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  std::filesystem::create_symlink("real.exr", folder / "link.exr");
  ASSERT_FALSE(write_exr(folder / "link.exr", gradient()));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.exr"));
  EXPECT_TRUE(read_exr(folder / "real.exr"));
  std::filesystem::create_symlink("/dev/null", folder / "null.png");
  EXPECT_TRUE(write_png(folder / "null.png", gradient()));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  std::filesystem::remove_all(folder);
}

TEST(Png, HasSignatureAndSize) {
  const auto file = temporary("a.png");
  ASSERT_FALSE(write_png(file, gradient()));
  const std::string bytes = bytes_of(file);
  ASSERT_GT(bytes.size(), 33u);
  EXPECT_EQ(bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(bytes.substr(12, 4), "IHDR");
  EXPECT_EQ(bytes[19], 37);
  EXPECT_EQ(static_cast<unsigned char>(bytes[22]) * 256 + static_cast<unsigned char>(bytes[23]), 300);
  EXPECT_EQ(bytes.substr(bytes.size() - 8, 4), "IEND");
}

TEST(Compare, MeasuresAKnownDifference) {
  const Picture a = gradient();
  Picture b = a;
  for (float& x : b.channels[3].pixels) x += 0.5f;
  const auto difference = compare(a, b, "a", "b");
  ASSERT_TRUE(difference);
  EXPECT_NEAR(difference->bias[0], 0.5, 1e-6);
  EXPECT_NEAR(difference->mae, 0.5 / 3, 1e-6);
  EXPECT_NEAR(difference->largest, 0.5, 1e-6);
  EXPECT_FALSE(difference->identical);
  // A part of an image is held against the whole where both have pixels.
  Picture part;
  part.width = 2;
  part.height = 1;
  part.left = 30;
  part.top = 200;
  part.whole_width = 37;
  part.whole_height = 300;
  for (const Channel& channel : a.channels) {
    const float* first = channel.pixels.data() + 200 * 37 + 30;
    part.channels.push_back({channel.name, {first[0], first[1] + (channel.name == "R" ? 0.25f : 0.0f)}});
  }
  const auto there = compare(a, part, "a", "part");
  ASSERT_TRUE(there);
  EXPECT_NEAR(there->bias[0], 0.125, 1e-6);
  EXPECT_EQ(there->bias[1], 0);
  EXPECT_FALSE(there->identical);
  part.channels[3].pixels[1] = a.channels[3].pixels[200 * 37 + 31];
  EXPECT_TRUE(compare(a, part, "a", "part")->identical);
  Picture elsewhere = part;
  elsewhere.top = 201;
  EXPECT_FALSE(compare(part, elsewhere, "part", "elsewhere"));
  Picture small = a;
  small.width = 300, small.height = 37;
  EXPECT_FALSE(compare(a, small, "a", "b"));
}

}  // namespace
}  // namespace tress::image
