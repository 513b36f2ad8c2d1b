// What a file that is replaced keeps, what is not replaced, and which leftovers go.
#include "tress/base/replace_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace tress::inline v0_2::adaptive {
namespace {

namespace fs = std::filesystem;

class ReplaceFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "tress_replace_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    file_ = folder_ / "a.bin";
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::string content(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::ptrdiff_t files_in_folder() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }
  /// Left by a process that is no more, `age` older than what is written now.
  fs::path leftover(const std::string& name, std::chrono::hours age) const {
    std::ofstream(folder_ / name) << "half of a f";
    fs::last_write_time(folder_ / name, fs::file_time_type::clock::now() - age);
    return folder_ / name;
  }

  fs::path folder_, file_;
};

TEST_F(ReplaceFile, FollowsLinksAndKeepsPermissions) {
  std::ofstream(file_) << "old";
  fs::permissions(file_, fs::perms(0640));
  fs::create_symlink("a.bin", folder_ / "link");
  ASSERT_FALSE(replace_file(folder_ / "link", "new"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(content(file_), "new");
  EXPECT_EQ(fs::status(file_).permissions(), fs::perms(0640));
  EXPECT_EQ(files_in_folder(), 2);
}

// Another name of the same file keeps what it had: the old file is never written into.
TEST_F(ReplaceFile, LeavesTheOtherNameOfAHardLinkAsItWas) {
  std::ofstream(file_) << "old";
  fs::create_hard_link(file_, folder_ / "other");
  ASSERT_FALSE(replace_file(file_, "new"));
  EXPECT_EQ(content(file_), "new");
  EXPECT_EQ(content(folder_ / "other"), "old");
}

TEST_F(ReplaceFile, KeepsOwnerAndGroupWhereItMay) {
  // Only root can give files away; others can give them to a group of their own, the last of which is not the first.
  ::uid_t user = ::geteuid();
  ::gid_t group = ::getegid();
  if (user == 0) {
    user = 12345;
    group = 54321;
  } else if (const int count = ::getgroups(0, nullptr); count > 0) {
    std::vector<::gid_t> groups(static_cast<std::size_t>(count));
    ASSERT_EQ(::getgroups(count, groups.data()), count);
    group = groups.back();
  }
  std::ofstream(file_) << "old";
  ASSERT_EQ(::chown(file_.c_str(), user, group), 0);
  ASSERT_FALSE(replace_file(file_, "new"));
  struct stat status{};
  ASSERT_EQ(::stat(file_.c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, user);
  EXPECT_EQ(status.st_gid, group);
}

TEST_F(ReplaceFile, DoesNotReplaceDevicesPipesAndFolders) {
  ASSERT_EQ(::mkfifo(file_.c_str(), 0600), 0);
  fs::create_directory(folder_ / "folder");
  fs::create_symlink("/dev/null", folder_ / "null");
  for (const char* name : {"a.bin", "folder", "null"}) {
    const std::optional<Error> error = replace_file(folder_ / name, "new"), checked = check_replaceable(folder_ / name);
    ASSERT_TRUE(error && checked) << name;
    EXPECT_EQ(error->message(), checked->message());
    EXPECT_EQ(error->expected, "a file to write");
  }
  EXPECT_TRUE(fs::is_fifo(file_));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_EQ(files_in_folder(), 3);
}

TEST_F(ReplaceFile, ANameWithoutRoomForATemporaryOneIsFoundBeforehand) {
  const fs::path longest = folder_ / std::string(250, 'x');
  const std::optional<Error> error = check_replaceable(longest);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->file, longest.string());
  EXPECT_NE(error->expected.find("name"), std::string::npos) << error->message();
  EXPECT_TRUE(check_replaceable(folder_ / "none" / "a"));
  EXPECT_FALSE(check_replaceable(file_));
  EXPECT_EQ(files_in_folder(), 0);
}

// A clock that has been set back makes old files of the future: they must not pile up until it has caught up.
TEST_F(ReplaceFile, RemovesLeftoversOfThePastAndOfTheFuture) {
  std::ofstream(file_) << "whole";
  const fs::path past = leftover("a.bin.tmp-12-0", std::chrono::hours(1));
  const fs::path future = leftover("a.bin.tmp-13-0", std::chrono::hours(-1));
  leftover("b.bin.tmp-13-0", std::chrono::hours(1));
  leftover("a.bin.tmp-14-0", std::chrono::hours(0));
  EXPECT_EQ(remove_leftovers(file_), (std::vector<fs::path>{past, future}));
  EXPECT_EQ(files_in_folder(), 3);
}

TEST_F(ReplaceFile, LeavesTheTemporaryFileOfAWriterThatLives) {
  std::ofstream(file_) << "whole";
  const fs::path slow = leftover("a.bin.tmp-12-0", std::chrono::hours(1));
  const int writer = ::open(slow.c_str(), O_RDWR);
  ASSERT_EQ(::flock(writer, LOCK_EX), 0);
  EXPECT_TRUE(remove_leftovers(file_).empty());
  ::close(writer);
  EXPECT_EQ(remove_leftovers(file_), std::vector<fs::path>{slow});
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
