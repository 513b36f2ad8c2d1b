#include "tress/base/replace_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <system_error>

#include "base/descriptor.h"
#include "base/file_replacement.h"

namespace tress::inline v0_2 {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view temporary_mark = ".tmp-";  // followed by the process id, "-" and a serial number

/// Makes a file beside `file` under a name that no other thread or process has, since it is created exclusively.
/// Returns -1 on failure.
int create_beside(const fs::path& file, fs::path* temporary) {
  static std::atomic<std::uint32_t> serial{0};
  for (int attempt = 0; attempt < 100; ++attempt) {
    *temporary = file;
    *temporary += temporary_mark;
    *temporary += std::to_string(::getpid()) + "-" + std::to_string(serial.fetch_add(1));
    const int number = ::open(temporary->c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (number >= 0 || errno != EEXIST) return number;
  }
  return -1;
}

bool write_all(int descriptor, std::string_view bytes) {
  std::size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t step = ::write(descriptor, bytes.data() + written, bytes.size() - written);
    if (step < 0 && errno == EINTR) continue;
    if (step < 0) return false;
    written += static_cast<std::size_t>(step);
  }
  return true;
}

fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

bool flush_folder(const fs::path& file) {
  const Descriptor opened(::open(folder_of(file).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened.is_open()) return false;
  // Some file systems cannot flush a folder and return EINVAL: the rename is then as durable as they make it.
  return ::fsync(opened.number()) == 0 || errno == EINVAL;
}

/// Sets mode and owner as they were. If the group cannot be kept, the new group gets no more rights than others.
void keep_permissions(int descriptor, const struct stat& old) {
  mode_t mode = old.st_mode & 0777;
  const bool kept = ::fchown(descriptor, old.st_uid, old.st_gid) == 0 ||
                    ::fchown(descriptor, static_cast<uid_t>(-1), old.st_gid) == 0;
  if (!kept) mode = (mode & ~mode_t{0070}) | (mode & 0070 & ((mode & 0007) << 3));
  (void)!::fchmod(descriptor, mode);
}

/// Whether `name` is the name of a temporary file of `file`.
bool is_temporary_of(const std::string& name, const std::string& file) {
  if (!name.starts_with(file) || !std::string_view(name).substr(file.size()).starts_with(temporary_mark)) return false;
  const std::string numbers = name.substr(file.size() + temporary_mark.size());
  const std::size_t dash = numbers.find('-');
  const auto digits = [](std::string_view text) {
    return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
  };
  return dash != std::string::npos && digits(std::string_view(numbers).substr(0, dash)) &&
         digits(std::string_view(numbers).substr(dash + 1));
}

/// A temporary file is locked while it is written; the kernel frees the lock of a killed process.
bool is_being_written(const fs::path& temporary) {
  const Descriptor opened(::open(temporary.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  return opened.is_open() && ::flock(opened.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

/// Returns an error if the target exists and is no regular file; otherwise its status, if there is one to keep.
std::optional<Error> check_kind(const fs::path& target, const std::string& name, std::optional<struct stat>* old) {
  struct stat status{};
  if (::stat(target.c_str(), &status) != 0) return std::nullopt;
  if (!S_ISREG(status.st_mode)) {
    return Error{name, "", "a file to write", S_ISDIR(status.st_mode) ? "a folder" : "a device, pipe or socket"};
  }
  *old = status;
  return std::nullopt;
}

}  // namespace

fs::path behind_links(const fs::path& file) {
  constexpr int most_links = 40;  // the kernel's limit
  fs::path path = file;
  for (int i = 0; i < most_links; ++i) {
    std::error_code error;
    if (!fs::is_symlink(path, error) || error) return path;
    const fs::path next = fs::read_symlink(path, error);
    if (error) return path;
    path = next.is_absolute() ? next : path.parent_path() / next;
  }
  return path;
}

Error FileReplacement::system_error(const char* expected) const { return {name_, "", expected, strerror(errno)}; }

std::optional<Error> FileReplacement::begin(const fs::path& file, const std::string& name) {
  name_ = name.empty() ? file.string() : name;
  target_ = behind_links(file);
  std::optional<struct stat> old;
  if (std::optional<Error> error = check_kind(target_, name_, &old)) return error;
  opened_.reset(create_beside(target_, &temporary_));
  if (!opened_.is_open()) return system_error("a folder that can be written to");
  (void)::flock(opened_.number(), LOCK_EX | LOCK_NB);
  if (old) keep_permissions(opened_.number(), *old);
  return std::nullopt;
}

std::optional<Error> FileReplacement::write(std::string_view bytes) {
  if (!write_all(opened_.number(), bytes)) return system_error("room for the file");
  return std::nullopt;
}

std::optional<Error> FileReplacement::finish() {
  const bool renamed =
      ::fsync(opened_.number()) == 0 && opened_.close() && ::rename(temporary_.c_str(), target_.c_str()) == 0;
  if (!renamed) {
    const Error error = system_error("room for the file");
    abandon();
    return error;
  }
  temporary_.clear();
  if (!flush_folder(target_)) return system_error("a folder that can be flushed");
  return std::nullopt;
}

void FileReplacement::abandon() {
  opened_.close();
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  temporary_.clear();
}

std::optional<Error> replace_file(const fs::path& file, const std::string& bytes, const std::string& name) {
  FileReplacement replacement;
  if (std::optional<Error> error = replacement.begin(file, name)) return error;
  if (std::optional<Error> error = replacement.write(bytes)) return error;
  return replacement.finish();
}

std::optional<Error> check_replaceable(const fs::path& file) {
  const fs::path target = behind_links(file);
  std::optional<struct stat> old;
  if (std::optional<Error> error = check_kind(target, file.string(), &old)) return error;
  fs::path temporary;
  const Descriptor opened(create_beside(target, &temporary));
  if (opened.is_open()) {
    ::unlink(temporary.c_str());
    return std::nullopt;
  }
  const std::string why = strerror(errno);
  if (errno == ENAMETOOLONG) {
    return Error{file.string(), "", "a name that leaves room for one of a temporary file beside it", why};
  }
  return Error{file.string(), "folder " + folder_of(target).string(), "a folder that can be written", why};
}

std::vector<fs::path> remove_leftovers(const fs::path& file) {
  std::vector<fs::path> removed;
  std::error_code error;
  const fs::path target = behind_links(file);
  const fs::file_time_type now = fs::last_write_time(target, error);
  if (error) return removed;
  for (fs::directory_iterator entry(folder_of(target), error), end; !error && entry != end; entry.increment(error)) {
    std::error_code gone;
    if (!is_temporary_of(entry->path().filename().string(), target.filename().string())) continue;
    if (entry->symlink_status(gone).type() != fs::file_type::regular || gone) continue;
    const fs::file_time_type written = entry->last_write_time(gone);
    // A minute either way: a clock may have been set back, and a time in the future does not make a file younger.
    if (gone || (now - written < std::chrono::minutes(1) && written - now < std::chrono::minutes(1))) continue;
    if (is_being_written(entry->path())) continue;
    if (fs::remove(entry->path(), gone)) removed.push_back(entry->path());
  }
  std::ranges::sort(removed);
  return removed;
}

}  // namespace tress::inline v0_2
