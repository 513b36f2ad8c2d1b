// Many sessions save into one cache: nothing is lost, whoever comes, goes, waits or is killed.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <set>
#include <thread>

#include "adaptive/cache_images.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

namespace fs = std::filesystem;
using Outcome = CacheUpdate::Outcome;
constexpr const char* model = "elliptical-test";

/// A table of one slice, one slice a session, with rows [begin, end).
TableSnapshot rows_of(std::uint32_t session, std::uint32_t begin, std::uint32_t end) {
  CachedSlice slice{{{1, {1.55f, 0.5f + 0.01f * static_cast<float>(session), 0.2f}}, {}, {0.0f, 0.5f}, 0.2f}, {}};
  for (int a = 0; a < 4096; ++a) slice.description.axis_a.push_back(static_cast<float>(a));
  for (std::uint32_t node = begin; node < end; ++node) slice.rows.push_back(converged_row(node, 0.004f));
  return {model, {slice}};
}

bool holds(const TableSnapshot& whole, const TableSnapshot& part) {
  return encode_cache(merge_caches(whole, part)) == encode_cache(whole);
}

class CacheSessions : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "tress_sessions_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    file_ = folder_ / "hair.cache";
  }
  void TearDown() override { fs::remove_all(folder_); }

  TableSnapshot saved() const {
    const Result<TableSnapshot> image = load_cache(file_, model);
    EXPECT_TRUE(image) << image.error().message();
    return image ? *image : TableSnapshot{model, {}};
  }
  std::string content() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.insert(entry.path().filename().string());
    return names;
  }
  /// A file as a killed save leaves it, written an hour ago.
  fs::path leftover(const std::string& name) const {
    std::ofstream(folder_ / name) << "half a cache";
    fs::last_write_time(folder_ / name, fs::file_time_type::clock::now() - std::chrono::hours(1));
    return folder_ / name;
  }

  fs::path folder_, file_;
};

TEST_F(CacheSessions, ASaveJoinsWhatAnotherSavedMeanwhile) {
  const Result<CacheUpdate> first = merge_into_cache(file_, rows_of(0, 0, 3));
  ASSERT_TRUE(first) << first.error().message();
  EXPECT_EQ(first->outcome, Outcome::created);
  const Result<CacheUpdate> other_slice = merge_into_cache(file_, rows_of(1, 0, 2));
  ASSERT_TRUE(other_slice);
  EXPECT_EQ(other_slice->outcome, Outcome::merged);
  const Result<CacheUpdate> same_slice = merge_into_cache(file_, rows_of(0, 2, 5));
  ASSERT_TRUE(same_slice);
  EXPECT_EQ(same_slice->contents.hash, cache_hash(saved()));
  EXPECT_EQ(same_slice->contents.rows(), 7u);
  EXPECT_EQ(content(), encode_cache(merge_caches(rows_of(0, 0, 5), rows_of(1, 0, 2))));
  EXPECT_EQ(files(), std::set<std::string>{"hair.cache"});
}

TEST_F(CacheSessions, AFileThatWasDeletedMeanwhileIsMadeAgain) {
  ASSERT_TRUE(merge_into_cache(file_, rows_of(0, 0, 3)));
  fs::remove(file_);
  const Result<CacheUpdate> again = merge_into_cache(file_, rows_of(0, 0, 4));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->outcome, Outcome::created);
  EXPECT_EQ(content(), encode_cache(rows_of(0, 0, 4)));
}

TEST_F(CacheSessions, ARefusedFileIsLeftAsItIs) {
  TableSnapshot foreign = small_image();
  foreign.model = "elliptical-0";
  const std::string whole = encode_cache(small_image());
  const std::vector<std::pair<std::string, std::string>> refused{{"text that somebody keeps under this name", "magic"},
                                                                 {"", "header"},
                                                                 {whole.substr(0, whole.size() - 1), "bytes"},
                                                                 {encode_cache(foreign), model}};
  for (const auto& [bytes, expected] : refused) {
    std::ofstream(file_, std::ios::binary) << bytes;
    const Result<CacheUpdate> update = merge_into_cache(file_, small_image());
    ASSERT_TRUE(update) << update.error().message();
    EXPECT_EQ(update->outcome, Outcome::refused);
    ASSERT_TRUE(update->refusal);
    EXPECT_EQ(update->refusal->file, file_.string());
    EXPECT_NE(update->refusal->expected.find(expected), std::string::npos) << update->refusal->message();
    EXPECT_EQ(content(), bytes);
    EXPECT_EQ(files(), std::set<std::string>{"hair.cache"});
  }
}

TEST_F(CacheSessions, LocksAndWritesBesideTheRealFileOfALink) {
  const fs::path elsewhere = folder_ / "elsewhere";
  fs::create_directory(elsewhere);
  const fs::path link = folder_ / "link.cache";
  fs::create_symlink("elsewhere/real.cache", folder_ / "second.cache");
  fs::create_symlink("second.cache", link);
  EXPECT_EQ(behind_links(link), folder_ / "elsewhere/real.cache");
  // Nothing there yet: the end of the chain is made, and the links stay links.
  const Result<CacheUpdate> created = merge_into_cache(link, rows_of(0, 0, 1));
  ASSERT_TRUE(created) << created.error().message();
  EXPECT_EQ(created->outcome, Outcome::created);
  // Who comes by the link and who comes by the file take the same lock.
  const int lock = ::open((elsewhere / "real.cache.lock").c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_EQ(::flock(lock, LOCK_EX), 0);
  std::atomic<bool> done{false};
  std::thread waits([&] {
    EXPECT_TRUE(merge_into_cache(link, rows_of(0, 1, 2)));
    done = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_FALSE(done);
  ::close(lock);
  waits.join();
  EXPECT_TRUE(fs::is_symlink(link));
  file_ = elsewhere / "real.cache";
  EXPECT_EQ(content(), encode_cache(rows_of(0, 0, 2)));
  EXPECT_EQ(std::distance(fs::directory_iterator(elsewhere), {}), 1);
  fs::create_symlink("loop.cache", folder_ / "loop.cache");
  const Result<CacheUpdate> loop = merge_into_cache(folder_ / "loop.cache", rows_of(0, 0, 1));
  EXPECT_TRUE(loop && loop->outcome == Outcome::refused);
  EXPECT_TRUE(fs::is_symlink(folder_ / "loop.cache"));
}

TEST_F(CacheSessions, WhatAKilledSessionLeftIsTakenOverAndNamed) {
  std::ofstream(folder_ / "hair.cache.lock").close();
  const fs::path old = leftover("hair.cache.tmp-123-0");
  for (const char* name : {"hair.cache.tmp-123", "hair.cache.tmp-1x-0", "hair.cache.tmp-1-2.txt", "other.tmp-1-2"}) {
    leftover(name);
  }
  std::ofstream(folder_ / "hair.cache.tmp-124-0") << "of a save that may still run where locks do not work";
  const std::size_t before = files().size();
  const Result<CacheUpdate> update = merge_into_cache(file_, small_image());
  ASSERT_TRUE(update);
  EXPECT_EQ(update->outcome, Outcome::created);
  EXPECT_EQ(update->removed, std::vector<fs::path>{old});
  EXPECT_EQ(files().size(), before - 1);  // the cache has come; lock and leftover have gone
  EXPECT_FALSE(fs::exists(folder_ / "hair.cache.lock"));
}

TEST_F(CacheSessions, KeepsThePermissionsOfTheFile) {
  ASSERT_TRUE(merge_into_cache(file_, rows_of(0, 0, 1)));
  fs::permissions(file_, fs::perms(0660));
  ASSERT_TRUE(merge_into_cache(file_, rows_of(0, 1, 2)));
  EXPECT_EQ(fs::status(file_).permissions(), fs::perms(0660));
}

TEST_F(CacheSessions, WhatCannotBeWrittenIsAnErrorAndNothingChanges) {
  const Result<CacheUpdate> missing = merge_into_cache(folder_ / "none" / "hair.cache", small_image());
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().file, (folder_ / "none" / "hair.cache").string());
  EXPECT_FALSE(missing.error().found.empty());
  EXPECT_FALSE(merge_into_cache(file_, TableSnapshot{}).has_value()) << "a model without a name";
  TableSnapshot bad = small_image();
  bad.slices[0].rows[0].energy = -1;
  EXPECT_FALSE(merge_into_cache(file_, bad).has_value()) << "what could not be read back";
  EXPECT_TRUE(files().empty());
}

// In a child, so that root can do it as somebody whom permissions bind.
TEST_F(CacheSessions, AReadOnlyFolderIsReportedAndLeftAlone) {
  ASSERT_TRUE(merge_into_cache(file_, rows_of(0, 0, 1)));
  fs::permissions(folder_, fs::perms(0555));
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    constexpr uid_t nobody = 65534;
    if (::geteuid() == 0 && ::setuid(nobody) != 0) ::_exit(2);
    const Result<CacheUpdate> update = merge_into_cache(file_, rows_of(0, 1, 2));
    const std::optional<Error> replaced = save_cache(file_, rows_of(0, 1, 2));
    const bool is_reported = !update && replaced && update.error().file == file_.string() &&
                             update.error().message() == replaced->message() &&
                             replaced->found == std::strerror(EACCES);
    ::_exit(is_reported && load_cache(file_, model) ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  fs::permissions(folder_, fs::perms(0700));
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(content(), encode_cache(rows_of(0, 0, 1)));
  EXPECT_EQ(files(), std::set<std::string>{"hair.cache"});
}

// A child saves row after row and reports each that is saved; it is killed in the middle. What it reported must be
// there, and all that was there before: the old cache or the new, never less.
TEST_F(CacheSessions, KilledAtAHundredMomentsOfSavingItIsTheOldCacheOrTheNew) {
  ASSERT_TRUE(merge_into_cache(file_, rows_of(0, 0, 1)));
  std::uint32_t rows = 1;
  std::size_t left = 0;
  RandomStream random(20150701);
  for (int round = 0; round < 100; ++round) {
    int pipe_ends[2];
    ASSERT_EQ(::pipe(pipe_ends), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (std::uint32_t row = rows;; ++row) {
        if (!merge_into_cache(file_, rows_of(0, row, row + 1))) ::_exit(1);
        if (::write(pipe_ends[1], &row, sizeof row) != sizeof row) ::_exit(1);
      }
    }
    ::close(pipe_ends[1]);
    std::uint32_t row = 0;
    ASSERT_EQ(::read(pipe_ends[0], &row, sizeof row), static_cast<ssize_t>(sizeof row));  // it is in its loop of saves
    // Saves take from 0.3 ms on a disk in memory to some 10 ms: uniform over several of them.
    std::this_thread::sleep_for(std::chrono::microseconds(static_cast<int>(20'000 * random.next())));
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the child could not save";
    while (::read(pipe_ends[0], &row, sizeof row) == static_cast<ssize_t>(sizeof row)) {
    }
    ::close(pipe_ends[0]);
    const TableSnapshot now = saved();
    ASSERT_TRUE(holds(now, rows_of(0, 0, row + 1))) << "round " << round;
    rows = static_cast<std::uint32_t>(now.slices.at(0).rows.size());
    ASSERT_LE(rows, row + 2) << "the one that was being saved, and no more";
  }
  for (const std::string& name : files()) {
    if (!name.starts_with("hair.cache.tmp-")) continue;
    ++left;
    fs::last_write_time(folder_ / name, fs::file_time_type::clock::now() - std::chrono::hours(1));
  }
  RecordProperty("rows_saved", static_cast<int>(rows));
  RecordProperty("temporary_files_left", static_cast<int>(left));
  const Result<CacheUpdate> last = merge_into_cache(file_, rows_of(1, 0, 1));
  ASSERT_TRUE(last) << last.error().message();
  EXPECT_EQ(last->removed.size(), left);
  EXPECT_TRUE(holds(saved(), merge_caches(rows_of(0, 0, rows), rows_of(1, 0, 1))));
  EXPECT_EQ(files(), std::set<std::string>{"hair.cache"});
}

TEST_F(CacheSessions, EightProcessesLoseNothing) {
  constexpr std::uint32_t sessions = 8, saves = 10;
  std::vector<pid_t> children;
  for (std::uint32_t session = 0; session < sessions; ++session) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      // A slice of its own, and every eighth row of one that all share.
      for (std::uint32_t i = 0; i < saves; ++i) {
        const std::uint32_t shared = i * sessions + session;
        if (!merge_into_cache(file_, merge_caches(rows_of(session + 1, i, i + 1), rows_of(0, shared, shared + 1)))) {
          ::_exit(1);
        }
      }
      ::_exit(0);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  }
  TableSnapshot all = rows_of(0, 0, saves * sessions);
  for (std::uint32_t session = 0; session < sessions; ++session) {
    all = merge_caches(all, rows_of(session + 1, 0, saves));
  }
  EXPECT_EQ(content(), encode_cache(all));
  EXPECT_EQ(files(), std::set<std::string>{"hair.cache"});
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
