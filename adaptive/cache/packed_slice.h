// The rows of a slice, packed as in a cache file, which takes a quarter of the memory of CachedRow. A session keeps the
// rows of a cache that it does not use yet in this form.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cache/byte_source.h"
#include "cache/bytes.h"
#include "cache/reader.h"
#include "tress/adaptive/cache.h"

namespace tress::inline v0_2::adaptive {

/// Bytes that grow without being copied, in pieces of 8 KB.
class GrowingBytes final : public ByteSource {
 public:
  void append(std::string_view bytes);
  std::size_t size() const override;
  bool read(std::size_t offset, char* to, std::size_t size) const override;
  void append_to(ByteWriter& out) const {
    for (const std::string& piece : pieces_) out.text(piece);
  }

 private:
  static constexpr std::size_t piece = 8192;
  std::vector<std::string> pieces_;  ///< all but the last are full
};

class PackedSlice {
 public:
  explicit PackedSlice(SliceDescription slice) : description_(std::move(slice)) {}

  /// The rows are in ascending order of node.
  void add(const CachedRow& row);
  const SliceDescription& description() const { return description_; }
  std::uint32_t rows() const { return rows_; }

  /// Calls `take` with each row. False if the rows have values that no cache may have.
  template <class Take>
  bool for_each(const Take& take) const {
    CacheReader reader(table_, "");
    reader.begin_rows(description_, rows_, table_, sketches_);
    while (const CachedRow* row = reader.next_row()) take(*row);
    return !reader.failure();
  }

  /// Write the rows as bytes and read them back; false if there are not enough bytes. Their values are checked when the
  /// rows are read.
  void write(ByteWriter& out) const;
  bool read(ByteReader& in);

 private:
  friend class PackedSliceRows;
  SliceDescription description_;
  std::uint32_t rows_ = 0;
  GrowingBytes table_, sketches_;
};

/// A packed slice as a table of one slice. The slice must outlive it and must not change.
class PackedSliceRows final : public RowSource {
 public:
  PackedSliceRows(const PackedSlice& slice, std::string model) : slice_(slice), model_(std::move(model)) {}
  const std::string& model() const override { return model_; }
  void rewind() override { reader_.reset(); }
  const SliceDescription* next_slice() override;
  const CachedRow* next_row() override { return reader_ ? reader_->next_row() : nullptr; }
  /// Set if the rows have values that no cache may have, so that they cannot be read back.
  std::optional<Error> failure() const override { return reader_ ? reader_->failure() : std::nullopt; }

 private:
  const PackedSlice& slice_;
  std::string model_;
  std::optional<CacheReader> reader_;
};

}  // namespace tress::inline v0_2::adaptive
