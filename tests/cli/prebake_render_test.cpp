// tress cache prebake: a table made beforehand answers a render alone, and like the one that the render would make.
#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;

/// Wide lobes: few nodes.
constexpr const char* scene = R"({
  "camera": {"frame": true},
  "image": {"width": 24, "height": 24, "samples": 32},
  "environment": {"constant": [1, 1, 1]},
  "materials": [{"name": "brown", "roughness": 0.4}],
  "grooms": [{"generate": "straight", "strands": 200, "radius_cm": 0.05, "material": "brown"}]
})";

class Prebake : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("scene.json"), scene);
  }
  Outcome bake(const std::string& output, std::vector<std::string> more = {}) const {
    std::vector<std::string> command{"cache", "prebake", path("scene.json"), "-o", path(output), "--quiet"};
    command.insert(command.end(), more.begin(), more.end());
    return run(command);
  }
  nlohmann::json info(const std::string& file) const {
    return nlohmann::json::parse(run({"cache", "info", path(file), "--json"}).out);
  }
};

TEST_F(Prebake, AnswersEveryQueryOfAFrozenRenderAndGivesTheSameMean) {
  const Outcome baked = bake("t.cache", {"--telemetry", path("bake.jsonl")});
  ASSERT_EQ(baked.status, 0) << baked.err;
  EXPECT_THAT(baked.out, HasSubstr("0 refused"));
  const auto summary = telemetry_lines(path("bake.jsonl"), "summary");
  ASSERT_EQ(summary.size(), 1u);
  EXPECT_EQ(summary[0].at("rows_converged"), summary[0].at("nodes"));

  const Outcome warm = run({"render", path("scene.json"), "-o", path("warm.exr"), "--warm-cache", path("t.cache"),
                            "--cache-mode", "frozen", "--telemetry", path("warm.jsonl"), "--quiet"});
  ASSERT_EQ(warm.status, 0) << warm.err;
  const auto passes = telemetry_lines(path("warm.jsonl"), "pass");
  ASSERT_FALSE(passes.empty());
  for (const auto& pass : passes) {
    EXPECT_EQ(pass.at("converged_query_share").get<double>(), 1) << pass.at("pass");
    EXPECT_EQ(pass.at("traces").get<int>(), 0);
  }
  const Outcome cold = run({"render", path("scene.json"), "-o", path("cold.exr"), "--quiet"});
  ASSERT_EQ(cold.status, 0) << cold.err;
  const auto a = image::read_exr(path("cold.exr")), b = image::read_exr(path("warm.exr"));
  ASSERT_TRUE(a && b);
  for (const char* name : {"R", "G", "B"}) {
    const std::vector<float>&x = a->find(name)->pixels, &y = b->find(name)->pixels;
    const double n = static_cast<double>(x.size());
    double sum = 0, difference = 0, squares = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double d = static_cast<double>(y[i]) - x[i];
      sum += x[i];
      difference += d;
      squares += d * d;
    }
    // Pixels are independent of each other, so their differences give the error of the mean: four of those (one seed;
    // false alarm 2e-4 for the three channels), and 0.2 % for the fits, as measured of `fitted` against `exact`.
    const double error = std::sqrt((squares / n - difference * difference / (n * n)) / n);
    EXPECT_GT(sum / n, 20 * error) << "too noisy to show anything";
    EXPECT_NEAR(difference / n, 0, 4 * error + 0.002 * sum / n) << name;
  }
}

TEST_F(Prebake, IsTheSameFileForAnyNumberOfThreads) {
  for (const char* threads : {"1", "2", "8", "16"}) {
    ASSERT_EQ(bake(std::string(threads) + ".cache", {"--threads", threads}).status, 0);
  }
  EXPECT_EQ(read_text(path("1.cache")), read_text(path("2.cache")));
  EXPECT_EQ(read_text(path("1.cache")), read_text(path("8.cache")));
}

TEST_F(Prebake, ReportsWhenTheTableIsFull) {
  const Outcome baked = bake("small.cache", {"--table-memory", ".02"});
  EXPECT_EQ(baked.status, 0);
  EXPECT_THAT(baked.err, HasSubstr("--table-memory"));
  EXPECT_EQ(run({"cache", "verify", path("small.cache")}).status, 0);
}

TEST_F(Prebake, ReplacesACacheAndNothingElse) {
  write_text(path("notes.txt"), "these are notes, long enough to hold a header of a cache");
  const Outcome refused = bake("notes.txt");
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("warm cache to replace"));
  EXPECT_THAT(read_text(path("notes.txt")), HasSubstr("these are notes"));
  EXPECT_EQ(run({"cache", "prebake", path("none.json"), "-o", path("a.cache")}).status, 1);
  EXPECT_FALSE(fs::exists(path("a.cache")));
}

}  // namespace
}  // namespace tress::test
