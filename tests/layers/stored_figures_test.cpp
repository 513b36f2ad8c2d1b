// Every stored figure names a commit of the history: bench/results/**/*.json, "context" / "commit".
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace {

namespace fs = std::filesystem;

const fs::path root = TRESS_SOURCE_DIR;

/// Exit status of git here. Repositories of another owner are read too: nothing of them is run.
int git(const std::string& words) {
  const std::string command =
      "git -c safe.directory='*' -C '" + root.string() + "' " + words + " >/dev/null 2>/dev/null";
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(StoredFigures, NameACommitOfTheHistory) {
  // In a tarball, in a clone of a few commits and without git there is no history to ask: then only that they name one.
  const bool history = git("rev-parse HEAD") == 0 && fs::exists(root / ".git") &&
                       git("rev-parse --is-shallow-repository | grep -q false") == 0;
  if (!history) std::printf("no history here: only whether each figure names a commit\n");
  int figures = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / "bench" / "results")) {
    if (entry.path().extension() != ".json") continue;
    ++figures;
    const std::string name = fs::relative(entry.path(), root).string();
    std::ifstream file(entry.path());
    const nlohmann::json content = nlohmann::json::parse(file, nullptr, false);
    ASSERT_TRUE(content.is_object() && content.contains("context")) << name << ": no \"context\"";
    const std::string commit = content["context"].value("commit", "");
    ASSERT_EQ(commit.size(), 40u) << name;
    ASSERT_EQ(commit.find_first_not_of("0123456789abcdef"), std::string::npos) << name;
    if (history) {
      EXPECT_EQ(git("merge-base --is-ancestor " + commit + " HEAD"), 0) << name << ": made by " << commit;
    }
  }
  EXPECT_GT(figures, 0);
}

}  // namespace
