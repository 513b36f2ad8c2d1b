// A folder of caches of one slice each: what a service finds there again, what goes first, and what is never lost.
#include "tress/adaptive/cache_folder.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "adaptive/cache_images.h"
#include "adaptive/toy_target.h"

namespace tress::inline v0_2::adaptive {
namespace {

namespace fs = std::filesystem;
using testing::MovingPeaks;
using testing::toy_slice;

class FolderOfCaches : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "tress_folder_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    folder_ = root_ / "a" / "tress";
  }
  void TearDown() override { fs::remove_all(root_); }

  /// A row of each of these lobes, converged at this error.
  static TableSnapshot rows_of(const std::vector<std::uint32_t>& lobes, float objective, std::uint32_t first = 0) {
    TableSnapshot image{MovingPeaks().model_name(), {}};
    for (const std::uint32_t lobe : lobes)
      image.slices.push_back(
          {toy_slice(lobe, 4), {converged_row(first, objective), converged_row(first + 1, objective)}});
    return image;
  }
  static void add_slices(Service& service, const std::vector<std::uint32_t>& lobes) {
    for (const std::uint32_t lobe : lobes) ASSERT_TRUE(service.add_slice(toy_slice(lobe, 4)));
  }
  /// Saves rows of these lobes, as a session that has learned them.
  void save(const std::vector<std::uint32_t>& lobes, float objective = 0.004f, std::uint32_t first = 0,
            bool replaces = false) {
    Service service(Options{}, target_);
    add_slices(service, lobes);
    ASSERT_FALSE(service.load(rows_of(lobes, objective, first)));
    CacheFolder folder(folder_);
    ASSERT_FALSE(folder.check());
    const auto saved = folder.save(service, replaces);
    ASSERT_TRUE(saved) << saved.error().message();
    EXPECT_EQ(saved->files, lobes.size());
    EXPECT_TRUE(saved->refused.empty());
  }
  /// Rows that a session with these lobes finds.
  std::uint64_t found(const std::vector<std::uint32_t>& lobes) {
    Service service(Options{}, target_);
    add_slices(service, lobes);
    const CacheFolder::Loaded loaded = CacheFolder(folder_).load(service);
    EXPECT_TRUE(loaded.refused.empty());
    return loaded.contents.rows();
  }
  void set_age(const fs::path& file, int hours) const {
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(hours));
  }

  void write_other_files() const { std::ofstream(folder_ / "notes.txt") << "kept"; }

  MovingPeaks target_;
  fs::path root_, folder_;
};

TEST_F(FolderOfCaches, IsThatOfTheEnvironment) {
  const auto set = [](const char* name, const char* value) {
    if (value != nullptr)
      ::setenv(name, value, 1);
    else
      ::unsetenv(name);
  };
  const char* const home = std::getenv("HOME");
  const std::string old_home = home != nullptr ? home : "";
  const char* const caches = std::getenv("XDG_CACHE_HOME");
  const std::string old_caches = caches != nullptr ? caches : "";
  set("HOME", "/home/somebody");
  set("XDG_CACHE_HOME", "/elsewhere");
  EXPECT_EQ(*default_cache_folder(), "/elsewhere/tress");
  set("XDG_CACHE_HOME", "relative");
  EXPECT_EQ(*default_cache_folder(), "/home/somebody/.cache/tress") << "a relative one is to be ignored";
  set("XDG_CACHE_HOME", nullptr);
  EXPECT_EQ(*default_cache_folder(), "/home/somebody/.cache/tress");
  set("HOME", nullptr);
  EXPECT_FALSE(default_cache_folder());
  set("HOME", home != nullptr ? old_home.c_str() : nullptr);
  set("XDG_CACHE_HOME", caches != nullptr ? old_caches.c_str() : nullptr);
}

TEST_F(FolderOfCaches, HasAFileForEachSliceAndGivesEachServiceItsOwn) {
  EXPECT_EQ(found({1, 2}), 0u);
  save({1, 2});
  save({3});
  EXPECT_EQ(CacheFolder(folder_).files().size(), 3u);
  EXPECT_EQ(found({1}), 2u);
  EXPECT_EQ(found({1, 3}), 4u);
  EXPECT_EQ(found({4}), 0u);
  for (const CacheFolder::File& file : CacheFolder(folder_).files()) {
    const auto cache = load_cache(file.path, "");
    ASSERT_TRUE(cache);
    EXPECT_EQ(cache->slices.size(), 1u);
  }
}

TEST_F(FolderOfCaches, JoinsWhatSessionsSaveAndReplacesWhereAsked) {
  save({1}, 0.004f, 0);
  save({1}, 0.004f, 4);
  EXPECT_EQ(found({1}), 4u);
  save({1}, 0.004f, 8, true);
  EXPECT_EQ(found({1}), 2u);
}

TEST_F(FolderOfCaches, WritesNoFileThatHasNotChanged) {
  save({1});
  const fs::path file = CacheFolder(folder_).files().front().path;
  Service service(Options{}, target_);
  add_slices(service, {1});
  CacheFolder folder(folder_);
  EXPECT_EQ(folder.load(service).contents.rows(), 2u);
  fs::create_hard_link(file, root_ / "the same file");
  set_age(file, 5);
  const auto saved = folder.save(service, false);
  ASSERT_TRUE(saved) << saved.error().message();
  EXPECT_EQ(saved->contents.rows(), 2u);
  EXPECT_EQ(fs::hard_link_count(file), 2u) << "no other has taken its place";
  EXPECT_LT(fs::file_time_type::clock::now() - fs::last_write_time(file), std::chrono::hours(1)) << "but it was used";
}

TEST_F(FolderOfCaches, LetsGoWhatWasUsedLongestAgo) {
  save({1});
  const fs::path first = CacheFolder(folder_).files().front().path;
  set_age(first, 3);
  save({2});
  std::uint64_t bytes = 0;
  fs::path second;
  for (const CacheFolder::File& file : CacheFolder(folder_).files()) {
    if (file.path != first) set_age(second = file.path, 2);
    bytes += file.bytes;
  }
  save({3});
  EXPECT_EQ(found({1}), 2u) << "and so it was used now";
  write_other_files();
  const auto pruned = CacheFolder(folder_).prune(bytes);
  ASSERT_TRUE(pruned) << pruned.error().message();
  ASSERT_EQ(pruned->removed.size(), 1u);
  EXPECT_EQ(pruned->removed.front().path, second);
  EXPECT_EQ(pruned->files_left, 2u);
  EXPECT_LE(pruned->bytes_left, bytes);
  EXPECT_EQ(found({1, 2, 3}), 4u);
  ASSERT_TRUE(CacheFolder(folder_).prune(0));
  EXPECT_EQ(found({1, 2, 3}), 0u);
  EXPECT_TRUE(fs::exists(folder_ / "notes.txt")) << "what is not ours stays";
}

TEST_F(FolderOfCaches, AFileThatIsNoCacheIsReportedAndLeftAsItIs) {
  save({1, 2});
  const fs::path broken = CacheFolder(folder_).files().front().path;
  std::ofstream(broken, std::ios::trunc) << "no cache";
  Service service(Options{}, target_);
  add_slices(service, {1, 2});
  CacheFolder folder(folder_);
  const CacheFolder::Loaded loaded = folder.load(service);
  ASSERT_EQ(loaded.refused.size(), 1u);
  EXPECT_EQ(loaded.refused.front().file, broken.string());
  EXPECT_EQ(loaded.contents.rows(), 2u) << "the other slice";
  ASSERT_FALSE(service.load(rows_of({1, 2}, 0.003f, 6)));
  const auto saved = folder.save(service, false);
  ASSERT_TRUE(saved);
  EXPECT_EQ(saved->refused.size(), 1u);
  EXPECT_EQ(fs::file_size(broken), 8u);
  EXPECT_EQ(saved->contents.rows(), 4u);
}

// Four sessions save while another removes: whatever goes, what a session saves last is there, whole.
TEST_F(FolderOfCaches, MayBePrunedWhileOthersSave) {
  ASSERT_FALSE(CacheFolder(folder_).check());
  std::vector<std::thread> sessions;
  for (std::uint32_t lobe = 1; lobe <= 4; ++lobe) {
    sessions.emplace_back([this, lobe] {
      Service service(Options{}, target_);
      add_slices(service, {lobe});
      ASSERT_FALSE(service.load(rows_of({lobe}, 0.004f)));
      for (int i = 0; i < 25; ++i) {
        CacheFolder folder(folder_);
        const auto saved = folder.save(service, false);
        ASSERT_TRUE(saved) << saved.error().message();
      }
    });
  }
  for (int i = 0; i < 100; ++i) {
    const auto pruned = CacheFolder(folder_).prune(0);
    ASSERT_TRUE(pruned) << pruned.error().message();
  }
  for (std::thread& session : sessions) session.join();
  for (const CacheFolder::File& file : CacheFolder(folder_).files()) EXPECT_TRUE(load_cache(file.path, ""));
  save({1, 2, 3, 4});
  EXPECT_EQ(found({1, 2, 3, 4}), 8u);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
