// tress diff: the figures that it prints, on pictures whose difference is known.
#include <gmock/gmock.h>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

TEST(DiffOfPictures, DistinguishesIdenticalAndDifferent) {
  const fs::path folder = fs::path(::testing::TempDir()) / ("tress_diff_" + std::to_string(getpid()));
  fs::create_directories(folder);
  image::Picture picture;
  picture.width = 2;
  picture.height = 1;
  for (const char* name : {"R", "G", "B"}) picture.channels.push_back({name, {0.5f, 1.0f}});
  const std::string a = (folder / "a.exr").string(), b = (folder / "b.exr").string();
  ASSERT_FALSE(image::write_exr(a, picture));
  picture.channels[0].pixels[1] += 0.25f;  // R of the second pixel, whichever order the channels are kept in
  ASSERT_FALSE(image::write_exr(b, picture));
  const Outcome same = Process(folder, {"diff", a, a, "--json"}).wait();
  EXPECT_EQ(same.status, 0) << same.err;
  const auto none = nlohmann::json::parse(same.out);
  EXPECT_EQ(none.at("identical"), true);
  EXPECT_EQ(none.at("relMSE"), 0.0);
  const Outcome other = Process(folder, {"diff", a, b, "--json"}).wait();
  EXPECT_EQ(other.status, 0) << other.err;
  const auto some = nlohmann::json::parse(other.out);
  EXPECT_EQ(some.at("identical"), false);
  EXPECT_EQ(some.at("largest"), 0.25);
  EXPECT_EQ(some.at("bias")[0], 0.125);
  EXPECT_EQ(some.at("bias")[1], 0.0);
  EXPECT_NEAR(some.at("MAE"), 0.25 / 6, 1e-7);
  // For people: rounded, aligned, and each number with what it means.
  const Outcome text = Process(folder, {"diff", a, b}).wait();
  EXPECT_THAT(text.out, ::testing::HasSubstr("MAE        0.0417    mean of |B - A|"));
  EXPECT_THAT(text.out, ::testing::HasSubstr("R +0.12, G +0, B +0"));
  EXPECT_THAT(text.out, ::testing::HasSubstr("largest    0.25      |B - A|"));
  EXPECT_THAT(text.out, ::testing::HasSubstr("identical  no        at least one value of one channel differs"));
  EXPECT_THAT(text.out, ::testing::HasSubstr("0 is best"));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace tress::test
