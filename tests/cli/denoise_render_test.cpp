// tress denoise on what tress render writes.
#include <gmock/gmock.h>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;

TEST_F(CommandTest, DenoiseBringsARenderNearerToOneOfMoreSamples) {
  write_text(path("scene.json"), R"({
    "camera": {"frame": true},
    "image": {"width": 40, "height": 40, "transparent": true},
    "environment": {"studio": true},
    "materials": [{"name": "brown"}],
    "grooms": [{"generate": "straight", "strands": 1500, "radius_cm": 0.02, "material": "brown"}]
  })");
  const auto render = [&](const std::string& name, const std::string& samples, const std::string& seed) {
    const Outcome done = run({"render", path("scene.json"), "-o", path(name), "--spp", samples, "--seed", seed,
                              "--layers", "all,half", "--quiet"});
    ASSERT_EQ(done.status, 0) << done.err;
  };
  render("noisy.exr", "8", "1");
  render("truth.exr", "128", "2");
  const Outcome done = run({"denoise", path("noisy.exr"), "-o", path("clean.exr")});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_THAT(done.err, HasSubstr("a pixel is off by"));
  EXPECT_TRUE(fs::exists(path("clean.png")));
  const auto noisy = image::read_exr(path("noisy.exr")), clean = image::read_exr(path("clean.exr")),
             truth = image::read_exr(path("truth.exr"));
  ASSERT_TRUE(noisy && clean && truth);
  const double before = image::compare(*truth, *noisy, "a", "b")->rel_mse,
               after = image::compare(*truth, *clean, "a", "b")->rel_mse;
  EXPECT_LT(after, 0.6 * before);
  EXPECT_THAT(clean->metadata.at("denoised"), HasSubstr("of the mean brightness"));
  EXPECT_EQ(clean->find("A")->pixels, noisy->find("A")->pixels) << "other layers stay as they were";
  EXPECT_EQ(clean->find("half_a.R"), nullptr);
  const Outcome again = run({"denoise", path("clean.exr"), "-o", path("twice.exr")});
  EXPECT_EQ(again.status, 1);
  EXPECT_THAT(again.err, HasSubstr("tress render --layers all,half"));
}

}  // namespace
}  // namespace tress::test
