// Replaces a file like replace_file(), but piece by piece, for contents that are never whole in memory.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "base/descriptor.h"
#include "tress/base/error.h"

namespace tress::inline v0_2 {

/// Call begin(), any number of write(), then finish(); the guarantees of replace_file() hold. Unless finish() succeeds,
/// the old file is unchanged and nothing is left beside it. One thread.
class FileReplacement {
 public:
  FileReplacement() = default;
  ~FileReplacement() { abandon(); }
  FileReplacement(const FileReplacement&) = delete;
  FileReplacement& operator=(const FileReplacement&) = delete;

  /// Makes the temporary file. `name`: the name in errors, if not `file`.
  std::optional<Error> begin(const std::filesystem::path& file, const std::string& name = {});
  /// Appends the bytes. Error if there is no room.
  std::optional<Error> write(std::string_view bytes);
  /// The descriptor of the temporary file, for reading what was written.
  int descriptor() const { return opened_.number(); }
  /// Flushes the temporary file, replaces the old one by it and flushes the folder.
  std::optional<Error> finish();

 private:
  Error system_error(const char* expected) const;
  void abandon();

  std::string name_;
  std::filesystem::path target_, temporary_;  ///< temporary_ is empty if there is no file to remove
  Descriptor opened_;
};

}  // namespace tress::inline v0_2
