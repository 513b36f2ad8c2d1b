// --model rough against --model fiber3d, the same scene and the same paths: before its rows have converged it is the
// truth, after that it is off by no more than telemetry reports.
#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;

/// Blond strands in a heap under light from above.
constexpr const char* rough_scene = R"({
  "camera": {"frame": true},
  "image": {"width": 64, "height": 64, "samples": 64},
  "environment": {"sky": {"zenith": [1, 1, 1], "horizon": [0.4, 0.4, 0.4], "ground": [0, 0, 0]}},
  "environment_visible": false,
  "materials": [{"name": "blond", "eccentricity": 0.75, "roughness": 0.25, "sigma_a": [0.05, 0.15, 0.5]}],
  "grooms": [{"generate": "straight", "strands": 300, "radius_cm": 0.05, "material": "blond"}]
})";

class Rough : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("scene.json"), rough_scene);
  }
  image::Picture rendered(const std::string& name, std::vector<std::string> more) const {
    std::vector<std::string> command{"render",  path("scene.json"), "-o",         path(name + ".exr"),
                                     "--quiet", "--crop",           "22,14,42,52"};
    command.insert(command.end(), more.begin(), more.end());
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    auto picture = image::read_exr(path(name + ".exr"));
    EXPECT_TRUE(picture);
    return picture ? std::move(*picture) : image::Picture();
  }
  double reported(const std::string& name, const char* field) const {
    return telemetry_lines(path(name + ".jsonl"), "summary").at(0).at(field).get<double>();
  }

  /// Means of R, G, B: within z standard errors and the bound, both relative to the mean. Pixels are independent of
  /// each other, so their differences give the error of the mean.
  static void expect_means(const image::Picture& truth, const image::Picture& found, double z, double bound) {
    for (const char* name : {"R", "G", "B"}) {
      const std::vector<float>&x = truth.find(name)->pixels, &y = found.find(name)->pixels;
      const double n = static_cast<double>(x.size());
      double sum = 0, difference = 0, squares = 0;
      for (std::size_t i = 0; i < x.size(); ++i) {
        const double d = double{y[i]} - double{x[i]};
        sum += x[i];
        difference += d;
        squares += d * d;
      }
      const double error = std::sqrt((squares / n - difference * difference / (n * n)) / n);
      EXPECT_GT(sum / n, 50 * error) << "too noisy to show anything";
      EXPECT_NEAR(difference / n, 0, z * error + bound * sum / n) << name;
      std::printf("%s: %+.4f of the mean, standard error %.4f, bound %.4f\n", name, difference / sum, error * n / sum,
                  bound);
    }
  }
};

// Without rows every event is a path of fiber3d, which lights that are sampled are balanced with: as bright within four
// standard errors (false alarm 2e-4 over three channels; one seed).
TEST_F(Rough, IsFiber3dUnderSampledLights) {
  const image::Picture truth = rendered("truth", {"--model", "fiber3d", "--spp", "1024"});
  const image::Picture exact =
      rendered("exact", {"--model", "rough", "--spp", "512", "--estimator", "exact", "--seed", "1"});
  expect_means(truth, exact, 4, 0);
}

// No room for a row: every event is such a path, which a value towards the lights is balanced with. As bright as the
// truth within four standard errors (false alarm 2e-4 over three channels; one seed).
TEST_F(Rough, IsUnbiasedWhereNoRowHasConverged) {
  const image::Picture truth = rendered("truth", {"--model", "fiber3d", "--spp", "1024"});
  const image::Picture open =
      rendered("open", {"--model", "rough", "--spp", "1024", "--table-memory", "0", "--seed", "1"});
  expect_means(truth, open, 4, 0);
}

// A coarse epsilon, so that there is something to be seen: three standard errors (false alarm 8e-3 over three channels;
// one seed) and what telemetry reports. Cold, where most light still comes from traced events, and by its table alone.
TEST_F(Rough, IsWithinTheBoundThatItReports) {
  const image::Picture truth = rendered("truth", {"--model", "fiber3d", "--spp", "256"});
  const std::vector<std::string> coarse{"--model", "rough", "--epsilon", "0.3", "--warm-cache", path("t.cache")};
  std::vector<std::string> cold = coarse, warm = coarse;
  cold.insert(cold.end(), {"--telemetry", path("cold.jsonl"), "--seed", "1"});
  warm.insert(warm.end(), {"--telemetry", path("warm.jsonl"), "--seed", "2", "--cache-mode", "frozen"});
  const image::Picture first = rendered("cold", cold), second = rendered("warm", warm);
  EXPECT_GT(reported("cold", "bias_bound"), 0);
  expect_means(truth, first, 3, reported("cold", "bias_bound"));
  expect_means(truth, second, 3, reported("cold", "bias_bound"));
  // The bound is of the worst light. Measured of this one, by 3 x 512 samples a pixel: 0.03 too bright at this epsilon,
  // 0.015 at the default, 0.01 at 0.015.
  expect_means(truth, second, 3, 0.03);
  const auto passes = telemetry_lines(path("warm.jsonl"), "pass");
  EXPECT_GT(passes.back().at("converged_query_share").get<double>(), 0.9);
}

TEST_F(Rough, RefusesByNameWhatHasNoMeaningForIt) {
  const auto refused = [&](const std::vector<std::string>& more, const char* said) {
    std::vector<std::string> command{"render", path("scene.json"), "-o", path("a.exr"), "--model", "rough"};
    command.insert(command.end(), more.begin(), more.end());
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.err, HasSubstr(said));
    EXPECT_FALSE(fs::exists(path("a.exr")));
  };
  refused({"--estimator", "corrected"}, "--estimator corrected: expected a model whose scattering can be evaluated");
  refused({"--learner", "sketch"}, "--learner: expected a model whose rows a learner fits (elliptical");
  refused({"--components", "4"}, "--components: expected");
}

TEST_F(Rough, IsPrebakedAndSharesACacheWithElliptical) {
  ASSERT_EQ(rendered("elliptical", {"--model", "elliptical", "--spp", "8", "--warm-cache", path("both.cache")}).width,
            20);
  const auto rows = [&] { return nlohmann::json::parse(run({"cache", "info", path("both.cache"), "--json"}).out); };
  const int before = rows().at("rows").at("converged").get<int>();
  ASSERT_GT(before, 0);
  rendered("rough", {"--model", "rough", "--epsilon", "0.3", "--spp", "8", "--warm-cache", path("both.cache")});
  const int after = rows().at("rows").at("converged").get<int>();
  EXPECT_GT(after, before) << "rows of both";
  rendered("again", {"--model", "elliptical", "--spp", "8", "--warm-cache", path("both.cache")});
  EXPECT_GE(rows().at("rows").at("converged").get<int>(), after) << "elliptical keeps what rough learned";

  const Outcome baked = run({"cache", "prebake", path("scene.json"), "-o", path("baked.cache"), "--model", "rough",
                             "--epsilon", "0.5", "--quiet"});
  EXPECT_EQ(baked.status, 0) << baked.err;
  EXPECT_THAT(baked.out, HasSubstr(" 481 of them converged"));
  rendered("frozen", {"--model", "rough", "--epsilon", "0.5", "--spp", "2", "--warm-cache", path("baked.cache"),
                      "--cache-mode", "frozen", "--telemetry", path("frozen.jsonl")});
  for (const auto& pass : telemetry_lines(path("frozen.jsonl"), "pass"))
    EXPECT_EQ(pass.at("converged_query_share").get<double>(), 1);
}

}  // namespace
}  // namespace tress::test
