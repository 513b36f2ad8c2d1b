#include "cli/cache_output.h"

#include <system_error>

#include "cli/output_path.h"
#include "tress/adaptive/cache.h"

namespace tress::cli {

std::optional<Error> check_cache_output(const std::filesystem::path& file) {
  if (auto error = check_output(file)) return error;
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return std::nullopt;
  const auto there = adaptive::CacheFile::open(file, "");
  if (there) return std::nullopt;
  Error error = there.error();
  error.expected = "a new name, or a warm cache to replace: " + error.expected;
  return error;
}

}  // namespace tress::cli
