// tress render --spectral: another picture of melanin, the same of its option and its key.
#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;

class Spectral : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("scene.json"), R"({"camera": {"frame": true}, "image": {"width": 24, "height": 24, "samples": 4},
      "environment": {"constant": [1, 0.6, 0.3]},
      "materials": [{"name": "red", "melanin": {"pheomelanin": 1}}],
      "grooms": [{"generate": "straight", "strands": 300, "radius_cm": 0.05, "material": "red"}]})");
  }
  Outcome part(const std::string& name, const std::vector<std::string>& more) const {
    std::vector<std::string> words{"render",  path("scene.json"), "-o",     path(name + ".exr"),
                                   "--model", "fiber3d",          "--part", path(name + ".part")};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
};

TEST_F(Spectral, OptionAndKeyAreOneAndPartsOfOthersAreRefused) {
  ASSERT_EQ(part("option", {"--spectral", "--samples-to", "2"}).status, 0);
  ASSERT_EQ(part("key", {"--set", "integrator/spectral=true", "--samples-from", "2"}).status, 0);
  ASSERT_EQ(part("colors", {"--samples-from", "2"}).status, 0);
  const Outcome merged = run({"merge", path("option.part"), path("key.part"), "-o", path("merged.exr")});
  EXPECT_EQ(merged.status, 0) << merged.err;
  const Outcome refused = run({"merge", path("option.part"), path("colors.part"), "-o", path("no.exr")});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("/integrator/spectral: expected true, found nothing"));
}

// The light is its own colors, seen past the hair: 1e-3 is the rounding of half floats.
TEST_F(Spectral, PictureIsRgb) {
  ASSERT_EQ(part("bands", {"--spectral"}).status, 0);
  ASSERT_EQ(part("colors", {}).status, 0);
  const auto bands = image::read_exr(path("bands.exr")), colors = image::read_exr(path("colors.exr"));
  ASSERT_TRUE(bands && colors);
  const auto largest = [](const image::Channel* channel) {
    return *std::max_element(channel->pixels.begin(), channel->pixels.end());
  };
  for (const char* channel : {"background.R", "background.G", "background.B"}) {
    ASSERT_NE(bands->find(channel), nullptr) << channel;
    EXPECT_NEAR(largest(bands->find(channel)), largest(colors->find(channel)), 1e-3f) << channel;
  }
  EXPECT_NE(bands->find("TT.R")->pixels, colors->find("TT.R")->pixels);
}

}  // namespace
}  // namespace tress::test
