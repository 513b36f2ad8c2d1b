#include "base/save_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace tress::inline v0_2 {
namespace {

/// Opens the lock for writing if that is allowed, because NFS requires it; otherwise (another user's lock file) for
/// reading.
int open_lock(const std::filesystem::path& path) {
  constexpr int flags = O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
  const int number = ::open(path.c_str(), O_RDWR | O_CREAT | flags, 0666);
  if (number >= 0 || errno != EACCES) return number;
  const int readable = ::open(path.c_str(), O_RDONLY | flags);
  if (readable < 0) errno = EACCES;  // that there is no file is no reason: it could not be made
  return readable;
}

}  // namespace

std::optional<Error> SaveLock::acquire(const std::filesystem::path& file, const std::string& name) {
  path_ = file;
  path_ += ".lock";
  do {
    do {
      opened_.reset(open_lock(path_));
    } while (!opened_.is_open() && (errno == EINTR || errno == ESTALE));
    if (!opened_.is_open()) {
      return Error{name, "lock " + path_.string(), "a lock file that can be opened", strerror(errno)};
    }
    int failed = 0;
    while ((failed = ::flock(opened_.number(), LOCK_EX)) != 0 && errno == EINTR) {
    }
    held_ = failed == 0;
    // The previous holder removed the file before it released the lock, so this is the lock of a file without a name.
  } while (held_ && !is_still_there());
  return std::nullopt;
}

SaveLock::~SaveLock() {
  // Removes the file while the lock is held, so that no other process locks a file that is about to lose its name.
  if (opened_.is_open() && is_still_there()) ::unlink(path_.c_str());
}

bool SaveLock::is_still_there() const {
  struct stat opened{}, named{};
  return ::fstat(opened_.number(), &opened) == 0 && ::lstat(path_.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace tress::inline v0_2
