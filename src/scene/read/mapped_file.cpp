#include "scene/read/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <system_error>
#include <utility>

#include "scene/read/input_files.h"

namespace tress::scene {
namespace {

/// The data that a signal handler may read; written while the entry is not in use.
struct Mapping {
  std::atomic<bool> is_taken = false;
  std::atomic<const unsigned char*> begin = nullptr;  ///< if not null, the other members are complete
  std::size_t size = 0;
  std::array<char, 1024> name{};
};
std::array<Mapping, 16> mappings;

void note_mapping(const unsigned char* data, std::size_t size, const std::string& name) {
  for (Mapping& mapping : mappings) {
    if (mapping.is_taken.exchange(true)) continue;
    mapping.size = size;
    mapping.name.fill(0);
    std::copy_n(name.begin(), std::min(name.size(), mapping.name.size() - 1), mapping.name.begin());
    mapping.begin = data;
    return;
  }
}

void forget_mapping(const unsigned char* data) {
  for (Mapping& mapping : mappings)
    if (mapping.begin == data) {
      mapping.begin = nullptr;
      mapping.is_taken = false;
      return;
    }
}

}  // namespace

const char* name_of_mapping(const void* address) {
  for (const Mapping& mapping : mappings) {
    const unsigned char* begin = mapping.begin;
    const auto* at = static_cast<const unsigned char*>(address);
    if (begin != nullptr && at >= begin && at < begin + mapping.size) return mapping.name.data();
  }
  return nullptr;
}

Result<MappedFile> MappedFile::open(const std::filesystem::path& file, const std::string& what,
                                    std::uintmax_t most_bytes) {
  const auto size = input_file_size(file, what, most_bytes);
  if (!size) return size.error();
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return Error{file.string(), "", what, "a file that cannot be opened"};
  void* data = ::mmap(nullptr, *size, PROT_READ, MAP_PRIVATE, descriptor, 0);
  ::close(descriptor);
  if (data == MAP_FAILED) return Error{file.string(), "", what, "a file that cannot be read"};
  ::madvise(data, *size, MADV_SEQUENTIAL);
  note_mapping(static_cast<const unsigned char*>(data), *size, file.string());
  return MappedFile(static_cast<const unsigned char*>(data), *size);
}

void MappedFile::let_go(std::span<const unsigned char> part) const {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const auto offset = static_cast<std::size_t>(part.data() - data_);
  const std::size_t begin = (offset + page - 1) / page * page, end = (offset + part.size()) / page * page;
  if (begin < end) ::madvise(const_cast<unsigned char*>(data_) + begin, end - begin, MADV_DONTNEED);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

MappedFile::~MappedFile() {
  if (data_) forget_mapping(data_);
  if (data_) ::munmap(const_cast<unsigned char*>(data_), size_);
}

}  // namespace tress::scene
