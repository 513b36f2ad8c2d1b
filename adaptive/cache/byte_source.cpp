#include "cache/byte_source.h"

#include <unistd.h>

#include <cerrno>

namespace tress::inline v0_2::adaptive {

bool FileBytes::read(std::size_t offset, char* to, std::size_t size) const {
  while (size > 0) {
    const ssize_t step = ::pread(descriptor_, to, size, static_cast<off_t>(offset));
    if (step < 0 && errno == EINTR) continue;
    if (step <= 0) return false;
    offset += static_cast<std::size_t>(step);
    to += step;
    size -= static_cast<std::size_t>(step);
  }
  return true;
}

bool ByteReader::fill(std::size_t size) {
  if (size > remaining() || size > largest_buffer || unreadable_) return false;
  buffer_.erase(0, begin_);
  begin_ = 0;
  const std::size_t old = buffer_.size();
  const std::size_t more = std::min(largest_buffer - old, end_ - next_);
  buffer_.resize(old + more);
  if (!bytes_->read(next_, buffer_.data() + old, more)) {
    buffer_.resize(old);
    unreadable_ = true;
    return false;
  }
  next_ += more;
  return true;
}

}  // namespace tress::inline v0_2::adaptive
