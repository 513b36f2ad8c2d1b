// Any bytes as a warm cache: refused with a reason, or a table that saves to the very bytes it was read from (but for
// rows of knots), is merged with itself to itself, and whose every fit is a density; row by row as well, and where the
// file fails or is written into while its rows are read.
#include <algorithm>
#include <cmath>

#include "base/content_hash.h"
#include "cache/byte_source.h"
#include "cache/bytes.h"
#include "cache/format.h"
#include "cache/reader.h"
#include "fuzz/fuzz.h"
#include "tress/adaptive/cache.h"

namespace {

using namespace tress;

std::uint64_t read(const std::string& bytes, std::size_t at, std::size_t size) {
  const adaptive::MemoryBytes source(bytes);
  adaptive::ByteReader reader(&source, at, bytes.size() - at);
  return size == 4 ? reader.u32() : reader.u64();
}

void write(std::string* bytes, std::size_t at, std::uint64_t value) {
  adaptive::ByteWriter writer;
  writer.u64(value);
  bytes->replace(at, 8, writer.bytes());
}

/// Sets every checksum and the hash of the model to what they should be, so that what lies behind them is reached.
void seal(std::string* bytes) {
  std::size_t at = adaptive::format::header_bytes;
  for (std::uint32_t section = 0; at + adaptive::format::section_header_bytes <= bytes->size(); ++section) {
    const std::size_t payload = at + adaptive::format::section_header_bytes;
    const std::size_t size = std::min<std::uint64_t>(read(*bytes, at + 8, 8), bytes->size() - payload);
    const std::string content = bytes->substr(payload, size);
    if (section == 0 && size >= 4) {
      const std::size_t length = std::min<std::uint64_t>(read(content, 0, 4), size - 4);
      write(bytes, 16, adaptive::model_hash(content.substr(4, length)));
    }
    write(bytes, at + 16, content_hash(content));
    at = payload + size;
  }
}

/// Bytes that somebody cuts or writes into while they are read.
class UnstableBytes final : public adaptive::ByteSource {
 public:
  explicit UnstableBytes(const std::string& bytes) : now(bytes), size_(bytes.size()) {}
  std::size_t size() const override { return size_; }
  bool read(std::size_t offset, char* to, std::size_t size) const override {
    if (offset > now.size() || size > now.size() - offset) return false;
    now.copy(to, size, offset);
    return true;
  }
  std::string now;

 private:
  std::size_t size_;
};

/// Good bytes, row by row.
void check_rows(const std::string& bytes) {
  const adaptive::MemoryBytes source(bytes);
  adaptive::CacheReader one(source, "some.cache"), other(source, "some.cache");
  fuzz::require(one.check("") && other.check(""));
  adaptive::MergedRows both(one, other);
  fuzz::require(adaptive::format::cache_bytes(both) == bytes);

  const std::size_t at = content_hash(bytes) % bytes.size();
  UnstableBytes cut(bytes), changed(bytes);
  adaptive::CacheReader from_cut(cut, "some.cache"), from_changed(changed, "some.cache");
  fuzz::require(from_cut.check("") && from_changed.check(""));
  cut.now.resize(at);
  changed.now[at] = static_cast<char>(~changed.now[at]);
  if (adaptive::format::cache_bytes(from_cut).empty()) fuzz::require(from_cut.failure().has_value());
  const std::string others = adaptive::format::cache_bytes(from_changed);
  fuzz::require(others.empty() ? from_changed.failure().has_value() : others.size() <= bytes.size());
}

/// Whether good bytes have rows of knots, which are left out when they are read.
bool has_knots(const std::string& bytes) {
  const adaptive::MemoryBytes source(bytes);
  adaptive::CacheReader reader(source, "some.cache");
  fuzz::require(reader.check(""));
  return reader.contents().knot_rows > 0;
}

void check(const std::string& bytes) {
  const Result<adaptive::TableSnapshot> image = adaptive::decode_cache(bytes, "", "some.cache");
  if (!image) {
    fuzz::require_message(image, "some.cache");
    return;
  }
  const std::string again = adaptive::encode_cache(*image);
  if (has_knots(bytes)) {
    fuzz::require(!has_knots(again));
    return check(again);
  }
  fuzz::require(again == bytes);
  fuzz::require(adaptive::encode_cache(adaptive::merge_caches(*image, *image)) == again);
  check_rows(bytes);
  for (const adaptive::CachedSlice& slice : image->slices) {
    for (const adaptive::CachedRow& row : slice.rows) {
      for (const float x : {-3.14159265f, 0.0f, 1.0f}) {
        const float density = row.density() != nullptr ? row.density()->fit.density(x)
                              : row.ribbons() != nullptr
                                  ? row.ribbons()->ribbon(row.ribbons()->parts() - 1).density(x, 0.1f)
                                  : 0;
        fuzz::require(std::isfinite(density) && density >= 0);
      }
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string bytes(reinterpret_cast<const char*>(data), size);
  check(bytes);
  if (bytes.size() >= adaptive::format::header_bytes) {
    seal(&bytes);
    check(bytes);
  }
  return 0;
}
