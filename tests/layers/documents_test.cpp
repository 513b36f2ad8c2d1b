// What a reader of the documents may rely on: links and file names that lead somewhere, numbers written 0.01.
#include <gtest/gtest.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Line {
  std::string text;
  int number = 0;
  bool code = false;  ///< of a fenced or indented block
};

struct Document {
  fs::path file;
  std::vector<Line> lines;
};

std::string name_of(const Document& document) { return fs::relative(document.file, TRESS_SOURCE_DIR).string(); }

Document read(const fs::path& file) {
  Document document{file, {}};
  std::ifstream stream(file);
  bool fenced = false;
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    const bool fence = text.starts_with("```");
    document.lines.push_back({text, number, fence || fenced || text.starts_with("    ")});
    if (fence) fenced = !fenced;
  }
  return document;
}

/// Every Markdown file of the project; not of build trees, nor of what hides behind a dot.
std::vector<Document> documents() {
  std::vector<Document> found;
  for (fs::recursive_directory_iterator entry(TRESS_SOURCE_DIR), end; entry != end; ++entry) {
    const std::string name = entry->path().filename().string();
    if (entry->is_directory() && (name.starts_with(".") || name == "build" || name == "out")) {
      entry.disable_recursion_pending();
    } else if (entry->path().extension() == ".md") {
      found.push_back(read(entry->path()));
    }
  }
  return found;
}

/// What `pattern` captures first in a line.
std::vector<std::string> captures(const std::string& text, const std::regex& pattern) {
  std::vector<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match) {
    found.push_back((*match)[1]);
  }
  return found;
}

/// The anchor of a heading, as GitHub and GitLab make it: lower case, spaces to hyphens, punctuation dropped.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char letter : heading.substr(heading.find_first_not_of("# "))) {
    const auto byte = static_cast<unsigned char>(letter);
    if (letter == ' ') anchor += '-';
    if (std::isalnum(byte) || letter == '-' || letter == '_') anchor += static_cast<char>(std::tolower(byte));
  }
  return anchor;
}

bool has_anchor(const Document& document, const std::string& anchor) {
  for (const Line& line : document.lines) {
    if (!line.code && line.text.starts_with("#") && anchor_of(line.text) == anchor) return true;
  }
  return false;
}

TEST(Documents, LinksLeadSomewhere) {
  const std::regex link(R"(\]\(([^)\s]+)\))");
  int links = 0;
  for (const Document& document : documents()) {
    for (const Line& line : document.lines) {
      if (line.code) continue;
      for (const std::string& target : captures(line.text, link)) {
        if (target.find("://") != std::string::npos) continue;
        ++links;
        const std::size_t hash = target.find('#');
        const std::string path = target.substr(0, hash);
        const fs::path file = path.empty() ? document.file : document.file.parent_path() / path;
        EXPECT_TRUE(fs::exists(file)) << name_of(document) << ":" << line.number << ": no file " << path;
        if (hash == std::string::npos || !fs::exists(file)) continue;
        EXPECT_TRUE(has_anchor(read(file), target.substr(hash + 1)))
            << name_of(document) << ":" << line.number << ": no heading " << target;
      }
    }
  }
  EXPECT_GT(links, 20);
}

// A file that is named in `code` with its folder exists, seen from the project, from the document or as it is included.
TEST(Documents, NameFilesThatExist) {
  const std::regex name(R"((?:^|[`\s(])((?:[\w.-]+/)+[\w-]+\.(?:cpp|h|py|md|json|obj|cmake))(?=[`\s),:;]|$))");
  const std::set<std::string> made_by_commands{"build", "DIR", ".."};
  int names = 0;
  for (const Document& document : documents()) {
    for (const Line& line : document.lines) {
      for (const std::string& path : captures(line.text, name)) {
        if (made_by_commands.contains(path.substr(0, path.find('/'))) || path.find("NAME") != std::string::npos)
          continue;
        ++names;
        bool exists = false;
        for (const fs::path& root : {fs::path(TRESS_SOURCE_DIR), document.file.parent_path(),
                                     fs::path(TRESS_SOURCE_DIR) / "include", fs::path(TRESS_SOURCE_DIR) / "bench"}) {
          exists = exists || fs::exists(root / path);
        }
        EXPECT_TRUE(exists) << name_of(document) << ":" << line.number << ": no file " << path;
      }
    }
  }
  EXPECT_GT(names, 20);
}

/// SUITE.NAME of every test of GoogleTest and RapidCheck.
std::set<std::string> names_of_tests() {
  const std::regex declared(R"((?:TEST(?:_[FP])?|RC_GTEST_PROP)\((\w+), (\w+))");
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(TRESS_SOURCE_DIR) / "tests")) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream stream(entry.path());
    std::smatch match;
    for (std::string line; std::getline(stream, line);) {
      if (!line.starts_with("TEST") && !line.starts_with("RC_GTEST_PROP")) continue;
      if (std::regex_search(line, match, declared)) names.insert(match.str(1) + "." + match.str(2));
    }
  }
  return names;
}

TEST(Documents, NameTestsThatExist) {
  const std::set<std::string> tests = names_of_tests();
  const std::regex name(R"(\b([A-Z][A-Za-z]+\.(?:[A-Z][a-z]+[A-Z]\w+|[a-z]+_\w+))\b)");
  int names = 0;
  for (const Document& document : documents()) {
    for (const Line& line : document.lines) {
      for (const std::string& test : captures(line.text, name)) {
        ++names;
        EXPECT_TRUE(tests.contains(test)) << name_of(document) << ":" << line.number << ": no test " << test;
      }
    }
  }
  EXPECT_GT(names, 10);
}

TEST(Documents, WriteNumbersWithTheirZero) {
  const std::regex bare(R"((?:^|[^\w.])(\.\d+))");
  for (const Document& document : documents()) {
    for (const Line& line : document.lines) {
      if (line.code) continue;
      for (const std::string& number : captures(line.text, bare)) {
        ADD_FAILURE() << name_of(document) << ":" << line.number << ": " << number << " is to be 0" << number;
      }
    }
  }
}

}  // namespace
