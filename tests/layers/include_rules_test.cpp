// Who may include what. The layers of README.md, checked on the text of every file.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Include {
  std::string path;  // relative to the project
  int line;
  std::string name;
};

std::vector<Include> includes_under(const std::string& folder) {
  std::vector<Include> found;
  const fs::path root(TRESS_SOURCE_DIR);
  const std::regex pattern(R"rx(^\s*#\s*include\s*[<"]([^>"]+)[>"])rx");
  for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".h" && extension != ".cpp") continue;
    std::ifstream stream(entry.path());
    std::string text;
    for (int line = 1; std::getline(stream, text); ++line) {
      std::smatch match;
      if (std::regex_search(text, match, pattern)) {
        found.push_back({fs::relative(entry.path(), root).string(), line, match[1]});
      }
    }
  }
  return found;
}

bool starts_with_any(const std::string& text, const std::vector<std::string>& prefixes) {
  for (const std::string& prefix : prefixes) {
    if (text.starts_with(prefix)) return true;
  }
  return false;
}

void expect_none(const std::string& folder, const std::function<bool(const Include&)>& forbidden) {
  const std::vector<Include> all = includes_under(folder);
  EXPECT_FALSE(all.empty()) << folder << ": nothing was read, so nothing was checked";
  for (const Include& include : all) {
    EXPECT_FALSE(forbidden(include)) << include.path << ":" << include.line << " includes " << include.name;
  }
}

bool is_standard(const std::string& name) {
  return name.find('/') == std::string::npos && name.find('.') == std::string::npos;
}

/// Every folder that has code, from the lowest to the highest. A file includes its own folder and lower ones; what a
/// folder may not include although it is lower stands in `apart`.
const std::vector<std::string> folders_upwards{"include/tress",
                                               "include/tress/base",
                                               "include/tress/adaptive",
                                               "include/tress/fiber",
                                               "src/base",
                                               "adaptive/density",
                                               "adaptive/observations",
                                               "adaptive/convergence",
                                               "adaptive/fit",
                                               "adaptive/cache",
                                               "adaptive/telemetry",
                                               "adaptive/table",
                                               "src/fiber",
                                               "src/models/lobes",
                                               "src/models/elliptical",
                                               "src/models/rough",
                                               "src/models",
                                               "src/capi",
                                               "src/image",
                                               "src/denoise",
                                               "src/scene/model",
                                               "src/scene/generate",
                                               "src/scene/read/grooms",
                                               "src/scene/read",
                                               "src/geometry",
                                               "src/integrate",
                                               "src/live",
                                               "src/farm",
                                               "src/cli",
                                               "src/cli/farm",
                                               "src/python",
                                               "src",
                                               "bench/references/models",
                                               "bench/references/learners",
                                               "bench/references",
                                               "bench/lab"};

struct Apart {
  std::string folder;  // and all below it
  std::vector<std::string> may_not_include;
};
const std::vector<Apart> apart{
    {"include/tress/adaptive", {"include/tress/fiber"}},
    {"src/base", {"include/tress/adaptive", "include/tress/fiber"}},
    {"adaptive", {"include/tress/fiber"}},
    {"src/fiber", {"adaptive"}},
    {"src/models", {"adaptive"}},
    {"src/models/rough", {"src/models/elliptical"}},
    {"src/capi", {"adaptive", "src/base", "src/fiber", "src/models"}},
    {"bench/references/models", {"adaptive"}},
    {"bench/references", {"src/scene", "src/geometry", "src/integrate", "src/image", "src/live", "src/cli"}},
    {"bench/lab", {"adaptive"}},
    {"src/image", {"adaptive", "include/tress/fiber", "src/fiber", "src/models"}},
    {"src/denoise", {"adaptive", "include/tress/adaptive", "include/tress/fiber", "src/fiber", "src/models"}},
    {"src/scene", {"adaptive", "src/models"}},
    {"src/geometry", {"adaptive", "src/models"}},
    {"src/integrate", {"adaptive", "src/models"}},
    {"src/live", {"adaptive", "src/models"}},
    {"src/farm",
     {"adaptive", "include/tress/adaptive", "include/tress/fiber", "src/fiber", "src/models", "src/image", "src/scene",
      "src/geometry", "src/integrate"}},
    {"src/cli", {"adaptive"}},
    {"src/python", {"adaptive", "src/cli"}}};

bool is_in(const std::string& folder, const std::string& parent) {
  return folder == parent || folder.starts_with(parent + "/");
}

/// The folder of a file of ours that an include names, empty for all others. Angle brackets or quotes alike.
std::string folder_of(const std::string& name) {
  for (const char* root : {"include", "adaptive", "src", "bench"}) {
    const fs::path file = fs::path(TRESS_SOURCE_DIR) / root / name;
    if (fs::is_regular_file(file)) return fs::relative(file.parent_path(), TRESS_SOURCE_DIR).string();
  }
  return {};
}

/// Every (folder, folder that it includes), by the text of the files.
std::set<std::pair<std::string, std::string>> folder_pairs() {
  std::set<std::pair<std::string, std::string>> pairs;
  for (const char* root : {"include", "adaptive", "src", "bench/references", "bench/lab"}) {
    for (const Include& include : includes_under(root)) {
      const std::string from = fs::path(include.path).parent_path().string(), to = folder_of(include.name);
      if (!to.empty() && to != from) pairs.emplace(from, to);
    }
  }
  return pairs;
}

// The SVG has the arrows that it was drawn from in a comment, one a line.
TEST(Documents, TheArchitectureIsDrawnFromTheseIncludes) {
  std::ifstream stream(fs::path(TRESS_SOURCE_DIR) / "src" / "architecture.svg");
  std::string line;
  while (std::getline(stream, line) && line != "<!-- arrows") continue;
  std::set<std::string> drawn, found;
  while (std::getline(stream, line) && line != "-->") drawn.insert(line);
  for (const auto& [from, to] : folder_pairs()) found.insert(from + " to " + to);
  const char* remedy = "; to draw it again: bench/figures/architecture.py (needs Debian's graphviz)";
  for (const std::string& arrow : found) EXPECT_TRUE(drawn.contains(arrow)) << "not drawn: " << arrow << remedy;
  for (const std::string& arrow : drawn) EXPECT_TRUE(found.contains(arrow)) << "no longer there: " << arrow << remedy;
}

TEST(IncludeRules, EveryPairOfFoldersPointsDownwards) {
  std::set<std::pair<std::string, std::string>> pairs;
  for (const char* root : {"include", "adaptive", "src", "bench/references", "bench/lab"}) {
    for (const Include& include : includes_under(root)) {
      const std::string from = fs::path(include.path).parent_path().string(), to = folder_of(include.name);
      const auto place = [](const std::string& folder) { return std::ranges::find(folders_upwards, folder); };
      ASSERT_NE(place(from), folders_upwards.end()) << from << " has no place among the folders";
      if (to.empty() || to == from) continue;
      pairs.emplace(from, to);
      EXPECT_LT(place(to), place(from)) << include.path << ":" << include.line << " includes " << include.name;
      for (const Apart& rule : apart) {
        if (!is_in(from, rule.folder)) continue;
        for (const std::string& other : rule.may_not_include) {
          EXPECT_FALSE(is_in(to, other)) << include.path << ":" << include.line << " includes " << include.name;
        }
      }
    }
  }
  for (const auto& [from, to] : pairs) std::printf("%s -> %s\n", from.c_str(), to.c_str());
  EXPECT_GT(pairs.size(), 50u);
}

TEST(IncludeRules, AdaptiveKnowsNothingOfHairEmbreeOrPictures) {
  const std::vector<std::string> libraries{"tbb/", "Eigen/", "hwy/", "xxhash.h", "nlohmann/", "oneapi/tbb"};
  // What a POSIX file needs: rename, fsync of a folder, limits.
  const std::vector<std::string> system{"fcntl.h", "unistd.h", "sys/", "time.h"};
  expect_none("adaptive", [&](const Include& include) {
    return !is_standard(include.name) && folder_of(include.name).empty() && !starts_with_any(include.name, libraries) &&
           !starts_with_any(include.name, system);
  });
}

TEST(IncludeRules, PublicHeadersOfAdaptiveNeedOnlyTheStandardLibrary) {
  for (const char* folder : {"include/tress/base", "include/tress/adaptive"}) {
    expect_none(folder, [](const Include& include) {
      return !is_standard(include.name) && !starts_with_any(include.name, {"tress/adaptive/", "tress/base/"});
    });
  }
}

TEST(IncludeRules, PublicHeadersOfFiberNeedGlmBesides) {
  expect_none("include/tress/fiber", [](const Include& include) {
    return !is_standard(include.name) && !starts_with_any(include.name, {"tress/", "glm/"});
  });
}

TEST(IncludeRules, OnlyGeometryIncludesEmbree) {
  for (const char* folder : {"src", "include", "adaptive", "bench"}) {
    for (const Include& include : includes_under(folder)) {
      if (include.path.starts_with("src/geometry/")) continue;
      EXPECT_FALSE(include.name.starts_with("embree")) << include.path << ":" << include.line;
    }
  }
}

TEST(IncludeRules, OnlyImageIncludesOpenExr) {
  for (const char* folder : {"src", "include", "adaptive", "bench"}) {
    for (const Include& include : includes_under(folder)) {
      if (include.path.starts_with("src/image/")) continue;
      EXPECT_FALSE(starts_with_any(include.name, {"Imf", "OpenEXR", "Imath", "Iex"}))
          << include.path << ":" << include.line;
    }
  }
}

/// No line of C++ under `folders` that `is_checked` matches `pattern`.
void expect_no_line(const std::vector<std::string>& folders, const std::regex& pattern,
                    const std::function<bool(const std::string&)>& is_checked) {
  int files = 0;
  for (const std::string& folder : folders) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(TRESS_SOURCE_DIR) / folder)) {
      const std::string path = fs::relative(entry.path(), TRESS_SOURCE_DIR).string();
      if (!entry.is_regular_file() || path.ends_with(".md") || !is_checked(path)) continue;
      ++files;
      std::ifstream stream(entry.path());
      std::string text;
      for (int line = 1; std::getline(stream, text); ++line) {
        EXPECT_FALSE(std::regex_search(text, pattern)) << path << ":" << line << ": " << text;
      }
    }
  }
  EXPECT_GT(files, 20);
}

TEST(Libraries, NeitherPrintNorExit) {
  const std::regex pattern(
      R"(std::(cout|cerr|clog|printf|puts|exit|abort|quick_exit|terminate)\b|\bf?printf\s*\(\s*stderr)");
  expect_no_line({"adaptive", "include", "src"}, pattern,
                 [](const std::string& path) { return !path.starts_with("src/cli/") && path != "src/main.cpp"; });
}

// Clocks are set while a render runs: what lasts is measured by one that is not (chrono's steady_clock, CPU time).
TEST(Clocks, NothingAsksForTheTimeOfDay) {
  const std::regex pattern(
      R"(\b(system_clock|high_resolution_clock|utc_clock|gettimeofday|CLOCK_REALTIME|strftime|localtime|gmtime)\b|\btime\s*\(\s*(NULL|nullptr|0)\s*\))");
  expect_no_line({"adaptive", "include", "src"}, pattern,
                 [](const std::string& path) { return path.ends_with(".h") || path.ends_with(".cpp"); });
}

}  // namespace
