// --warm-cache default: one place for all that was learned, by kind of fiber, within a limit.
#include <gmock/gmock.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "cli/run_tress.h"

namespace tress::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

class DefaultCache : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    // Of this process and those that it starts; each test has a process of its own, or none that needs the old value.
    ::setenv("XDG_CACHE_HOME", path("caches").c_str(), 1);
    write_text(path("scene.json"), R"({
      "camera": {"frame": true},
      "image": {"width": 16, "height": 16, "samples": 16},
      "environment": {"constant": [1, 1, 1]},
      "materials": [{"name": "brown"}],
      "grooms": [{"generate": "straight", "strands": 300, "radius_cm": 0.04, "material": "brown"}]
    })");
  }
  void TearDown() override {
    ::unsetenv("XDG_CACHE_HOME");
    CommandTest::TearDown();
  }
  Outcome render(const std::vector<std::string>& more) const {
    std::vector<std::string> words{"render", path("scene.json"), "-o", path("a.exr"), "--warm-cache", "default"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
  Json info(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"cache", "info", "default", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return Json::parse(outcome.out, nullptr, false);
  }
  std::size_t files() const {
    std::size_t count = 0;
    std::error_code absent;
    for (const auto& entry : fs::directory_iterator(path("caches/tress"), absent))
      count += entry.path().extension() == ".cache";
    return count;
  }
};

TEST_F(DefaultCache, IsMadeAndStartsTheNextRenderWarm) {
  const Outcome cold = render({"--telemetry", path("cold.jsonl")});
  ASSERT_EQ(cold.status, 0) << cold.err;
  EXPECT_THAT(cold.err, HasSubstr("has no fiber of this scene yet, starting cold"));
  EXPECT_EQ(files(), 1u);
  const Outcome warm = render({"--telemetry", path("warm.jsonl"), "--cache-mode", "require"});
  ASSERT_EQ(warm.status, 0) << warm.err;
  EXPECT_THAT(warm.err, HasSubstr("from 1 of 1 pages (require)"));
  const Json cache = telemetry_lines(path("warm.jsonl"), "summary").at(0).at("warm_cache");
  EXPECT_EQ(cache.at("loaded"), "loaded");
  EXPECT_EQ(cache.at("file"), path("caches/tress"));
  EXPECT_GT(cache.at("rows_known").get<int>(), 0);
  EXPECT_FALSE(fs::exists(path("default"))) << "no file of that name";
}

TEST_F(DefaultCache, HoldsAFileForEachKindOfFiberAndReadsItsOwn) {
  ASSERT_EQ(render({}).status, 0);
  ASSERT_EQ(render({"--eccentricity", "0.7"}).status, 0);
  EXPECT_EQ(files(), 2u);
  ASSERT_EQ(render({"--model", "elliptical"}).status, 0);
  EXPECT_EQ(files(), 5u) << "TT, TRT and TRRT";
  const Outcome again = render({"--eccentricity", "0.7", "--telemetry", path("t.jsonl")});
  ASSERT_EQ(again.status, 0) << again.err;
  const Json all = info();
  EXPECT_EQ(all.at("files"), 5);
  EXPECT_EQ(all.at("folder"), path("caches/tress"));
  EXPECT_EQ(all.at("pages").size(), 5u);
  const int loaded = telemetry_lines(path("t.jsonl"), "summary").at(0).at("warm_cache").at("rows_loaded").get<int>();
  EXPECT_LT(loaded, all.at("rows").at("converged").get<int>() + all.at("rows").at("open").get<int>());
  EXPECT_THAT(run({"cache", "info", "default"}).out, AllOf(HasSubstr("files   5\n"), HasSubstr("eccentricity 0.7")));
  EXPECT_GT(info({"--for", path("scene.json")}).at("warm_start").at("share").at("answered").get<int>(), 0);
}

TEST_F(DefaultCache, KeepsItsModes) {
  EXPECT_EQ(render({"--cache-mode", "require"}).status, 1);
  EXPECT_FALSE(fs::exists(path("a.exr")));
  ASSERT_EQ(render({"--cache-mode", "frozen"}).status, 0);
  EXPECT_EQ(files(), 0u) << "frozen must not save";
  ASSERT_EQ(render({}).status, 0);
  const std::string hash = info().at("pages").dump();
  ASSERT_EQ(render({"--cache-mode", "frozen", "--seed", "1"}).status, 0);
  EXPECT_EQ(info().at("pages").dump(), hash) << "frozen must not save";
  ASSERT_EQ(render({"--seed", "2", "--resolution", "160x160"}).status, 0);  // events enough to grow by
  EXPECT_NE(info().at("pages").dump(), hash);
  ASSERT_EQ(render({"--cache-mode", "scratch"}).status, 0);
  EXPECT_EQ(info().at("pages").dump(), hash) << "scratch forgets what was there";
}

TEST_F(DefaultCache, LetsGoWhatWasUsedLongestAgo) {
  ASSERT_EQ(render({}).status, 0);
  const double first = info().at("bytes").get<double>() / (1 << 20);
  for (const auto& entry : fs::directory_iterator(path("caches/tress")))
    fs::last_write_time(entry.path(), fs::file_time_type::clock::now() - std::chrono::hours(1));
  const Outcome other = render({"--eccentricity", "0.7", "--cache-limit", std::to_string(1.5 * first)});
  ASSERT_EQ(other.status, 0) << other.err;
  EXPECT_THAT(other.err, HasSubstr("removed 1 files that were used longest ago"));
  EXPECT_EQ(files(), 1u);
  EXPECT_THAT(run({"cache", "info", "default"}).out, HasSubstr("eccentricity 0.7"));

  ASSERT_EQ(render({}).status, 0);
  EXPECT_EQ(files(), 2u);
  EXPECT_THAT(run({"cache", "prune"}).out, HasSubstr("removed 0 files, 0 MB"));
  const Outcome pruned = run({"cache", "prune", "--limit", "0"});
  EXPECT_EQ(pruned.status, 0) << pruned.err;
  EXPECT_THAT(pruned.out, AllOf(HasSubstr("removed 2 files"), HasSubstr("0 files, 0 MB are left")));
  EXPECT_EQ(files(), 0u);
}

TEST_F(DefaultCache, IsRefusedWhereThereCanBeNone) {
  ::setenv("XDG_CACHE_HOME", path("scene.json").c_str(), 1);
  const Outcome outcome = render({});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("scene.json/tress: expected a folder, or a place where one can be made"));
  const Outcome limited =
      run({"render", path("scene.json"), "-o", path("a.exr"), "--warm-cache", path("c"), "--cache-limit", "10"});
  EXPECT_EQ(limited.status, 2);
  EXPECT_THAT(limited.err, HasSubstr("--cache-limit: expected --warm-cache default, found "));
  const Outcome farm = run({"farm", path("scene.json"), "-o", path("####.exr"), "--frames", "1-2", "--warm-cache",
                            "default", "--folder", path("f.farm")});
  EXPECT_EQ(farm.status, 2);
  EXPECT_THAT(farm.err, HasSubstr("--warm-cache: expected a file that all machines share"));
}

}  // namespace
}  // namespace tress::test
