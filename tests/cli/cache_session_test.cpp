// One render's dealings with its cache file, without the render: what is saved when, and what a signal interrupts.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <memory>
#include <thread>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "cli/process.h"
#include "cli/run_tress.h"
#include "cli/warm_cache_session.h"
#include "tress/adaptive/cache.h"

namespace tress::test {
namespace {

using adaptive::Service;
using adaptive::TableSnapshot;
using cli::CacheMode;
using cli::WarmCacheSession;
using std::chrono::hours;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

constexpr const char* model = "moving-peaks-1";

class CacheSession : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    file_ = path("t.cache");
  }

  /// A service that uses the slice of one lobe; learn() takes it a step further.
  std::unique_ptr<Service> service(std::uint32_t lobe) const {
    auto made = std::make_unique<Service>(adaptive::Options{}, target_);
    made->add_slice(testing::toy_slice(lobe, 5));
    return made;
  }
  static void learn(Service& service, std::uint64_t pass) {
    testing::run_pass(service, 1, pass, 1000, 1);
    service.publish();
  }
  WarmCacheSession session(CacheMode mode, WarmCacheSession::Clock::duration interval = hours(1)) const {
    return {file_, mode, model, interval};
  }
  TableSnapshot saved() const {
    const auto image = adaptive::load_cache(file_, model);
    EXPECT_TRUE(image) << image.error().message();
    return image ? *image : TableSnapshot{model, {}};
  }
  bool exists() const { return fs::exists(file_); }

  testing::MovingPeaks target_;
  fs::path file_;
};

TEST_F(CacheSession, SavesWhenTheIntervalHasPassedAndNotBefore) {
  static_assert(WarmCacheSession::save_interval == std::chrono::minutes(10));
  const auto table = service(0);
  WarmCacheSession session = this->session(CacheMode::append, milliseconds(200));
  ASSERT_FALSE(session.open(*table));
  learn(*table, 0);
  WarmCacheSession patient = this->session(CacheMode::append, hours(1));
  patient.save_if_due(*table);
  EXPECT_FALSE(exists());
  EXPECT_EQ(patient.saved(), "not yet");

  std::this_thread::sleep_for(milliseconds(200));
  session.save_if_due(*table);
  EXPECT_EQ(encode_cache(saved()), encode_cache(table->snapshot()));
  EXPECT_EQ(session.saved(), "saved");

  // The next one counts from there, and keeps what has been learned since.
  learn(*table, 1);
  std::this_thread::sleep_for(milliseconds(200));
  session.save_if_due(*table);
  EXPECT_EQ(encode_cache(saved()), encode_cache(table->snapshot()));
  EXPECT_EQ(session.saved(), "merged");
}

TEST_F(CacheSession, FrozenAndScratchDoNotSaveOnTheWay) {
  for (const CacheMode mode : {CacheMode::frozen, CacheMode::scratch}) {
    const auto table = service(0);
    WarmCacheSession session = this->session(mode, milliseconds(0));
    ASSERT_FALSE(session.open(*table));
    learn(*table, 0);
    session.save_if_due(*table);
    EXPECT_FALSE(exists()) << cache_mode_name(mode);
    ASSERT_FALSE(session.save(*table));
    EXPECT_EQ(exists(), mode == CacheMode::scratch);
  }
}

TEST_F(CacheSession, AFailedSaveOnTheWayIsMadeGoodAtTheEnd) {
  fs::create_directory(path("disk"));
  file_ = path("disk/t.cache");
  const auto table = service(0);
  WarmCacheSession session = this->session(CacheMode::append, milliseconds(0));
  ASSERT_FALSE(session.open(*table));
  learn(*table, 0);
  fs::remove(path("disk"));
  session.save_if_due(*table);
  EXPECT_EQ(session.saved(), "failed");
  EXPECT_THAT(session.reason(), HasSubstr("t.cache"));
  fs::create_directory(path("disk"));
  ASSERT_FALSE(session.save(*table));
  EXPECT_EQ(session.saved(), "saved");
  EXPECT_EQ(session.reason(), "");
  EXPECT_EQ(encode_cache(saved()), encode_cache(table->snapshot()));
}

TEST_F(CacheSession, SessionsWithOtherSlicesKeepEachOthers) {
  const auto first = service(0), second = service(1);
  WarmCacheSession a = session(CacheMode::append), b = session(CacheMode::append);
  ASSERT_FALSE(a.open(*first));
  ASSERT_FALSE(b.open(*second));
  learn(*first, 0);
  learn(*second, 1);
  ASSERT_FALSE(a.save(*first));
  ASSERT_FALSE(b.save(*second));
  EXPECT_EQ(b.saved(), "merged");
  EXPECT_EQ(encode_cache(saved()), encode_cache(merge_caches(first->snapshot(), second->snapshot())));
  // Whoever comes next and uses one slice saves the other back.
  const auto third = service(1);
  WarmCacheSession c = session(CacheMode::require);
  ASSERT_FALSE(c.open(*third));
  EXPECT_EQ(c.rows_loaded(), b.rows_saved());
  learn(*third, 2);
  ASSERT_FALSE(c.save(*third));
  EXPECT_EQ(saved().slices.size(), 2u);
}

TEST_F(CacheSession, AFileThatGoesIsMadeAgainAndOneThatTurnsForeignIsLeftAlone) {
  const auto table = service(0);
  learn(*table, 0);
  ASSERT_FALSE(adaptive::save_cache(file_, table->snapshot()));
  const auto next = service(0);
  WarmCacheSession session = this->session(CacheMode::append);
  ASSERT_FALSE(session.open(*next));
  learn(*next, 1);

  fs::remove(file_);
  ASSERT_FALSE(session.save(*next));
  EXPECT_EQ(session.saved(), "saved");
  EXPECT_EQ(encode_cache(saved()), encode_cache(next->snapshot()));

  write_text(file_, "the notes of somebody, long enough for a header");
  EXPECT_FALSE(session.save(*next)) << "a refusal is reported, and is no failure to write";
  EXPECT_EQ(session.saved(), "refused");
  EXPECT_THAT(session.reason(), HasSubstr("magic"));
  EXPECT_EQ(read_text(file_), "the notes of somebody, long enough for a header");

  fs::remove(file_);
  ASSERT_FALSE(session.save(*next));
  EXPECT_EQ(session.saved(), "saved");
  EXPECT_EQ(session.reason(), "");
}

/// A child that saves while this process holds the lock, so that it is in the middle of its save until released.
class InterruptedSave : public CacheSession {
 protected:
  void SetUp() override {
    CacheSession::SetUp();
    table_ = service(0);
    learn(*table_, 0);  // before the fork: oneTBB's threads do not outlive it
    ASSERT_FALSE(adaptive::save_cache(file_, TableSnapshot{model, {}}));
    before_ = read_text(file_);
    lock_ = ::open((file_.string() + ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    ASSERT_EQ(::flock(lock_, LOCK_EX), 0);
    int pipe_ends[2];
    ASSERT_EQ(::pipe(pipe_ends), 0);
    child_ = ::fork();
    ASSERT_GE(child_, 0);
    if (child_ == 0) {
      ::close(lock_);
      const cli::InterruptGuard guard;
      WarmCacheSession session = this->session(CacheMode::append);
      if (::write(pipe_ends[1], "s", 1) != 1) ::_exit(1);
      const auto error = session.save(*table_);
      ::_exit(error ? 1 : guard.exit_status());
    }
    ::close(pipe_ends[1]);
    char byte = 0;
    ASSERT_EQ(::read(pipe_ends[0], &byte, 1), 1);
    ::close(pipe_ends[0]);
    interrupt();
    EXPECT_EQ(::waitpid(child_, nullptr, WNOHANG), 0) << "the first signal must not stop a save";
  }
  void interrupt() const {
    std::this_thread::sleep_for(milliseconds(50));
    ::kill(child_, SIGINT);
    std::this_thread::sleep_for(milliseconds(50));
  }
  int wait() const {
    int status = 0;
    EXPECT_EQ(::waitpid(child_, &status, 0), child_);
    return status;
  }

  std::unique_ptr<Service> table_;
  std::string before_;
  int lock_ = -1;
  pid_t child_ = -1;
};

TEST_F(InterruptedSave, TheFirstSignalLetsItFinish) {
  ::close(lock_);
  const int status = wait();
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 128 + SIGINT);
  EXPECT_EQ(encode_cache(saved()), encode_cache(table_->snapshot()));
}

TEST_F(InterruptedSave, TheSecondSignalEndsItAndTheFileStaysWhole) {
  interrupt();
  const int status = wait();
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGINT);
  EXPECT_EQ(read_text(file_), before_);
  ::close(lock_);
  WarmCacheSession session = this->session(CacheMode::append);
  ASSERT_FALSE(session.save(*table_));
  EXPECT_EQ(encode_cache(saved()), encode_cache(table_->snapshot()));
  EXPECT_FALSE(fs::exists(file_.string() + ".lock"));
}

}  // namespace
}  // namespace tress::test
