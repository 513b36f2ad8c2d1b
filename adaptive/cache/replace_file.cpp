#include "cache/replace_file.h"

#include <fcntl.h>
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

#include "cache/descriptor.h"

namespace tress::adaptive {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view temporary_mark = ".tmp-";  // then the process, "-" and a serial number

/// A name beside `file` that no other thread or process takes: created exclusively. -1 on failure.
int create_beside(const fs::path& file, fs::path* temporary) {
  static std::atomic<std::uint32_t> serial{0};
  for (int attempt = 0; attempt < 100; ++attempt) {
    *temporary = file;
    *temporary += temporary_mark;
    *temporary += std::to_string(::getpid()) + "-" + std::to_string(serial.fetch_add(1));
    const int number = ::open(temporary->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (number >= 0 || errno != EEXIST) return number;
  }
  return -1;
}

bool write_all(int descriptor, const std::string& bytes) {
  std::size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t step = ::write(descriptor, bytes.data() + written, bytes.size() - written);
    if (step < 0 && errno == EINTR) continue;
    if (step < 0) return false;
    written += static_cast<std::size_t>(step);
  }
  return true;
}

bool flush_folder(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened.is_open()) return false;
  // Some file systems cannot flush a folder and say EINVAL: the rename is then as durable as they make it.
  return ::fsync(opened.number()) == 0 || errno == EINVAL;
}

/// Whether `name` is that of a temporary file of `file`.
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

}  // namespace

std::optional<Error> replace_file(const fs::path& target, const std::string& bytes, const std::string& name) {
  const auto system_error = [&](const char* expected) { return Error{name, "", expected, strerror(errno)}; };
  fs::path temporary;
  Descriptor opened(create_beside(target, &temporary));
  if (!opened.is_open()) return system_error("a folder that can be written to");
  if (struct stat old{}; ::stat(target.c_str(), &old) == 0) (void)!::fchmod(opened.number(), old.st_mode & 0777);
  const bool renamed = write_all(opened.number(), bytes) && ::fsync(opened.number()) == 0 && opened.close() &&
                       ::rename(temporary.c_str(), target.c_str()) == 0;
  if (!renamed) {
    const Error error = system_error("room for the file");
    ::unlink(temporary.c_str());
    return error;
  }
  if (!flush_folder(target)) return system_error("a folder that can be flushed");
  return std::nullopt;
}

std::vector<fs::path> remove_leftovers(const fs::path& target) {
  std::vector<fs::path> removed;
  std::error_code error;
  const fs::file_time_type now = fs::last_write_time(target, error);
  if (error) return removed;
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code gone;
    if (!is_temporary_of(entry->path().filename().string(), target.filename().string())) continue;
    if (entry->symlink_status(gone).type() != fs::file_type::regular || gone) continue;
    const fs::file_time_type written = entry->last_write_time(gone);
    if (gone || now - written < std::chrono::minutes(1)) continue;
    if (fs::remove(entry->path(), gone)) removed.push_back(entry->path());
  }
  std::ranges::sort(removed);
  return removed;
}

}  // namespace tress::adaptive
