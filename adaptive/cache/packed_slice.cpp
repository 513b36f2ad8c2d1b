#include "cache/packed_slice.h"

#include <algorithm>
#include <cstring>

namespace tress::inline v0_2::adaptive {

void GrowingBytes::append(std::string_view bytes) {
  while (!bytes.empty()) {
    if (pieces_.empty() || pieces_.back().size() == piece) pieces_.emplace_back();
    std::string& last = pieces_.back();
    const std::string_view taken = bytes.substr(0, piece - last.size());
    const std::size_t wanted = last.size() + taken.size();
    // A slice of few rows takes little memory. A growing string at least doubles its capacity, so the whole piece is
    // reserved well before the string would exceed it.
    if (wanted > piece / 4) last.reserve(piece);
    last.append(taken);
    bytes.remove_prefix(taken.size());
  }
}

std::size_t GrowingBytes::size() const {
  return pieces_.empty() ? 0 : (pieces_.size() - 1) * piece + pieces_.back().size();
}

bool GrowingBytes::read(std::size_t offset, char* to, std::size_t size) const {
  if (offset > this->size() || size > this->size() - offset) return false;
  while (size > 0) {
    const std::string_view from = std::string_view(pieces_[offset / piece]).substr(offset % piece, size);
    std::memcpy(to, from.data(), from.size());
    offset += from.size();
    to += from.size();
    size -= from.size();
  }
  return true;
}

void PackedSlice::add(const CachedRow& row) {
  ByteWriter out;
  format::write_row(out, row);
  table_.append(out.bytes());
  ++rows_;
  if (row.state == RowState::converged) return;
  out.clear();
  format::write_sketch(out, row);
  sketches_.append(out.bytes());
}

void PackedSlice::write(ByteWriter& out) const {
  out.u32(rows_);
  for (const GrowingBytes* bytes : {&table_, &sketches_}) {
    out.u64(bytes->size());
    bytes->append_to(out);
  }
}

bool PackedSlice::read(ByteReader& in) {
  rows_ = in.u32();
  for (GrowingBytes* bytes : {&table_, &sketches_}) {
    std::uint64_t left = in.u64();
    if (in.short_of_bytes() || left > in.remaining()) return false;
    while (left > 0) {
      const std::string_view taken = in.text(std::min<std::uint64_t>(left, ByteReader::largest_buffer));
      if (taken.empty()) return false;
      bytes->append(taken);
      left -= taken.size();
    }
  }
  return rows_ <= table_.size() / format::row_bytes;
}

const SliceDescription* PackedSliceRows::next_slice() {
  if (reader_) return nullptr;
  reader_.emplace(slice_.table_, "");
  reader_->begin_rows(slice_.description_, slice_.rows_, slice_.table_, slice_.sketches_);
  return &slice_.description_;
}

}  // namespace tress::inline v0_2::adaptive
