// tress-lab measure: the file that it reads, what it holds and what it writes.
#include <gmock/gmock.h>

#include <sstream>
#include <string>
#include <vector>

#include "cli/run_tress.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Measure : public CommandTest {
 protected:
  /// Values of no fiber, but light: the paths of these tests are few.
  static std::string rows() {
    std::string text;
    for (int phi = 0; phi < 180; phi += 20) text += std::to_string(phi) + " -30 " + std::to_string(200 - phi) + "\n";
    return text;
  }
  Outcome measure(const std::string& text, const std::vector<std::string>& options = {},
                  const std::string& paths = "512") const {
    write_text(path("hair.txt"), text);
    std::vector<std::string> words{"measure", path("hair.txt"), "--fit-paths", paths, "--detector", "20"};
    words.insert(words.end(), options.begin(), options.end());
    return run(words);
  }
};

TEST_F(Measure, AWrongFileNamesItsLine) {
  const std::vector<std::vector<std::string>> wrong{
      {"# incidence 40\n0 0\n", "line 2: expected three numbers: phi theta value, found 0 0"},
      {"# incidence 40\n\n0 0 x # note\n", "line 3: expected three numbers: phi theta value, found 0 0 x"},
      {"0 0 1\n0 0 inf\n", "line 2: expected three numbers"},
      {"0 91 1\n", "line 1: expected theta within -90..90 degrees, found 91"},
      {"361 0 1\n", "line 1: expected phi within -360..360 degrees, found 361"},
      {"# of a hair\n# incidence 90\n", "line 2: expected # incidence and -89.9..89.9 degrees, found incidence 90"},
      {"# detector x\n", "line 1: expected # detector and 0.1..30 degrees, found detector x"},
      {"# rotation 1 radian\n", "line 1: expected # rotation and -360..360 degrees, found rotation 1 radian"},
      {"# incidence 1\n#incidence 2\n", "line 2: expected one incidence, found a second one"},
      {rows(), "expected # incidence DEGREES, or the option --incidence, found neither"},
      {"# incidence 40 degrees\n# detector of the lab\n0 0 1\n", "expected 8 rows or more, found 1"},
      {"#incidence 40\n" + std::string("0 0 0\n0 0 -1\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n"),
       "expected a value above 0, found none"}};
  for (const std::vector<std::string>& one : wrong) {
    const Outcome outcome = measure(one[0]);
    EXPECT_EQ(outcome.status, 1) << one[0];
    EXPECT_THAT(outcome.err, HasSubstr("hair.txt: " + one[1])) << one[0];
    EXPECT_EQ(outcome.out, "") << one[0];
  }
  EXPECT_THAT(run({"measure", path("none.txt")}).err, HasSubstr("none.txt: expected a measurement"));
}

TEST_F(Measure, WhatIsFixedIsKept) {
  const Outcome outcome = measure(
      rows(), {"--incidence", "-40", "--rotation", "30", "--fix", "roughness=0.3,tilt=0", "--fix", "sigma_a=2"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("9 samples, incidence -40, rotation 30, detector 20 degrees"));
  EXPECT_THAT(outcome.out, HasSubstr("roughness           0.3 held\n"));
  EXPECT_THAT(outcome.out, HasSubstr("tilt                0 held\nsigma_a             2 held\n"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("medulla")));
  EXPECT_THAT(outcome.out, ::testing::ContainsRegex("eccentricity +[0-9.]+ \\+- "));
  const Outcome all = measure(rows(), {"--incidence", "40", "--medulla", "--fix",
                                       "eccentricity=1,roughness=0.3,tilt=0,sigma_a=2,medulla_scattering=3"});
  EXPECT_THAT(all.out, ::testing::ContainsRegex("medulla_radius +[0-9.]+ \\+- "));
  EXPECT_THAT(all.out, HasSubstr("medulla_scattering  3 held\n"));
}

TEST_F(Measure, WrongNumbersAreRefused) {
  for (const char* fixed : {"roughness", "rough=0.2", "roughness=2", "tilt=x"}) {
    const Outcome outcome = measure(rows(), {"--incidence", "40", "--fix", fixed});
    EXPECT_EQ(outcome.status, 2) << fixed;
    EXPECT_THAT(outcome.err, HasSubstr("--fix: expected ")) << fixed;
  }
}

TEST_F(Measure, WritesTheDifferenceOfEachSampleAndTheSameForAnyNumberOfThreads) {
  const auto with = [&](const std::string& file, const std::string& threads) {
    return measure(rows(), {"--incidence", "40", "--residuals", path(file), "--threads", threads}, "20000");
  };
  const Outcome one = with("a.tsv", "1"), three = with("b.tsv", "3");
  EXPECT_EQ(one.status, 0) << one.err;
  EXPECT_EQ(one.out, three.out);
  const std::string text = read_text(path("a.tsv"));
  EXPECT_EQ(text, read_text(path("b.tsv")));
  std::istringstream stream(text);
  std::string line;
  std::getline(stream, line);
  EXPECT_EQ(line, "phi\ttheta\tvalue\tfitted\tdifference");
  int samples = 0;
  double phi = 0, theta = 0, value = 0, fitted = 0, difference = 0;
  for (; stream >> phi >> theta >> value >> fitted >> difference; ++samples) {
    EXPECT_NEAR(phi, 20 * samples, 1e-5);
    EXPECT_NEAR(theta, -30, 1e-5);
    EXPECT_NEAR(value, 200 - 20 * samples, 1e-5);
    EXPECT_GT(fitted, 0);
    EXPECT_NEAR(value - fitted, difference, 1e-4);
  }
  EXPECT_EQ(samples, 9);
}

}  // namespace
}  // namespace tress::test
