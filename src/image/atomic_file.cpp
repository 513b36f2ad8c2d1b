#include "image/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

namespace tress::image {
namespace {

Error could_not_write(const std::filesystem::path& file, const std::string& why) {
  return Error{file.string(), "", "a file that can be written", why};
}

}  // namespace

std::filesystem::path temporary_beside(const std::filesystem::path& file) {
  static std::atomic<unsigned> counter{0};
  std::filesystem::path name = file;
  name += fmt::format(".{}.{}.tmp", static_cast<long>(getpid()), counter++);
  return name;
}

std::optional<Error> publish_file(const std::filesystem::path& temporary, const std::filesystem::path& file) {
  const auto fail = [&](const std::string& why) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    return could_not_write(file, why);
  };
  const int descriptor = open(temporary.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return fail(std::strerror(errno));
  const bool flushed = fsync(descriptor) == 0;
  const int flush_errno = errno;
  close(descriptor);
  if (!flushed) return fail(std::strerror(flush_errno));
  std::error_code code;
  std::filesystem::rename(temporary, file, code);
  if (code) return fail(code.message());
  return std::nullopt;
}

std::optional<Error> write_file_atomically(const std::filesystem::path& file, const std::string& bytes) {
  const auto temporary = temporary_beside(file);
  {
    errno = 0;
    std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) {
      const std::string why = errno ? std::strerror(errno) : "a write error";
      std::error_code ignored;
      std::filesystem::remove(temporary, ignored);
      return could_not_write(file, why);
    }
  }
  return publish_file(temporary, file);
}

}  // namespace tress::image
