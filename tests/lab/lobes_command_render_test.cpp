// tress-lab lobes: its page has the numbers of tress-lab far-field and tress-lab fit.
#include <gmock/gmock.h>

#include "cli/run_tress.h"
#include "references/registry.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;

class Lobes : public CommandTest {
 protected:
  /// What the page at `file` has been given.
  static nlohmann::json data_of(const std::string& file) {
    const std::string page = read_text(file), before = "<script>const lobes = ", after = ";</script>";
    const std::size_t begin = page.find(before);
    EXPECT_NE(begin, std::string::npos);
    if (begin == std::string::npos) return nlohmann::json::object();
    const std::size_t from = begin + before.size();
    const nlohmann::json json = nlohmann::json::parse(page.substr(from, page.find(after, from) - from), nullptr, false);
    EXPECT_FALSE(json.is_discarded());
    return json.is_discarded() ? nlohmann::json::object() : json;
  }
};

const std::vector<std::string> fiber_words{
    "--e",    "0.7", "--alpha", "0.25", "--theta-r", "40",   "--phi-r", "-20", "--eta",     "1.5",
    "--tilt", "2",   "--bins",  "9x12", "--paths",   "4000", "--seed",  "3",   "--sigma-a", "0.1,0.2,0.4"};

TEST_F(Lobes, EveryModelHasTheFarFieldThatFarFieldPrints) {
  std::vector<std::string> words{"lobes", "-o", path("a.html"), "--quiet"};
  words.insert(words.end(), fiber_words.begin(), fiber_words.end());
  const Outcome outcome = run(words);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json page = data_of(path("a.html"));
  const nlohmann::json& fields = page.at("far_fields");
  ASSERT_EQ(fields.size(), references::models().size());
  EXPECT_EQ(fields[0].at("model"), "fiber3d") << "the truth first";
  for (const nlohmann::json& field : fields) {
    std::vector<std::string> alone{"far-field", "--json", "--quiet", "--model", field.at("model").get<std::string>()};
    alone.insert(alone.end(), fiber_words.begin(), fiber_words.end());
    EXPECT_EQ(field, run_json(alone)) << alone[4];
  }
}

TEST_F(Lobes, RowsAreThoseOfFitOnTheSpecularCone) {
  ASSERT_EQ(
      run({"lobes", "-o",  path("a.html"), "--quiet", "--models",  "elliptical", "--paths", "100", "--bins",    "4x4",
           "--e",   "0.7", "--alpha",      "0.2",     "--theta-r", "-40",        "--phi-r", "110", "--sigma-a", "0.3"})
          .status,
      0);
  const nlohmann::json page = data_of(path("a.html"));
  EXPECT_EQ(page.at("far_fields").size(), 1u);
  const nlohmann::json& rows = page.at("rows");
  ASSERT_EQ(rows.size(), 5u);
  for (nlohmann::json row : rows) {
    const nlohmann::json& p = row.at("parameters");
    EXPECT_EQ(p.at("theta_d_deg"), -40.0);
    EXPECT_EQ(row.at("channel"), "grey");
    row.erase("channel");
    const std::string sigma = nlohmann::json(p.at("sigma_deg")).dump();
    EXPECT_EQ(row, run_json({"fit", "--json", "--lobe", row.at("lobe").get<std::string>(), "--e", "0.7", "--theta-d",
                             "-40", "--phi", "110", "--sigma", sigma, "--sigma-a", "0.3"}))
        << row.at("lobe");
  }
  // Half the roughness of 0.2 in degrees: the width of TT.
  EXPECT_NEAR(rows[0].at("parameters").at("sigma_deg").get<double>(), 5.72958, 1e-4);
}

TEST_F(Lobes, ThePartsOfAFitAddUpToIt) {
  const nlohmann::json row =
      run_json({"fit", "--json", "--lobe", "TRT", "--e", "0.7", "--phi", "20", "--sigma-a", "0.5"});
  const auto fit = row.at("fit").get<std::vector<double>>();
  const auto parts = row.at("parts").get<std::vector<std::vector<double>>>();
  ASSERT_EQ(parts.size(), row.at("components").get<std::size_t>() + 1);
  for (std::size_t i = 0; i < fit.size(); ++i) {
    double sum = 0;
    for (const std::vector<double>& part : parts) sum += part.at(i);
    EXPECT_NEAR(sum, fit[i], 1e-12 * (1 + fit[i]));
  }
}

TEST_F(Lobes, FitWritesItsRowAsAPageToo) {
  ASSERT_EQ(run({"fit", "--lobe", "GLINT", "-o", path("a.HTML")}).status, 0);
  const nlohmann::json page = data_of(path("a.HTML"));
  EXPECT_EQ(page.at("far_fields").size(), 0u);
  ASSERT_EQ(page.at("rows").size(), 1u);
  EXPECT_EQ(page["rows"][0], run_json({"fit", "--lobe", "GLINT", "--json"}));
}

TEST_F(Lobes, ThePageAsksNobody) {
  ASSERT_EQ(run({"fit", "--lobe", "TT", "-o", path("a.html")}).status, 0);
  const std::string page = read_text(path("a.html"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  for (const char* part : {"<script src", "<link rel=\"stylesheet", "{{"})
    EXPECT_EQ(page.find(part), std::string::npos);
}

TEST_F(Lobes, WrongValuesAreRefusedByName) {
  const auto expect_wrong = [&](std::vector<std::string> words, const char* named) {
    words.insert(words.begin(), "lobes");
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, 2) << named;
    EXPECT_THAT(outcome.err, HasSubstr(named));
  };
  expect_wrong({"-o", path("a.html"), "--models", "rough,marschner"}, "--models: expected one of");
  expect_wrong({"-o", path("a.png")}, ".html");
  expect_wrong({"-o", path("a.html"), "--sigma-a", "1,2"}, "--sigma-a: expected 1 value or 3");
  expect_wrong({"-o", path("a.html"), "--e", "nan"}, "--e");
  expect_wrong({}, "--output");
  EXPECT_EQ(run({"lobes", "-o", path("nowhere/a.html"), "--paths", "100", "--bins", "4x4"}).status, 1);
}

}  // namespace
}  // namespace tress::test
