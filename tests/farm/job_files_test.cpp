// What OpenJD and Flamenco are given: a template that keeps the rules of its schema, and a job type that node compiles.
#include "farm/job_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

namespace tress::farm {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return std::string((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
}

const fs::path here = fs::path(TRESS_SOURCE_DIR) / "tests" / "farm";

bool keeps_schema(const json& document) {
  using Adapter = valijson::adapters::NlohmannJsonAdapter;
  static const json rules = json::parse(text_of(here / "openjd_job_template.json"));
  valijson::Schema schema;
  valijson::SchemaParser(valijson::SchemaParser::kDraft7).populateSchema(Adapter(rules), schema);
  valijson::Validator validator(valijson::Validator::kStrongTypes);
  return validator.validate(schema, Adapter(document), nullptr);
}

/// What the schema cannot say: names are unique, dependencies are of other steps, variables are there.
std::string broken_rule(const json& document) {
  std::set<std::string> steps, variables;
  for (const json& parameter : document["parameterDefinitions"])
    if (!variables.insert("Param." + parameter["name"].get<std::string>()).second) return "two parameters of a name";
  for (const json& step : document["steps"])
    if (!steps.insert(step["name"]).second) return "two steps of a name";
  for (const json& step : document["steps"]) {
    std::set<std::string> known = variables;
    if (step.contains("parameterSpace"))
      for (const json& parameter : step["parameterSpace"]["taskParameterDefinitions"])
        known.insert("Task.Param." + parameter["name"].get<std::string>());
    for (const json& before : step.value("dependencies", json::array()))
      if (before["dependsOn"] == step["name"] || !steps.contains(before["dependsOn"])) return "a dependency on no step";
    std::string text = step["script"].dump();
    for (std::size_t at = 0; (at = text.find("{{", at)) != std::string::npos; ++at) {
      const std::string name = text.substr(at + 2, text.find("}}", at) - at - 2);
      if (!known.contains(name)) return "no value " + name;
    }
  }
  return "";
}

Plan plan_of(int frames, bool calibrates) {
  Plan plan;
  plan.program = "/opt/tress/bin/tress";
  plan.scene = "/shot/scene.json";
  plan.output = "/shot/####.exr";
  plan.frames.resize(std::size_t(frames));
  std::iota(plan.frames.begin(), plan.frames.end(), 1);
  plan.calibrates = calibrates;
  return plan;
}

TEST(FarmOpenJd, TheTemplateKeepsTheRulesOfItsSchema) {
  for (const int frames : {1, 2, 3, 240}) {
    for (const bool calibrates : {false, true}) {
      const json document = json::parse(openjd_template(plan_of(frames, calibrates), "/shot/a farm", "shot\n1"));
      EXPECT_TRUE(keeps_schema(document)) << document.dump(1);
      EXPECT_EQ(broken_rule(document), "");
      EXPECT_EQ(document["steps"].size(), calibrates && frames > 1 ? 3u : 2u);
      EXPECT_EQ(document["steps"].back()["dependencies"][0]["dependsOn"], "Render");
    }
  }
  const json document = json::parse(openjd_template(plan_of(240, true), "/farm", "shot"));
  EXPECT_EQ(document["steps"][1]["parameterSpace"]["taskParameterDefinitions"][0]["range"], "1-239");
}

// The check itself: what is not in the specification is refused.
TEST(FarmOpenJd, AnotherTemplateBreaksThem) {
  const json good = json::parse(openjd_template(plan_of(3, true), "/farm", "shot"));
  const std::vector<std::function<void(json&)>> faults{
      [](json& d) { d["specificationVersion"] = "jobtemplate-2024"; },
      [](json& d) { d.erase("steps"); },
      [](json& d) { d["steps"][0].erase("script"); },
      [](json& d) { d["more"] = 1; },
      [](json& d) { d["name"] = std::string(129, 'a'); },
      [](json& d) { d["name"] = ""; },
      [](json& d) { d["parameterDefinitions"][0]["name"] = "a b"; },
      [](json& d) { d["parameterDefinitions"][1]["dataFlow"] = "BOTH"; },
      [](json& d) { d["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["range"] = "1 to 3"; },
      [](json& d) { d["steps"][0]["script"]["actions"]["onRun"]["cancelation"]["notifyPeriodInSeconds"] = 601; },
      [](json& d) { d["steps"][0]["script"]["actions"]["onRun"]["args"] = "farm"; }};
  for (const auto& break_it : faults) {
    json bad = good;
    break_it(bad);
    EXPECT_FALSE(keeps_schema(bad)) << bad.dump(1);
  }
  json cyclic = good;
  cyclic["steps"][0]["dependencies"] = json::array({{{"dependsOn", "Calibrate"}}});
  EXPECT_NE(broken_rule(cyclic), "");
}

/// What node makes of a job; null where it has failed.
json compiled(const Plan& plan, const std::string& name) {
  const fs::path folder = fs::path(::testing::TempDir()) / ("tress_flamenco_" + name + std::to_string(getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "tress.js") << flamenco_job_type();
  std::ofstream(folder / "job.json") << flamenco_job(plan, "/shot/a farm", "shot");
  const std::string command = "node '" + (here / "flamenco_check.js").string() + "' '" +
                              (folder / "tress.js").string() + "' '" + (folder / "job.json").string() + "' > '" +
                              (folder / "out").string() + "'";
  const int status = std::system(command.c_str());
  const json result = status == 0 ? json::parse(text_of(folder / "out"), nullptr, false) : json();
  fs::remove_all(folder);
  return result;
}

TEST(FarmFlamenco, TheJobTypeMakesATaskForEachAndAMergeAfterAll) {
  const json job = compiled(plan_of(3, false), "all");
  ASSERT_TRUE(job.is_object()) << "node must be there (bootstrap installs nodejs)";
  ASSERT_EQ(job["tasks"].size(), 4u);
  const json expected{"farm", "run", "/shot/a farm", "--task", "2"};
  EXPECT_EQ(job["tasks"][2]["commands"][0]["name"], "exec");
  EXPECT_EQ(job["tasks"][2]["commands"][0]["parameters"]["exe"], "/opt/tress/bin/tress");
  EXPECT_EQ(job["tasks"][2]["commands"][0]["parameters"]["args"], expected);
  EXPECT_EQ(job["tasks"][2]["after"], json::array());
  EXPECT_EQ(job["tasks"][3]["name"], "merge");
  EXPECT_EQ(job["tasks"][3]["after"], (json{"render-0", "render-1", "render-2"}));
}

TEST(FarmFlamenco, TasksWaitForTheOneThatCalibrates) {
  const json job = compiled(plan_of(3, true), "first");
  ASSERT_TRUE(job.is_object());
  EXPECT_EQ(job["tasks"][0]["after"], json::array());
  for (const std::size_t task : {1u, 2u}) EXPECT_EQ(job["tasks"][task]["after"], json{"render-0"});
}

// What is submitted: what the Manager's API requires of a job.
TEST(FarmFlamenco, TheJobHasWhatItsApiRequires) {
  const json job = json::parse(flamenco_job(plan_of(3, false), "/farm", "shot"));
  EXPECT_EQ(job["type"], "tress") << "the name of the file in scripts/";
  EXPECT_TRUE(job["name"].is_string() && job["priority"].is_number_integer() && job["submitter_platform"] == "linux");
}

}  // namespace
}  // namespace tress::farm
