// A file that is replaced piece by piece: replace_file() for what is never whole in memory.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "base/descriptor.h"
#include "tress/base/error.h"

namespace tress {

/// begin(), any number of write(), finish(); what replace_file() promises holds. Without a finish() that succeeds the
/// old file is as it was and nothing is left beside it. One thread.
class FileReplacement {
 public:
  FileReplacement() = default;
  ~FileReplacement() { abandon(); }
  FileReplacement(const FileReplacement&) = delete;
  FileReplacement& operator=(const FileReplacement&) = delete;

  /// Makes the temporary file. `name`: what errors call the file, if not by `file`.
  std::optional<Error> begin(const std::filesystem::path& file, const std::string& name = {});
  /// Appends. Error if there is no room.
  std::optional<Error> write(std::string_view bytes);
  /// Of the temporary file, to read what was written.
  int descriptor() const { return opened_.number(); }
  /// Flushes the temporary file, puts it in the place of the old one and flushes the folder.
  std::optional<Error> finish();

 private:
  Error system_error(const char* expected) const;
  void abandon();

  std::string name_;
  std::filesystem::path target_, temporary_;  ///< temporary_ is empty when there is none to remove
  Descriptor opened_;
};

}  // namespace tress
