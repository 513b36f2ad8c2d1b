// Help, and what is said and returned when the command is used wrongly.
#include <gmock/gmock.h>

#include "cli/run_tress.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Usage : public CommandTest {
 protected:
  void expect_wrong(const std::vector<std::string>& arguments, const std::string& named) const {
    const Outcome outcome = run(arguments);
    std::string line;
    for (const std::string& argument : arguments) line += " " + argument;
    EXPECT_EQ(outcome.status, 2) << line << "\n" << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(named)) << line;
    EXPECT_THAT(outcome.out, IsEmpty()) << line;
  }
};

TEST_F(Usage, EveryCommandHasHelpOnStandardOutput) {
  const std::vector<std::vector<std::string>> commands{
      {}, {"render"}, {"fit"}, {"diff"}, {"cache"}, {"cache", "info"}, {"cache", "verify"}, {"cache", "merge"}};
  for (std::vector<std::string> command : commands) {
    command.push_back("--help");
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.out, HasSubstr("--help"));
    EXPECT_THAT(outcome.err, IsEmpty());
  }
  EXPECT_THAT(run({"render", "--help"}).out, HasSubstr("--warm-cache"));
}

TEST_F(Usage, AWrongOptionNamesTheNearest) {
  expect_wrong({"render", "a.json", "-o", "a.exr", "--thread", "2"}, "nearest: --threads");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--warmcache", "x"}, "nearest: --warm-cache");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--warmcache=x"}, "nearest: --warm-cache");
  expect_wrong({"fit", "--lobe", "TT", "--thetad", "3"}, "nearest: --theta-d");
  expect_wrong({"diff", "a.exr", "b.exr", "--jsn"}, "nearest: --json");
  expect_wrong({"rendr", "a.json"}, "nearest: render");
  expect_wrong({"cache", "inof", "a"}, "nearest: info");
}

TEST_F(Usage, AnOptionThatIsNotThereYetIsNotSilentlyAccepted) {
  expect_wrong({"render", "a.json", "-o", "a.exr", "--estimator", "stepwise"},
               "expected fitted|corrected|exact, found stepwise");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--learner", "skech"}, "nearest: sketch");
  expect_wrong({"fit", "--lobe", "GLNT"}, "expected TT|TRT|GLINT|TRRT|R, found GLNT");
}

TEST_F(Usage, ValuesOutOfRangeAreNamedWithTheRange) {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"--spp", "-1"},       {"--spp", "0"},         {"--spp", "4x"},         {"--epsilon", "0"},
      {"--epsilon", "nan"},  {"--epsilon", "-0.1"},  {"--resolution", "0x4"}, {"--resolution", "16385x4"},
      {"--threads", "0"},    {"--threads", "-2"},    {"--seed", "-1"},        {"--table-memory", "-1"},
      {"--color", "1,0,0"},  {"--color", ".5,.5"},   {"--melanin", "-1"},     {"--sigma-a", "1,2,inf"},
      {"--components", "0"}, {"--components", "9"},  {"--roughness", "0"},    {"--eccentricity", "2"},
      {"--up", "x"},         {"--cm-per-unit", "0"}, {"--max-depth", "0"},    {"--resolution", "64"},
      {"--time", "0"},       {"--noise", "-1"},      {"--noise", "2"},        {"--crop", "0,0,4"},
      {"--crop", "4,0,4,4"}, {"--crop", "-1,0,4,4"}, {"--crop", "0,0,1,1,"}};
  for (const auto& [option, value] : wrong) {
    expect_wrong({"render", "a.json", "-o", "a.exr", option, value}, option + ": expected ");
    expect_wrong({"render", "a.json", "-o", "a.exr", option, value}, "found " + value);
  }
  expect_wrong({"fit", "--lobe", "TT", "--sigma", ".1"}, "--sigma: expected ");
}

TEST_F(Usage, OptionsThatContradictEachOtherAreRefused) {
  expect_wrong({"render", "a.json", "-o", "a.exr", "--color", ".5,.5,.5", "--melanin", "1"}, "--melanin");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--spp", "4", "--time", "1"}, "--spp");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--noise", ".1", "--time", "1"}, "--noise");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--noise", ".1", "--spp", "4"}, "--spp");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--cache-mode", "frozen"}, "--warm-cache");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--rotate", "10"}, "--environment");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--model", "exact", "--estimator", "fitted"}, "--model exact");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--quadrature-points", "10"}, "--quadrature-points");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--model", "deon2011", "--quadrature-points", "0"}, "1 to 65536");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--telemetry", "a.exr"}, "different files");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--heatmap", "a.exr"}, "different files");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--heatmap", "heat.png"}, ".exr");
  expect_wrong({"render", "a.json", "-o", "a.png"}, ".exr");
  expect_wrong({"render", "a.json"}, "--output is required");
  expect_wrong({}, "render|fit|diff|cache");
  expect_wrong({"cache"}, "info|verify|merge|prebake");
  expect_wrong({"cache", "prebake", "a.json"}, "--output is required");
  expect_wrong({"cache", "prebake", "a.json", "-o", "a", "--learner", "sketchy"}, "nearest: sketch");
  expect_wrong({"cache", "prebake", "a.json", "-o", "a", "--telemetry", "a"}, "different files");
  expect_wrong({"cache", "prebake", "a.json", "-o", "a", "--model", "deon2011"}, "expected a model with rows");
  expect_wrong({"cache", "merge", "a", "b"}, "--output is required");
  expect_wrong({"cache", "merge", "-o", "a"}, "FILES is required");
}

TEST_F(Usage, WhatIsMissingOrBrokenIsExitOne) {
  const Outcome missing = run({"render", path("none.json"), "-o", path("a.exr")});
  EXPECT_EQ(missing.status, 1);
  EXPECT_THAT(missing.err, HasSubstr("none.json"));
  write_text(path("bad.hair"), "this is no hair file");
  const Outcome bad = run({"render", path("bad.hair"), "-o", path("a.exr")});
  EXPECT_EQ(bad.status, 1);
  EXPECT_THAT(bad.err, HasSubstr("bad.hair"));
  EXPECT_THAT(bad.err, HasSubstr("found"));
  EXPECT_FALSE(fs::exists(path("a.exr")));
  write_text(path("not.cache"), "no cache at all, but long enough to hold a header");
  const Outcome refused = run({"cache", "verify", path("not.cache")});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("not.cache"));
  EXPECT_EQ(run({"cache", "info", path("none.cache")}).status, 1);
  EXPECT_EQ(run({"diff", path("a.exr"), path("b.exr")}).status, 1);
}

}  // namespace
}  // namespace tress::test
