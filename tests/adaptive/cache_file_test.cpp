// A save is whole or it did not happen: the old file stays and nothing is left beside it.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <thread>

#include "adaptive/cache_images.h"

namespace tress::inline v0_2::adaptive {
namespace {

namespace fs = std::filesystem;
constexpr const char* model = "elliptical-test";

class CacheFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "tress_cache_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    file_ = folder_ / "hair.cache";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string content() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::ptrdiff_t files_in_folder() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }

  fs::path folder_, file_;
};

TEST_F(CacheFile, SavesAndLoads) {
  ASSERT_FALSE(save_cache(file_, small_image()));
  EXPECT_EQ(content(), encode_cache(small_image()));
  EXPECT_EQ(files_in_folder(), 1);
  const Result<TableSnapshot> loaded = load_cache(file_, model);
  ASSERT_TRUE(loaded) << loaded.error().message();
  EXPECT_EQ(encode_cache(*loaded), encode_cache(small_image()));
}

TEST_F(CacheFile, SavesBesideTheProcessToo) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  const std::optional<Error> error = save_cache("hair.cache", small_image());
  fs::current_path(before);
  EXPECT_FALSE(error);
  EXPECT_EQ(content(), encode_cache(small_image()));
}

TEST_F(CacheFile, ReplacesWhatALinkPointsTo) {
  const fs::path link = folder_ / "link.cache";
  ASSERT_FALSE(save_cache(file_, TableSnapshot{model, {}}));
  fs::create_symlink(file_, link);
  ASSERT_FALSE(save_cache(link, small_image()));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(content(), encode_cache(small_image()));
}

TEST_F(CacheFile, RefusesWhatIsNotAFile) {
  EXPECT_EQ(load_cache(folder_ / "absent", model).error().file, (folder_ / "absent").string());
  EXPECT_EQ(load_cache(folder_, model).error().expected, "a regular file");
  std::ofstream(file_).close();
  EXPECT_FALSE(load_cache(file_, model).has_value());
}

TEST_F(CacheFile, RefusesFoldersThatCannotBeWrittenTo) {
  std::ofstream(folder_ / "plain") << "text";
  for (const fs::path& file : {folder_ / "missing" / "hair.cache", folder_ / "plain" / "hair.cache"}) {
    const std::optional<Error> error = save_cache(file, small_image());
    ASSERT_TRUE(error) << file;
    EXPECT_EQ(error->file, file.string());
    EXPECT_FALSE(error->found.empty());
  }
  EXPECT_EQ(files_in_folder(), 1);
}

TEST_F(CacheFile, LeavesNothingWhereTheRenameFails) {
  fs::create_directories(file_ / "occupied");
  EXPECT_TRUE(save_cache(file_, small_image()));
  EXPECT_EQ(files_in_folder(), 1);
}

// A disk that fills up, by a limit on file sizes in a child of its own.
TEST_F(CacheFile, KeepsTheOldFileWhereTheNewOneHasNoRoom) {
  const TableSnapshot old{model, {}};
  ASSERT_FALSE(save_cache(file_, old));
  ASSERT_GT(encode_cache(small_image()).size(), 256u);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{256, 256};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) ::_exit(2);
    const std::optional<Error> error = save_cache(file_, small_image());
    ::_exit(error && !error->found.empty() ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(content(), encode_cache(old));
  EXPECT_EQ(files_in_folder(), 1);
}

TEST_F(CacheFile, NeverSavesWhatCouldNotBeLoaded) {
  ASSERT_FALSE(save_cache(file_, small_image()));
  TableSnapshot bad = small_image();
  bad.slices[0].rows[0].energy = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(save_cache(file_, bad));
  EXPECT_EQ(content(), encode_cache(small_image()));
}

TEST_F(CacheFile, IsWholeWhileSeveralSave) {
  ASSERT_FALSE(save_cache(file_, small_image()));
  std::vector<std::thread> writers;
  for (int i = 0; i < 4; ++i) {
    writers.emplace_back([&] {
      for (int k = 0; k < 5; ++k) EXPECT_FALSE(save_cache(file_, small_image()));
    });
  }
  for (int k = 0; k < 50; ++k) EXPECT_TRUE(load_cache(file_, model).has_value());
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(files_in_folder(), 1);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
