#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace {

namespace fs = std::filesystem;

TEST(OwnFolder, IsEmptyAtTheStart) {
  EXPECT_TRUE(fs::is_empty(testing::TempDir()));
  EXPECT_TRUE(fs::equivalent(testing::TempDir(), fs::temp_directory_path()));
}

TEST(OwnFolder, IsNotThatOfAnotherProcess) {
  const fs::path mine = fs::path(testing::TempDir()) / "mine";
  std::ofstream(mine) << "of this process";
  const std::string other =
      fs::read_symlink("/proc/self/exe").string() + " --gtest_filter=OwnFolder.IsEmptyAtTheStart > /dev/null";
  EXPECT_EQ(std::system(other.c_str()), 0);
  EXPECT_TRUE(fs::exists(mine));
  fs::remove(mine);
}

}  // namespace
