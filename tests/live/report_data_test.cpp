// A report of runs, from lines of telemetry that are written here.
#include "live/report_data.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "live/web_page.h"

namespace tress::live {
namespace {

class Report : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(file_); }
  const std::filesystem::path& written(const std::string& text) {
    std::ofstream(file_, std::ios::binary) << text;
    return file_;
  }
  std::filesystem::path file_ =
      std::filesystem::path(::testing::TempDir()) / ("tress_report_" + std::to_string(getpid()) + ".jsonl");
};

const std::string header = R"({"type":"header","schema":1,"epsilon":0.01,"model":"elliptical","scene":"a.json"})"
                           "\n";

std::string pass(int number, double share, int open) {
  return R"({"type":"pass","pass":)" + std::to_string(number) + R"(,"queries":100,"g_evaluations":50,)" +
         R"("converged_query_share":)" + std::to_string(share) + R"(,"cpu_seconds":2,"learning_cpu_seconds":0.5,)" +
         R"("rows":{"touched":9,"open":)" + std::to_string(open) + R"(,"converged":5,"reopened":0,"refused":1},)" +
         R"("objective":{"p50":0.001,"p90":0.002,"p99":0.003,"max":0.004},"bias_bound":0.02,"bytes":1000})" + "\n";
}

std::string row(int node, const std::string& state, double light) {
  return R"({"type":"row","page":{"lobe":1,"parameters":[1.5]},"node":)" + std::to_string(node) + R"(,"state":")" +
         state + R"(","objective":null,"failed_tests":2,"light":)" + std::to_string(light) +
         R"(,"fiber":{"eta":1.55,"lobe":"TT"},"angles":{"phi_r_deg":45},"command":"tress fit"})" + "\n";
}

TEST_F(Report, ListsWhatHasNotConvergedAndWhatLightItCarries) {
  const auto runs =
      report_data(written(header + row(1, "open", 0.1) + row(2, "open", 0.1) + row(3, "open", 0.3) + pass(0, 0.2, 3) +
                          row(1, "converged", 0.4) + row(3, "refused", 0.5) + pass(1, 0.94, 1)));
  ASSERT_TRUE(runs) << runs.error().message();
  ASSERT_EQ(runs->size(), 1u);
  const nlohmann::ordered_json& run = runs->front();
  EXPECT_EQ(run["verdict"]["good"], false);
  EXPECT_NE(run["verdict"]["text"].get<std::string>().find("94 % of the queries"), std::string::npos);
  const auto& left = run["left"]["rows"];
  ASSERT_EQ(left.size(), 2u);
  EXPECT_EQ(left[0]["state"], "refused") << "the row of most light first";
  EXPECT_NEAR(left[0]["share"].get<double>(), 0.5, 1e-12);
  EXPECT_NEAR(left[1]["share"].get<double>(), 0.1, 1e-12);
  EXPECT_EQ(left[0]["fiber"], "eta 1.55, TT");
  EXPECT_NEAR(run["cost"]["learning_share"].get<double>(), 0.25, 1e-12);
  EXPECT_EQ(run["cost"]["g_evaluations"], 100);
  EXPECT_TRUE(run["summary"].is_null()) << "it was killed";
}

TEST_F(Report, OfAWarmRunShowsWhatTheCacheBrought) {
  const auto runs = report_data(written(
      header + pass(0, 1, 0) +
      R"({"type":"summary","status":"done","warm_cache":{"loaded":"loaded","rows_known":7,"samples_known":80,"cpu_seconds_spared_estimate":1.5}})" +
      "\n" + header + pass(0, 0.5, 4)));
  ASSERT_TRUE(runs);
  ASSERT_EQ(runs->size(), 2u);
  EXPECT_EQ((*runs)[0]["verdict"]["good"], true);
  EXPECT_EQ((*runs)[0]["cache"]["rows_known"], 7);
  EXPECT_EQ((*runs)[0]["cache"]["cpu_seconds_spared"], 1.5);
  EXPECT_EQ((*runs)[1]["cache"]["loaded"], "none");
}

TEST_F(Report, ALastLineThatWasCutIsLeftOutAndOtherDamageIsNamed) {
  const auto cut = report_data(written(header + pass(0, 1, 0) + R"({"type":"pa)"));
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->front()["passes"].size(), 1u);
  EXPECT_FALSE(report_data(written("")));
  EXPECT_FALSE(report_data("/nowhere/run.jsonl"));
  EXPECT_FALSE(report_data(written("[1]\n")));
  EXPECT_FALSE(report_data(written(pass(0, 1, 0))));
  const auto damaged = report_data(written(header + "x\n" + pass(0, 1, 0)));
  ASSERT_FALSE(damaged);
  EXPECT_NE(damaged.error().message().find("line 2"), std::string::npos) << damaged.error().message();
}

TEST_F(Report, NumbersAndTextsOfOtherKindsAreNoHarm) {
  EXPECT_TRUE(report_data(written(R"({"type":"header","frame":{"a":1},"warm_cache":3})"
                                  "\n"
                                  R"({"type":"pass","queries":"many","rows":[1],"objective":null})"
                                  "\n"
                                  R"({"type":"row","page":null,"fiber":[1],"light":"x"})"
                                  "\n"
                                  R"({"type":"summary","warm_cache":[]})"
                                  "\n")));
}

TEST(WholePage, NeedsNoOtherFileAndNoTextEndsItsScript) {
  const std::string page = whole_page("report.html", nlohmann::ordered_json{{"scene", "</script><script>alert(1)"}});
  EXPECT_EQ(page.find("</script><script>alert"), std::string::npos);
  for (const char* part : {"{{style.css}}", "{{chart.js}}", "{{charts.js}}", "{{data}}", "{{report.js}}"})
    EXPECT_EQ(page.find(part), std::string::npos) << part;
  EXPECT_NE(page.find("Chart.js"), std::string::npos);
  for (const char* other : {" src=", "<link", "import("}) EXPECT_EQ(page.find(other), std::string::npos) << other;
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

}  // namespace
}  // namespace tress::live
