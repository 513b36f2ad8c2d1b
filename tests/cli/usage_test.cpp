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
#include "models/catalog.h"
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
                                                     {"cache", "prune"},
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

TEST_F(Usage, VersionPrintsTheCommitTheFormatsAndTheLibraries) {
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

/// The long and short options that --help lists of a command.
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
    const std::string printed = run(help).out;
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
    for (const std::string& option : options_in(printed)) {
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

TEST_F(Usage, EpsilonOfRowsOfSamplesIsTheLibrarys) {
  const std::string expected =
      fmt::format("chi-square, and {:g} without the option", adaptive::Options{}.sampled_epsilon);
  EXPECT_THAT(std::string(scene::option_parameter("--epsilon").sentence), HasSubstr(expected));
}

TEST_F(Usage, AWrongOptionNamesTheNearest) {
  expect_wrong({"render", "a.json", "-o", "a.exr", "--thread", "2"}, "nearest: --threads");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--warmcache", "x"}, "nearest: --warm-cache");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--warmcache=x"}, "nearest: --warm-cache");
  expect_wrong({"diff", "a.exr", "b.exr", "--jsn"}, "nearest: --json");
  expect_wrong({"rendr", "a.json"}, "nearest: render");
  expect_wrong({"cache", "inof", "a"}, "nearest: info");
}

TEST_F(Usage, AnOptionThatIsNotThereYetIsNotSilentlyAccepted) {
  expect_wrong({"render", "a.json", "-o", "a.exr", "--estimator", "stepwise"},
               "expected fitted|corrected|exact, found stepwise");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--learner", "skech"}, "nearest: sketch");
}

TEST_F(Usage, WhatIsInTheLaboratoryIsAnsweredWithItsProgram) {
  for (const char* command : {"fit", "far-field", "lobes", "measure"})
    expect_wrong({command, "--json"}, "tress " + std::string(command) + ": this command is in tress-lab (");
  for (const std::string_view model : fiber::laboratory_models())
    expect_wrong({"render", "a.json", "-o", "a.exr", "--model", std::string(model)},
                 "found " + std::string(model) + ", which is in tress-lab (");
  for (const std::string_view learner : fiber::laboratory_learners())
    expect_wrong({"cache", "prebake", "a.json", "-o", "a", "--learner", std::string(learner)},
                 "found " + std::string(learner) + ", which is in tress-lab (");
}

TEST_F(Usage, LayersAreNamedOrTheNearestIsNamed) {
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
}

TEST_F(Usage, OptionsThatSetReplacesNameTheirKeys) {
  const Outcome help = run({"help", "render"});
  const auto expect_named = [&](const std::vector<std::string>& given, const std::string& key) {
    std::vector<std::string> words{"render", path("none.json"), "-o", path("a.exr")};
    words.insert(words.end(), given.begin(), given.end());
    EXPECT_THAT(run(words).err, HasSubstr(given[0] + " works until version 0.4: write --set '" + key + "'"));
    EXPECT_THAT(help.out, Not(HasSubstr(given[0] + " ")));
  };
  expect_named({"--max-depth", "8"}, "integrator/max_depth=8");
  expect_named({"--near", "touching"}, "integrator/near=touching");
  expect_named({"--near", "1.50"}, "integrator/near=1.5");
  expect_named({"--transparent"}, "image/transparent=true");
  expect_named({"--adaptive", "off"}, "integrator/adaptive=false");
  expect_named({"--rotate", "30"}, "environment/rotate_deg=30");
  expect_named({"--view", "agx"}, "image/view=agx");
  expect_named({"--shutter", "0,.5"}, R"(camera/shutter={"open":0,"close":0.5})");
  expect_named({"--roughness", "0.3"}, "materials/*/roughness=0.3");
  expect_named({"--widths", "clamp"}, "grooms/*/widths=clamp");
  EXPECT_THAT(help.out, HasSubstr("--set "));
}

TEST_F(Usage, OptionsThatContradictEachOtherAreRefused) {
  expect_wrong({"render", "a.json", "-o", "a.exr", "--color", ".5,.5,.5", "--melanin", "1"}, "--melanin");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--spp", "4", "--time", "1"}, "--spp");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--noise", ".1", "--time", "1"}, "--noise");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--noise", ".1", "--spp", "4"}, "--spp");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--cache-mode", "frozen"}, "--warm-cache");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--model", "exact", "--estimator", "fitted"}, "--model exact");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--quadrature-points", "10"}, "--quadrature-points");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--quadrature-points", "0"}, "1..65536");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--telemetry", "a.exr"}, "different files");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--heatmap", "a.exr"}, "different files");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--heatmap", "heat.png"}, ".exr");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--deep", "a.exr"}, "different files");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--deep", "deep.png"}, ".exr");
  expect_wrong({"render", "a.json", "-o", "a.exr", "--deep", "b.exr", "--part", "a.part"},
               "--deep: expected no --part");
  expect_wrong({"render", "a.json", "-o", "a.####.exr", "--frames", "1-2", "--deep", "b.exr"},
               "--deep: expected a name");
  expect_wrong({"render", "a.json", "-o", "a.png"}, ".exr");
  expect_wrong({"denoise", "a.exr", "-o", "a.png"}, ".exr");
  expect_wrong({"render", "a.json"}, "--output is required");
  expect_wrong({}, "render|diff|info|convert|denoise|merge|report|farm|cache|help");
  expect_wrong({}, "Render a scene");
  expect_wrong({"cache"}, "info|verify|merge|prebake|prune");
  expect_wrong({"cache", "prebake", "a.json"}, "--output is required");
  expect_wrong({"cache", "prebake", "a.json", "-o", "a", "--learner", "sketchy"}, "nearest: sketch");
  expect_wrong({"cache", "prebake", "a.json", "-o", "a", "--telemetry", "a"}, "different files");
  expect_wrong({"cache", "prebake", "a.json", "-o", "a", "--model", "chiang2016"}, "expected a model with rows");
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
