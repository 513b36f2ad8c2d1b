// A table made beforehand by a learner that does not converge.
#include <gmock/gmock.h>

#include <string>

#include "cli/run_tress.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using LaboratoryPrebake = CommandTest;

/// Wide lobes: few nodes.
constexpr const char* scene = R"({
  "camera": {"frame": true},
  "image": {"width": 24, "height": 24, "samples": 32},
  "environment": {"constant": [1, 1, 1]},
  "materials": [{"name": "brown", "roughness": 0.4}],
  "grooms": [{"generate": "straight", "strands": 200, "radius_cm": 0.05, "material": "brown"}]
})";

TEST_F(LaboratoryPrebake, ReportsWhatDidNotConvergeAndSavesItAsOpen) {
  write_text(path("scene.json"), scene);
  const Outcome baked = run({"cache", "prebake", path("scene.json"), "-o", path("l.cache"), "--quiet", "--model",
                             "elliptical", "--learner", "appendix-literal"});
  EXPECT_EQ(baked.status, 0);
  EXPECT_THAT(baked.err, HasSubstr("did not converge"));
  EXPECT_GT(
      nlohmann::json::parse(run({"cache", "info", path("l.cache"), "--json"}).out).at("rows").at("open").get<int>(), 0);
  // A learner that can, takes them over.
  const Outcome warm = run({"render", path("scene.json"), "-o", path("warm.exr"), "--warm-cache", path("l.cache"),
                            "--model", "elliptical", "--telemetry", path("warm.jsonl"), "--quiet"});
  ASSERT_EQ(warm.status, 0) << warm.err;
  EXPECT_GT(telemetry_lines(path("warm.jsonl"), "pass").back().at("converged_query_share").get<double>(), 0.9);
}

}  // namespace
}  // namespace tress::test
