// Help of the laboratory's commands, and what is said and returned when they are used wrongly.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "cli/run_tress.h"
#include "models/catalog.h"
#include "references/registry.h"
#include "scene/model/parameters.h"
#include "tress/adaptive/options.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class LaboratoryUsage : public CommandTest {
 protected:
  void expect_wrong(const std::vector<std::string>& arguments, const std::string& named) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments[0] << "\n" << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(named)) << arguments[0];
    EXPECT_THAT(outcome.out, IsEmpty()) << arguments[0];
  }
};

TEST_F(LaboratoryUsage, HasTheCommandsOfTressAndItsOwn) {
  for (const char* command : {"fit", "far-field", "lobes", "measure", "render", "cache"}) {
    const Outcome outcome = run({"help", command});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("tress-lab " + std::string(command)));
  }
}

/// The names that tress answers with the laboratory are those that only the laboratory has.
TEST_F(LaboratoryUsage, HasEveryModelAndLearnerThatTressNames) {
  const fiber::Catalog shipped = fiber::shipped_catalog();
  std::vector<std::string_view> models, learners;
  for (const fiber::ModelInfo& model : references::models()) {
    const auto same = [&](const fiber::ModelInfo& one) { return std::string_view(one.name) == model.name; };
    if (std::ranges::none_of(shipped.models, same)) models.push_back(model.name);
  }
  for (const adaptive::Learner* learner : references::learners())
    if (std::ranges::find(shipped.learners, learner) == shipped.learners.end()) learners.push_back(learner->name);
  EXPECT_THAT(models, ::testing::UnorderedElementsAreArray(fiber::laboratory_models()));
  EXPECT_THAT(learners, ::testing::UnorderedElementsAreArray(fiber::laboratory_learners()));
}

/// The default that the table of parameters states for an option of tress-lab fit is the one that it has.
TEST_F(LaboratoryUsage, FitHasTheDefaultsThatItStates) {
  const std::vector<std::string> plain{"fit", "--lobe", "TRT", "--json"};
  std::vector<std::string> spelt = plain;
  for (const char* name : {"--e", "--theta-d", "--phi", "--sigma", "--eta", "--epsilon", "--samples"}) {
    spelt.emplace_back(name);
    spelt.emplace_back(scene::option_parameter(name).usual);
  }
  EXPECT_EQ(run(plain).out, run(spelt).out);
}

TEST_F(LaboratoryUsage, FarFieldHasTheDefaultsThatItStates) {
  const std::vector<std::string> plain{"far-field", "--json"};
  std::vector<std::string> spelt = plain;
  for (const char* name :
       {"--e", "--alpha", "--tilt", "--eta", "--theta-r", "--phi-r", "--bins", "--paths", "--seed"}) {
    spelt.emplace_back(name);
    spelt.emplace_back(scene::option_parameter(name).usual);
  }
  for (const char* word : {"--model", "rough", "--sigma-a", "0", "--epsilon"}) spelt.emplace_back(word);
  spelt.push_back(fmt::format("{:g}", adaptive::Options{}.sampled_epsilon));
  EXPECT_EQ(run(plain).out, run(spelt).out);
}

TEST_F(LaboratoryUsage, AWrongOptionNamesTheNearest) {
  expect_wrong({"fit", "--lobe", "TT", "--thetad", "3"}, "nearest: --theta-d");
  expect_wrong({"far-field", "--thetar", "3"}, "nearest: --theta-r");
  expect_wrong({"fit", "--lobe", "GLNT"}, "expected TT|TRT|GLINT|TRT-REST|TRRT|R, found GLNT");
  expect_wrong({"far-field", "--model", "eliptical"}, "nearest: elliptical");
}

TEST_F(LaboratoryUsage, ValuesOutOfRangeAreNamedWithTheRange) {
  expect_wrong({"fit", "--lobe", "TT", "--sigma", ".1"}, "--sigma: expected ");
  const std::vector<std::pair<std::string, std::string>> wrong_of_fibers{
      {"--e", "0.4"},        {"--alpha", "0"},    {"--tilt", "16"},   {"--eta", "1"},     {"--theta-r", "90"},
      {"--phi-r", "361"},    {"--sigma-a", "-1"}, {"--bins", "36"},   {"--bins", "0x36"}, {"--bins", "36x721"},
      {"--bins", "36x36x1"}, {"--paths", "0"},    {"--epsilon", "0"}, {"--seed", "-1"},   {"--sigma-a", "0,0,0,0"}};
  for (const auto& [option, value] : wrong_of_fibers) {
    expect_wrong({"far-field", option, value}, option + ": expected ");
    expect_wrong({"far-field", option, value}, "found " + value);
  }
}

TEST_F(LaboratoryUsage, OptionsThatContradictEachOtherAreRefused) {
  expect_wrong({"far-field", "--sigma-a", "1,2"}, "expected 1 value or 3, found 2");
  expect_wrong({"far-field", "--model", "elliptical", "--lose-masked"}, "expected --model fiber3d");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--model", "deon2011", "--quadrature-points", "0"}, "1..65536");
  expect_wrong({"cache", "prebake", "a.json", "-o", "a", "--model", "deon2011"}, "expected a model with rows");
}

}  // namespace
}  // namespace tress::test
