// tress render --near: a fiber that is seen wide has the pattern across it that the traced fiber has.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;

/// A fiber of 96 um by 67 um that fills the picture.
constexpr const char* wide_fiber = R"({
  "camera": {"eye": [0, -4, -5], "look_at": [0, 0, -5], "vertical_fov_deg": 0.12},
  "image": {"width": 32, "height": 32, "samples": 256},
  "environment": {"studio": true}, "environment_visible": false,
  "materials": [{"name": "brown", "eccentricity": 0.7, "roughness": 0.15}],
  "grooms": [{"generate": "single_fiber", "radius_cm": 0.004, "material": "brown"}]
})";

class Near : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("scene.json"), wide_fiber);
  }
  /// Means of the columns, which are places across the fiber, by channel.
  std::vector<double> profile(const std::vector<std::string>& options) const {
    std::vector<std::string> command{"render", path("scene.json"), "-o", path("a.exr"), "--quiet"};
    command.insert(command.end(), options.begin(), options.end());
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const auto read = image::read_exr(path("a.exr"));
    EXPECT_TRUE(read);
    std::vector<double> means;
    if (!read) return means;
    const image::Picture& picture = *read;
    for (const image::Channel& channel : picture.channels) {
      if (channel.name != "R" && channel.name != "G" && channel.name != "B") continue;
      for (int x = 0; x < picture.width; ++x) {
        double sum = 0;
        for (int y = 0; y < picture.height; ++y)
          sum += static_cast<double>(channel.pixels[static_cast<std::size_t>(y * picture.width + x)]);
        means.push_back(sum / picture.height);
      }
    }
    return means;
  }
};

double relative_l2(const std::vector<double>& a, const std::vector<double>& b) {
  double off = 0, all = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    off += (a[i] - b[i]) * (a[i] - b[i]);
    all += b[i] * b[i];
  }
  return std::sqrt(off / all);
}

// A column is the mean of 8,192 samples of the truth, by 256 x 32 of ours; told noise of a pixel of 256 samples is 0.1
// to 0.2, so that a column is off by 0.02 to 0.04. A row, which is the mean over the width, is off by 0.3 and more.
TEST_F(Near, AWideFiberHasThePatternOfTheTracedOne) {
  const std::vector<double> truth = profile({"--model", "fiber3d"});
  EXPECT_LT(relative_l2(profile({"--near", "2"}), truth), 0.1);
  EXPECT_GT(relative_l2(profile({}), truth), 0.2);
}

TEST_F(Near, AsksForAModelThatTracesItsFibers) {
  const Outcome outcome =
      run({"render", path("scene.json"), "-o", path("a.exr"), "--quiet", "--near", "2", "--model", "elliptical"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--near: expected a model with rows that can trace its fibers"));
}

TEST_F(Near, LeavesThePictureOfNarrowFibersAsItIs) {
  std::vector<std::string> small{"--resolution", "3x3", "--spp", "4"};
  const std::vector<double> without = profile(small);
  small.insert(small.end(), {"--near", "2"});
  EXPECT_NE(profile(small), without) << "it is 3.4 pixels wide";
  small.back() = "4";
  EXPECT_EQ(profile(small), without);
}

}  // namespace
}  // namespace tress::test
