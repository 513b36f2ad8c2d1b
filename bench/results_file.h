// Where a benchmark leaves what it measured.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <optional>
#include <string>

#include "tress/base/error.h"
#include "tress/base/replace_file.h"

namespace tress::bench {

/// Writes the file whole; where it cannot, says why on stderr and leaves what was there. The exit status of the
/// program.
inline int write_results(const std::string& file, const std::string& text) {
  const std::optional<Error> error = replace_file(file, text);
  if (!error) return 0;
  fmt::print(stderr, "{}\n", error->message());
  return 1;
}

}  // namespace tress::bench
