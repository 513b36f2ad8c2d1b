// Short renders of changing shots on one warm cache: twice the same, to the byte, whatever the threads. The long run is
// bench/atlas/07_soak.py.
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

class Soak : public CommandTest {
 protected:
  static constexpr int renders = 12;

  struct Rendered {
    std::vector<std::string> caches;  ///< bytes of the file after each render
    std::vector<std::vector<float>> beauty;
    std::vector<double> g_share;
  };

  Rendered render_all(const std::string& name, const std::array<int, 3>& threads) const {
    Rendered rendered;
    const std::string cache = path(name + ".cache");
    for (int i = 0; i < renders; ++i) {
      const std::string picture = path(name + ".exr"), telemetry = path(name + ".jsonl");
      const Outcome outcome = run({"render",
                                   path("scene.json"),
                                   "-o",
                                   picture,
                                   "--model",
                                   "elliptical",
                                   "--warm-cache",
                                   cache,
                                   "--telemetry",
                                   telemetry,
                                   "--frame",
                                   std::to_string(5 * i % 8),
                                   "--eccentricity",
                                   i % 2 == 0 ? "0.8" : "1",
                                   "--melanin",
                                   "0." + std::to_string(i + 1),
                                   "--resolution",
                                   i % 3 == 0 ? "16x20" : "20x16",
                                   "--seed",
                                   std::to_string(i),
                                   "--threads",
                                   std::to_string(threads[static_cast<std::size_t>(i) % threads.size()])});
      EXPECT_EQ(outcome.status, 0) << outcome.err;
      rendered.caches.push_back(read_text(cache));
      const Result<image::Picture> read = image::read_exr(picture);
      if (!read) {
        ADD_FAILURE() << read.error().message();
        return rendered;
      }
      rendered.beauty.push_back(read->find("G")->pixels);
      const nlohmann::json summary = telemetry_lines(telemetry, "summary").at(0);
      rendered.g_share.push_back(summary.at("exact_queries").get<double>() / summary.at("queries").get<double>());
    }
    return rendered;
  }
};

TEST_F(Soak, TwelveRendersOnOneCacheAreTheSameToTheByteWithOtherThreads) {
  write_text(path("scene.json"), R"({
    "camera": {"turntable": {"frames": 8}},
    "image": {"samples": 4},
    "environment": {"studio": true},
    "environment_visible": false,
    "materials": [{"name": "hair", "roughness": 0.3}],
    "grooms": [{"generate": "curly_lock", "strands": 100, "radius_cm": 0.08, "material": "hair"}]
  })");
  const Rendered one = render_all("one", {1, 1, 1}), other = render_all("other", {8, 2, 1});
  ASSERT_EQ(one.caches.size(), other.caches.size());
  for (std::size_t i = 0; i < one.caches.size(); ++i) {
    EXPECT_TRUE(one.caches[i] == other.caches[i]) << "cache after render " << i;
    EXPECT_EQ(one.beauty[i], other.beauty[i]) << "picture " << i;
  }
  // Two materials take turns, and the cache spares some of what the first two renders had to trace.
  EXPECT_LT(one.g_share[10], 0.8 * one.g_share[0]);
  EXPECT_LT(one.g_share[11], 0.8 * one.g_share[1]);
}

}  // namespace
}  // namespace tress::test
