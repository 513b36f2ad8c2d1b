// The bytes of a file, without a copy of them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "tress/base/error.h"

namespace tress::scene {

/// A regular file of at least one byte, mapped for reading. Pages are read on access and belong to the file cache, not
/// to the memory of the process. If another process truncates the file, access raises SIGBUS, as with every mapping;
/// name_of_mapping() gives a handler its name. Movable, one owner.
class MappedFile {
 public:
  /// `what` completes "expected ...". Never waits on pipes or devices.
  static Result<MappedFile> open(const std::filesystem::path& file, const std::string& what, std::uintmax_t most_bytes);

  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  ~MappedFile();

  std::span<const unsigned char> bytes() const { return {data_, size_}; }
  /// Releases the whole pages within these bytes, so that a large file that is read from front to back does not count
  /// as memory. They are read again on the next access.
  void let_go(std::span<const unsigned char> part) const;

 private:
  MappedFile(const unsigned char* data, std::size_t size) : data_(data), size_(size) {}

  const unsigned char* data_;
  std::size_t size_;
};

/// The name of the file that is mapped at this address; null if no file is. Safe in a signal handler. It covers the
/// sixteen files that were mapped first.
const char* name_of_mapping(const void* address);

}  // namespace tress::scene
