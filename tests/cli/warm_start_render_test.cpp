// How much of a scene starts warm from a cache, against what renders do; and which rows a changed parameter touches.
#include <gmock/gmock.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "adaptive/cache_images.h"
#include "cli/run_tress.h"
#include "tress/adaptive/cache.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

class WarmStart : public CommandTest {
 protected:
  /// Two grooms of two materials; `left`: more keys of the first one.
  void write_scene(const std::string& left, const std::string& right = "") const {
    const auto material = [](const std::string& name, const std::string& more) {
      return R"({"name": ")" + name + "\"" + (more.empty() ? "" : ", " + more) + "}";
    };
    write_text(path("scene.json"), R"({
      "camera": {"frame": true},
      "image": {"width": 32, "height": 32, "samples": 4},
      "environment": {"constant": [1, 1, 1]},
      "materials": [)" + material("brown", left) +
                                       ", " + material("blond", right) + R"(],
      "grooms": [{"name": "left", "generate": "straight", "strands": 200, "radius_cm": 0.04, "material": "brown"},
                 {"name": "right", "generate": "curly", "strands": 200, "radius_cm": 0.04, "material": "blond"}]
    })");
  }
  void render(const std::string& cache, const std::vector<std::string>& more) const {
    std::vector<std::string> words{"render", path("scene.json"), "-o", path("a.exr"), "--warm-cache", path(cache)};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  Json warm_start(const std::string& cache, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"cache", "info", path(cache), "--json", "--for", path("scene.json")};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return Json::parse(outcome.out).at("warm_start");
  }
  /// The parameters that each missing lobe of the scene has otherwise than the cache: "TT" to "blur_deg ".
  std::map<std::string, std::string> missing(const std::string& cache,
                                             const std::vector<std::string>& more = {}) const {
    std::map<std::string, std::string> lobes;
    const Json start = warm_start(cache, more);
    for (const Json& slice : start.at("slices")) {
      if (slice.at("in_cache").get<bool>()) continue;
      for (const Json& one : slice.at("differs"))
        lobes[slice.at("lobe").get<std::string>()] += one.at("parameter").get<std::string>() + " ";
    }
    return lobes;
  }
};

constexpr const char* wide = R"("eccentricity": 0.75)";

TEST_F(WarmStart, CountsTheQueriesThatAFrozenRenderMakes) {
  write_scene("", wide);
  for (const std::string model : {"elliptical", "rough"}) {
    SCOPED_TRACE(model);
    const std::string cache = model + ".cache";
    render(cache, {"--model", model, "--spp", "8"});
    render(cache, {"--model", model, "--cache-mode", "frozen", "--telemetry", path("frozen.jsonl")});
    std::uint64_t queries = 0;
    double answered = 0;
    for (const Json& pass : telemetry_lines(path("frozen.jsonl"), "pass")) {
      queries += pass.at("queries").get<std::uint64_t>();
      answered += pass.at("answered_query_share").get<double>() * pass.at("queries").get<double>();
    }
    const Json start = warm_start(cache, {"--model", model});
    EXPECT_EQ(start.at("model"), model);
    // The same paths, but for a shadow roulette that the pilot's own look-ups precede: within a thousandth.
    const double share = start.at("share").at("share").get<double>();
    EXPECT_NEAR(share, answered / static_cast<double>(queries), 0.002);
    EXPECT_NEAR(start.at("share").at("queries").get<double>() / static_cast<double>(queries), 1, 0.02);
    EXPECT_GT(share, 0.2);
    if (model == "elliptical") {
      EXPECT_LT(share, 0.999) << "so few samples do not learn all";
    } else {
      EXPECT_EQ(share, 1) << "coarse rows answer what has no row";
    }
    EXPECT_EQ(start, warm_start(cache, {"--model", model, "--threads", "1"})) << "the same for any number of threads";
    std::uint64_t asked = 0, cold = 0, explained = 0;
    for (const Json& slice : start.at("slices")) {
      asked += slice.at("share").at("queries").get<std::uint64_t>();
      cold += slice.at("rows").at("asked").get<std::uint64_t>() - slice.at("rows").at("answering").get<std::uint64_t>();
      for (const auto& [why, rows] : slice.at("missing").items()) explained += rows.get<std::uint64_t>();
      for (const Json& row : slice.at("missing_rows")) EXPECT_TRUE(row.contains("angles"));
    }
    EXPECT_EQ(asked, start.at("share").at("queries").get<std::uint64_t>());
    EXPECT_EQ(cold, explained) << "each row that is missing has a reason";
  }
}

TEST_F(WarmStart, NamesTheGroomThatStartsColdAndTheParameterThatMakesIt) {
  write_scene("");
  render("c", {"--spp", "8", "--model", "elliptical"});
  write_scene("", wide);
  const std::vector<std::string> elliptical{"--model", "elliptical"};
  const Json start = warm_start("c", elliptical);
  ASSERT_EQ(start.at("grooms").size(), 2u);
  EXPECT_EQ(start.at("grooms")[0].at("name"), "left");
  EXPECT_GT(start.at("grooms")[0].at("share").at("share").get<double>(), 0.7);
  EXPECT_EQ(start.at("grooms")[1].at("material"), "blond");
  EXPECT_EQ(start.at("grooms")[1].at("share").at("answered"), 0);
  const std::map<std::string, std::string> all{
      {"TT", "eccentricity "}, {"TRT", "eccentricity "}, {"TRRT", "eccentricity "}};
  EXPECT_EQ(missing("c", elliptical), all);
  EXPECT_EQ(warm_start("c").at("model"), "rough") << "that of the scene, whatever rows the cache has";
  const std::string text = run({"cache", "info", path("c"), "--for", path("scene.json"), "--model", "elliptical"}).out;
  EXPECT_THAT(text, HasSubstr("groom right, material blond: 0 of the queries of its hair"));
  EXPECT_THAT(text, HasSubstr("not in the cache: the cache has eccentricity 0.85, the scene asks 0.75"));
  EXPECT_THAT(text, HasSubstr("hair    eta 1.55, eccentricity 0.85, roughness 0.2 (TT, TRT, TRRT): "));

  // Rows that are there and not good enough, and a cache that no render takes.
  const Json strict = warm_start("c", {"--model", "elliptical", "--epsilon", "0.002"});
  std::uint64_t coarse = 0;
  for (const Json& slice : strict.at("slices")) coarse += slice.at("missing").value("coarse", 0u);
  EXPECT_GT(coarse, 100u);
  write_text(path("p"), encode_cache(adaptive::small_image()));
  const Json refused = warm_start("p");
  EXPECT_THAT(refused.at("refused").get<std::string>(), HasSubstr("expected elliptical-1, found elliptical-test"));
  EXPECT_EQ(refused.at("share").at("answered"), 0);
  EXPECT_EQ(run({"cache", "info", path("c"), "--epsilon", "0.1"}).status, 2) << "nothing to be asked for";
  EXPECT_EQ(run({"cache", "info", path("c"), "--for", path("none.json")}).status, 1);
}

TEST_F(WarmStart, AChangedParameterAsksOnlyTheSlicesThatItIsOf) {
  using Lobes = std::map<std::string, std::string>;
  write_scene("", wide);
  render("c", {"--spp", "2", "--model", "elliptical"});
  render("c", {"--model", "rough", "--spp", "16"});
  const Lobes every_lobe{{"TT", "eta "}, {"TRT", "eta "}, {"TRRT", "eta "}};
  const std::vector<std::pair<std::string, Lobes>> changes{
      {R"("eta": 1.5)", every_lobe},
      {R"("sigma_a": [0.1, 0.2, 0.3])", {}},
      {R"("tilt_deg": 5)", {}},
      {R"("longitudinal_lambda_deg": {"TT": 3})", {}},
      {R"("azimuthal_sigma_deg": {"TRT": 12})", {{"TRT", "blur_deg "}}},
      {R"("roughness": 0.25)", {{"TT", "blur_deg "}, {"TRT", "blur_deg "}, {"TRRT", "blur_deg "}}}};
  for (const auto& [change, lobes] : changes) {
    SCOPED_TRACE(change);
    write_scene(change, wide);
    EXPECT_EQ(missing("c", {"--model", "elliptical"}), lobes) << "and none of the other material";
  }
  const std::vector<std::pair<std::string, Lobes>> rough{
      {R"("sigma_a": [0.1, 0.2, 0.3])", {}},
      {R"("azimuthal_sigma_deg": {"TRT": 12})", {}},
      {R"("tilt_deg": 5)", {{"rough", "tilt_deg "}}},
      {R"("medulla": {"radius": 0.5, "scattering": 2})", {{"rough", "medulla medulla_scattering "}}}};
  for (const auto& [change, lobes] : rough) {
    SCOPED_TRACE(change);
    write_scene(change, wide);
    EXPECT_EQ(missing("c", {"--model", "rough"}), lobes);
  }
}

// A render of the changed scene leaves every row of the other material that had converged as it was, to the byte, and
// keeps those of the old parameter.
TEST_F(WarmStart, AChangedParameterLeavesTheRowsOfTheOthersAsTheyAre) {
  for (const std::string model : {"elliptical", "rough"}) {
    SCOPED_TRACE(model);
    write_scene("", wide);
    const std::string cache = model + ".cache", target = "elliptical-1";
    render(cache, {"--model", model, "--spp", "16"});
    const auto before = adaptive::load_cache(path(cache), "");
    ASSERT_TRUE(before);
    write_scene(R"("eccentricity": 0.9)", wide);
    render(cache, {"--model", model, "--spp", "16", "--telemetry", path("t.jsonl")});
    const auto after = adaptive::load_cache(path(cache), "");
    ASSERT_TRUE(after);
    std::map<adaptive::SliceKey, const adaptive::CachedSlice*> now;
    for (const adaptive::CachedSlice& slice : after->slices) now[slice.description.key] = &slice;
    const std::size_t lobes = model == "rough" ? 1 : 3;
    EXPECT_EQ(before->slices.size(), 2 * lobes);
    EXPECT_EQ(after->slices.size(), 3 * lobes);
    std::size_t compared = 0;
    for (const adaptive::CachedSlice& slice : before->slices) {
      ASSERT_TRUE(now.contains(slice.description.key));
      const adaptive::CachedSlice& later = *now[slice.description.key];
      for (const adaptive::CachedRow& row : slice.rows) {
        if (row.state != adaptive::RowState::converged) continue;
        const auto found = std::ranges::find(later.rows, row.node, &adaptive::CachedRow::node);
        ASSERT_NE(found, later.rows.end());
        // As the file has them: a row for a row.
        const auto alone = [&](const adaptive::CachedRow& one) {
          return encode_cache(adaptive::TableSnapshot{before->model, {{slice.description, {one}}}});
        };
        EXPECT_TRUE(alone(row) == alone(*found)) << "node " << row.node;
        ++compared;
      }
    }
    EXPECT_GT(compared, 10u);
    EXPECT_EQ(telemetry_lines(path("t.jsonl"), "pass").back().at("rows").at("reopened"), 0);
  }
}

}  // namespace
}  // namespace tress::test
