// Who may include what. The layers of README.md, checked on the text of every file.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <string>
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

TEST(IncludeRules, AdaptiveKnowsNothingOfHairEmbreeOrPictures) {
  const std::vector<std::string> own{"tress/adaptive/", "mixture/", "knots/", "sketch/",
                                     "learner/",        "table/",   "cache/", "telemetry/"};
  const std::vector<std::string> libraries{"tbb/", "Eigen/", "hwy/", "xxhash.h", "nlohmann/", "oneapi/tbb"};
  // What a POSIX file needs: rename, fsync of a folder, limits.
  const std::vector<std::string> system{"fcntl.h", "unistd.h", "sys/", "time.h"};
  expect_none("adaptive", [&](const Include& include) {
    return !is_standard(include.name) && !starts_with_any(include.name, own) &&
           !starts_with_any(include.name, libraries) && !starts_with_any(include.name, system);
  });
}

TEST(IncludeRules, PublicHeadersOfAdaptiveNeedOnlyTheStandardLibrary) {
  expect_none("include/tress/adaptive", [](const Include& include) {
    return !is_standard(include.name) && !include.name.starts_with("tress/adaptive/");
  });
}

TEST(IncludeRules, FiberHeadersStandWithoutTheRenderer) {
  expect_none("include/tress/fiber", [](const Include& include) {
    return !is_standard(include.name) && !starts_with_any(include.name, {"tress/", "glm/"});
  });
  for (const char* folder : {"src/fiber", "src/models"}) {
    expect_none(folder, [](const Include& include) {
      return starts_with_any(include.name, {"scene/", "intersect/", "integrate/", "image/", "cli/"});
    });
  }
}

TEST(IncludeRules, OnlyIntersectIncludesEmbree) {
  for (const char* folder : {"src", "include", "adaptive", "bench"}) {
    for (const Include& include : includes_under(folder)) {
      if (include.path.starts_with("src/intersect/")) continue;
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

TEST(IncludeRules, LayersPointDownwards) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> above{
      {"src/image", {"scene/", "intersect/", "integrate/", "cli/", "models/", "fiber/"}},
      {"src/scene", {"intersect/", "integrate/", "cli/", "models/"}},
      {"src/intersect", {"integrate/", "cli/", "models/"}},
      {"src/integrate", {"cli/", "models/"}},
  };
  for (const auto& [folder, forbidden] : above) {
    expect_none(folder, [&](const Include& include) { return starts_with_any(include.name, forbidden); });
  }
}

/// No line of C++ under `folders` that `is_checked` matches `pattern`.
void expect_no_line(const std::vector<std::string>& folders, const std::regex& pattern,
                    const std::function<bool(const std::string&)>& is_checked) {
  int files = 0;
  for (const std::string& folder : folders) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(TRESS_SOURCE_DIR) / folder)) {
      const std::string path = fs::relative(entry.path(), TRESS_SOURCE_DIR).string();
      if (!entry.is_regular_file() || !is_checked(path)) continue;
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
