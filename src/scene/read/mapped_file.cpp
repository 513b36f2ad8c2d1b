#include "scene/read/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <system_error>
#include <utility>

#include "scene/read/input_files.h"

namespace tress::scene {

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
  if (data_) ::munmap(const_cast<unsigned char*>(data_), size_);
}

}  // namespace tress::scene
