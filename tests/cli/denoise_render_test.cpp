// tress denoise on what tress render writes.
#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;

constexpr const char* lock = R"({
    "camera": {"frame": true},
    "image": {"width": 40, "height": 40},
    "environment": {"studio": true},
    "materials": [{"name": "brown"}],
    "grooms": [{"generate": "straight", "strands": 1500, "radius_cm": 0.02, "material": "brown"}]
  })";

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

TEST_F(CommandTest, ARenderDenoisesItselfAsTressDenoiseWould) {
  write_text(path("scene.json"), lock);
  const auto render = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> words{
        "render", path("scene.json"), "-o",  path(name),      "--spp",     "8", "--precision", "float", "--exposure",
        "1.5",    "--view",           "agx", "--transparent", "--threads", "2"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome done = run(words);
    ASSERT_EQ(done.status, 0) << done.err;
  };
  render("whole.exr", {"--layers", "all,half", "--quiet"});
  render("one.exr", {"--denoise", "--layers", "albedo"});
  const Outcome done = run({"denoise", path("whole.exr"), "-o", path("clean.exr"), "--precision", "float"});
  ASSERT_EQ(done.status, 0) << done.err;
  const auto whole = image::read_exr(path("whole.exr")), clean = image::read_exr(path("clean.exr")),
             one = image::read_exr(path("one.exr"));
  ASSERT_TRUE(whole && clean && one);
  for (const char* c : {"R", "G", "B"}) {
    EXPECT_EQ(one->find(c)->pixels, whole->find(c)->pixels) << "as rendered: " << c;
    ASSERT_NE(one->find(std::string("denoised.") + c), nullptr);
    EXPECT_EQ(one->find(std::string("denoised.") + c)->pixels, clean->find(c)->pixels) << c;
  }
  for (const char* gone : {"half_a.R", "half_b_variance.G", "tangent.X"}) EXPECT_EQ(one->find(gone), nullptr) << gone;
  EXPECT_NE(one->find("albedo.R"), nullptr);
  EXPECT_EQ(read_text(path("one.png")), read_text(path("clean.png"))) << "alpha, exposure and view of both";
  EXPECT_NE(read_text(path("one.png")), read_text(path("whole.png")));
  EXPECT_THAT(one->metadata.at("denoised"), HasSubstr("R, G, B are as they were rendered"));
  EXPECT_LT(std::stod(one->metadata.at("denoised_noise")), std::stod(one->metadata.at("noise")));
}

TEST_F(CommandTest, NoiseWithDenoiseIsThatOfTheFilteredPicture) {
  write_text(path("scene.json"), lock);
  const auto render = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> words{"render", path("scene.json"), "-o", path(name), "--seed", "3", "--denoise"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  };
  ASSERT_EQ(render("a.exr", {"--noise", "0.05", "--telemetry", path("a.jsonl")}).status, 0);
  const auto picture = image::read_exr(path("a.exr"));
  ASSERT_TRUE(picture);
  const double left = std::stod(picture->metadata.at("denoised_noise"));
  EXPECT_LE(left, 0.05);
  EXPECT_GT(left, 0.035) << "no more samples than a step too many";
  EXPECT_GT(std::stod(picture->metadata.at("noise")), 0.05);
  EXPECT_EQ(picture->metadata.at("stopped_by"), "noise");
  EXPECT_THAT(read_text(path("a.jsonl")), HasSubstr("\"denoised_noise\":"));
  const std::string passes = std::to_string(std::lround(std::stod(picture->metadata.at("samples"))));
  ASSERT_EQ(render("b.exr", {"--spp", passes, "--adaptive", "on"}).status, 0);
  EXPECT_EQ(image::read_exr(path("b.exr"))->find("denoised.G")->pixels, picture->find("denoised.G")->pixels);
  EXPECT_THAT(render("c.exr", {"--spp", "3"}).err,
              HasSubstr("--denoise: expected 4 samples a pixel at least, found 3"));
  EXPECT_THAT(render("c.exr", {"--spp", "8", "--part", path("c.part")}).err,
              HasSubstr("--denoise: expected no --part"));
}

}  // namespace
}  // namespace tress::test
