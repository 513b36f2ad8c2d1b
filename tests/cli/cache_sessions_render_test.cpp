// Eight renders at once, each with a fiber of its own, on one warm cache: nothing that any of them learned is lost.
#include <gmock/gmock.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "cli/run_tress.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;

class CacheSessionsOfRenders : public CommandTest {
 protected:
  static constexpr int sessions = 8;

  /// Renders all sessions at the same time; `cache` of session i.
  template <class CacheOf>
  void render_all(const std::string& run, CacheOf cache) const {
    std::vector<std::unique_ptr<Process>> running;
    for (int i = 0; i < sessions; ++i) {
      const fs::path folder = folder_ / (run + std::to_string(i));
      fs::create_directory(folder);
      running.push_back(std::make_unique<Process>(
          folder,
          std::vector<std::string>{"render", path("scene.json"), "-o", (folder / "a.exr").string(), "--threads", "1",
                                   "--eccentricity", "0." + std::to_string(70 + i), "--warm-cache", cache(i)}));
    }
    for (const auto& process : running) {
      const Outcome outcome = process->wait();
      EXPECT_EQ(outcome.status, 0) << outcome.err;
      EXPECT_THAT(outcome.err, HasSubstr("saved "));
    }
  }
};

TEST_F(CacheSessionsOfRenders, LoseNothing) {
  write_text(path("scene.json"), R"({
    "camera": {"frame": true},
    "image": {"width": 16, "height": 16, "samples": 16},
    "environment": {"constant": [1, 1, 1]},
    "materials": [{"name": "brown"}],
    "grooms": [{"generate": "straight", "strands": 300, "radius_cm": 0.04, "material": "brown"}]
  })");
  const std::string shared = path("shared.cache");
  render_all("together", [&](int) { return shared; });
  // Each again, for itself: same seed, so the same rows; joined, they must be the shared file to the byte.
  const auto own = [&](int i) { return path("own" + std::to_string(i) + ".cache"); };
  render_all("alone", own);
  std::vector<std::string> merge{"cache", "merge"};
  for (int i = 0; i < sessions; ++i) merge.push_back(own(i));
  merge.insert(merge.end(), {"-o", path("all.cache")});
  const Outcome merged = run(merge);
  ASSERT_EQ(merged.status, 0) << merged.err;
  EXPECT_EQ(read_text(shared), read_text(path("all.cache")));
  EXPECT_FALSE(fs::exists(shared + ".lock"));

  const auto info = nlohmann::json::parse(run({"cache", "info", shared, "--json"}).out);
  EXPECT_EQ(info.at("pages").size(), std::size_t{sessions}) << "one of each";
  std::uint64_t rows = 0;
  for (const auto& slice : info.at("pages")) {
    rows += slice.at("rows").at("open").get<std::uint64_t>() + slice.at("rows").at("converged").get<std::uint64_t>();
  }
  EXPECT_GT(rows, std::uint64_t{20 * sessions});
}

}  // namespace
}  // namespace tress::test
