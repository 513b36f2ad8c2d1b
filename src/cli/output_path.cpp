#include "cli/output_path.h"

#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace tress::cli {

std::optional<Error> check_output(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return Error{file.string(), "", "a file to write", "a folder"};
  const std::filesystem::path parent = file.parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  if (!std::filesystem::is_directory(folder, ignored)) {
    return Error{file.string(), "folder " + folder, "a folder that can be written", "no such folder"};
  }
  std::string probe = folder + "/.tress-XXXXXX";
  const int descriptor = mkstemp(probe.data());
  if (descriptor < 0) {
    return Error{file.string(), "folder " + folder, "a folder that can be written", std::strerror(errno)};
  }
  close(descriptor);
  unlink(probe.c_str());
  return std::nullopt;
}

}  // namespace tress::cli
