// Help, and what is said and returned when the command is used wrongly.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cli/run_tress.h"
#include "scene/model/parameters.h"
#include "tress/adaptive/options.h"
#include "tress/version.h"

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

const std::vector<std::vector<std::string>> commands{{},
                                                     {"render"},
                                                     {"fit"},
                                                     {"far-field"},
                                                     {"lobes"},
                                                     {"diff"},
                                                     {"info"},
                                                     {"convert"},
                                                     {"denoise"},
                                                     {"merge"},
                                                     {"report"},
                                                     {"farm"},
                                                     {"farm", "run"},
                                                     {"farm", "merge"},
                                                     {"farm", "status"},
                                                     {"cache"},
                                                     {"cache", "info"},
                                                     {"cache", "verify"},
                                                     {"cache", "merge"},
                                                     {"cache", "prebake"}};

TEST_F(Usage, EveryCommandHasHelpOnStandardOutput) {
  for (std::vector<std::string> command : commands) {
    command.push_back("--help");
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.out, HasSubstr("--help"));
    EXPECT_THAT(outcome.err, IsEmpty());
  }
  EXPECT_THAT(run({"render", "--help"}).out, HasSubstr("--warm-cache"));
}

TEST_F(Usage, HelpIsACommandToo) {
  for (const std::vector<std::string>& command : commands) {
    std::vector<std::string> word{"help"}, option = command;
    word.insert(word.end(), command.begin(), command.end());
    option.push_back("--help");
    const Outcome outcome = run(word);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, IsEmpty());
    EXPECT_THAT(outcome.out, HasSubstr("--help"));
    if (command.size() == 1) {
      EXPECT_THAT(outcome.out, HasSubstr("tress " + command[0]));
    }
    EXPECT_EQ(run(option).status, 0);
  }
  EXPECT_THAT(run({"cache", "help", "merge"}).out, HasSubstr("--output"));
  expect_wrong({"help", "rendr"}, "nearest: render");
  expect_wrong({"help", "render", "more"}, "has no commands");
}

TEST_F(Usage, VersionTellsTheCommitTheFormatsAndTheLibraries) {
  const Outcome outcome = run({"--version"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_TRUE(outcome.out.starts_with(std::string("tress ") + version())) << outcome.out;
  for (const char* part : {"warm caches of format", "Embree", "OpenEXR", "oneTBB", "CLI11"}) {
    EXPECT_THAT(outcome.out, HasSubstr(part));
  }
  const std::string git =
      "git -C '" TRESS_SOURCE_DIR "' describe --always > /dev/null 2>&1";  // which a build need not have
  if (std::system(git.c_str()) == 0) {
    EXPECT_THAT(outcome.out, HasSubstr("(commit "));
  }
}

/// The long and short options that --help tells of a command.
std::set<std::string> options_in(const std::string& help) {
  std::set<std::string> options;
  const std::regex head(R"(^  (-[^ ]*))");
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (!std::regex_search(line, match, head)) continue;
    std::istringstream names(match[1]);
    for (std::string name; std::getline(names, name, ',');) options.insert(name);
  }
  return options;
}

TEST_F(Usage, EveryOptionIsInTheManualAndInTheCompletions) {
  const std::string bash = run({"help", "--completion", "bash"}).out, zsh = run({"help", "--completion", "zsh"}).out;
  write_text(path("bash"), bash);
  int options = 0;
  for (const std::vector<std::string>& command : commands) {
    if (command.empty()) continue;
    std::vector<std::string> help{"help"}, asked{"help"};
    for (const std::string& word : command) help.push_back(word);
    const std::string told = run(help).out;
    asked.push_back(command[0]);
    asked.emplace_back("--man");
    const std::string page = run(asked).out;
    EXPECT_TRUE(page.starts_with(".TH \"TRESS")) << page.substr(0, 40);
    EXPECT_THAT(page, HasSubstr(".SH EXIT STATUS"));
    std::string words = "tress", name = "_tress";
    for (const std::string& word : command) {
      words += " " + word;
      name += "_" + word;
    }
    // What bash offers after "tress COMMAND -".
    const std::string ask = "source " + path("bash") + "; COMP_WORDS=(" + words +
                            " -); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _tress; printf '%s\\n' \"${COMPREPLY[@]}\"";
    const std::string offered = Process(folder_, {"-c", ask}, "/bin/bash").wait().out;
    const std::size_t begin = zsh.find("\n" + name + "() {"), end = zsh.find("\n}\n", begin);
    ASSERT_NE(begin, std::string::npos) << name;
    for (const std::string& option : options_in(told)) {
      ++options;
      std::string typed;
      for (const char c : option) typed += c == '-' ? "\\-" : std::string(1, c);
      EXPECT_THAT(page, HasSubstr("\\fB" + typed + "\\fR")) << words;
      EXPECT_THAT("\n" + offered, HasSubstr("\n" + option + "\n")) << words;
      EXPECT_THAT(zsh.substr(begin, end - begin), HasSubstr("'" + option + "[")) << words;
    }
  }
  EXPECT_GT(options, 70) << "hardly anything was checked";
}

TEST_F(Usage, CompletionOffersTheWordsOfAnOption) {
  write_text(path("bash"), run({"help", "--completion", "bash"}).out);
  const std::string ask =
      "source " + path("bash") +
      "; COMP_WORDS=(tress render a.json --cache-mode fr); COMP_CWORD=4; _tress; echo ${COMPREPLY[@]}";
  EXPECT_EQ(Process(folder_, {"-c", ask}, "/bin/bash").wait().out, "frozen\n");
}

/// The default that the table of parameters tells of an option of tress fit is the one that it has.
TEST_F(Usage, FitHasTheDefaultsThatItTells) {
  const std::vector<std::string> plain{"fit", "--lobe", "TRT", "--json"};
  std::vector<std::string> spelt = plain;
  for (const char* name : {"--e", "--theta-d", "--phi", "--sigma", "--eta", "--epsilon", "--samples"}) {
    spelt.emplace_back(name);
    spelt.emplace_back(scene::option_parameter(name).usual);
  }
  EXPECT_EQ(run(plain).out, run(spelt).out);
}

TEST_F(Usage, FarFieldHasTheDefaultsThatItTells) {
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

TEST_F(Usage, EpsilonOfRowsOfSamplesIsTheLibrarys) {
  const std::string told = fmt::format("chi-square, and {:g} without the option", adaptive::Options{}.sampled_epsilon);
  EXPECT_THAT(std::string(scene::option_parameter("--epsilon").sentence), HasSubstr(told));
}

TEST_F(Usage, AWrongOptionNamesTheNearest) {
  expect_wrong({"render", "a.json", "-o", "a.exr", "--thread", "2"}, "nearest: --threads");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--warmcache", "x"}, "nearest: --warm-cache");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--warmcache=x"}, "nearest: --warm-cache");
  expect_wrong({"fit", "--lobe", "TT", "--thetad", "3"}, "nearest: --theta-d");
  expect_wrong({"far-field", "--thetar", "3"}, "nearest: --theta-r");
  expect_wrong({"diff", "a.exr", "b.exr", "--jsn"}, "nearest: --json");
  expect_wrong({"rendr", "a.json"}, "nearest: render");
  expect_wrong({"cache", "inof", "a"}, "nearest: info");
}

TEST_F(Usage, AnOptionThatIsNotThereYetIsNotSilentlyAccepted) {
  expect_wrong({"render", "a.json", "-o", "a.exr", "--estimator", "stepwise"},
               "expected fitted|corrected|exact, found stepwise");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--learner", "skech"}, "nearest: sketch");
  expect_wrong({"fit", "--lobe", "GLNT"}, "expected TT|TRT|GLINT|TRT-REST|TRRT|R, found GLNT");
  expect_wrong({"far-field", "--model", "eliptical"}, "nearest: elliptical");
}

TEST_F(Usage, LayersAreNamedOrTheNearestIsTold) {
  expect_wrong({"render", "a.json", "-o", "a.exr", "--layers", "albedo,tangents"}, "found tangents (nearest: tangent)");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--layers", "albedo,"}, "--layers: expected all, beauty or layers");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--layers", "all,halves"}, "found halves (nearest: half)");
}

TEST_F(Usage, ValuesOutOfRangeAreNamedWithTheRange) {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"--spp", "-1"},        {"--spp", "0"},        {"--spp", "4x"},         {"--epsilon", "0"},
      {"--epsilon", "nan"},   {"--epsilon", "-0.1"}, {"--resolution", "0x4"}, {"--resolution", "65537x4"},
      {"--threads", "0"},     {"--threads", "-2"},   {"--seed", "-1"},        {"--table-memory", "-1"},
      {"--color", "1,0,0"},   {"--color", ".5,.5"},  {"--melanin", "-1"},     {"--sigma-a", "1,2,inf"},
      {"--components", "0"},  {"--components", "9"}, {"--roughness", "0"},    {"--eccentricity", "2"},
      {"--up", "x"},          {"--turn", "361"},     {"--cm-per-unit", "0"},  {"--max-depth", "0"},
      {"--resolution", "64"}, {"--time", "0"},       {"--noise", "-1"},       {"--noise", "2"},
      {"--crop", "0,0,4"},    {"--crop", "4,0,4,4"}, {"--crop", "-1,0,4,4"},  {"--crop", "0,0,1,1,"},
      {"--exposure", "21"},   {"--precision", "16"}, {"--view", "filmic"}};
  for (const auto& [option, value] : wrong) {
    expect_wrong({"render", "a.json", "-o", "a.exr", option, value}, option + ": expected ");
    expect_wrong({"render", "a.json", "-o", "a.exr", option, value}, "found " + value);
  }
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

TEST_F(Usage, OptionsThatContradictEachOtherAreRefused) {
  expect_wrong({"render", "a.json", "-o", "a.exr", "--color", ".5,.5,.5", "--melanin", "1"}, "--melanin");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--spp", "4", "--time", "1"}, "--spp");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--noise", ".1", "--time", "1"}, "--noise");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--noise", ".1", "--spp", "4"}, "--spp");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--cache-mode", "frozen"}, "--warm-cache");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--rotate", "10"}, "--environment");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--model", "exact", "--estimator", "fitted"}, "--model exact");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--quadrature-points", "10"}, "--quadrature-points");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--model", "deon2011", "--quadrature-points", "0"}, "1..65536");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--telemetry", "a.exr"}, "different files");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--heatmap", "a.exr"}, "different files");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--heatmap", "heat.png"}, ".exr");
  expect_wrong({"render", "a.json", "-o", "a.png"}, ".exr");
  expect_wrong({"denoise", "a.exr", "-o", "a.png"}, ".exr");
  expect_wrong({"far-field", "--sigma-a", "1,2"}, "expected 1 value or 3, found 2");
  expect_wrong({"far-field", "--model", "elliptical", "--lose-masked"}, "expected --model fiber3d");
  expect_wrong({"render", "a.json"}, "--output is required");
  expect_wrong({}, "render|fit|far-field|lobes|diff|info|convert|denoise|merge|report|farm|cache|help");
  expect_wrong({}, "Render a scene");
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
  EXPECT_EQ(run({"denoise", path("a.exr"), "-o", path("b.exr")}).status, 1);
}

}  // namespace
}  // namespace tress::test
