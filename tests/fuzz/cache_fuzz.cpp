// Any bytes as a warm cache: refused with a reason, or a table that saves to the very bytes it was read from, is merged
// with itself to itself, and whose every fit is a density.
#include <algorithm>
#include <cmath>

#include "cache/bytes.h"
#include "cache/format.h"
#include "fuzz/fuzz.h"
#include "tress/adaptive/cache.h"

namespace {

using namespace tress;

std::uint64_t read(const std::string& bytes, std::size_t at, std::size_t size) {
  adaptive::ByteReader reader(bytes, 0);
  reader.text(at);
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
    write(bytes, at + 16, adaptive::format::checksum(content));
    at = payload + size;
  }
}

void check(const std::string& bytes) {
  const Result<adaptive::TableSnapshot> image = adaptive::decode_cache(bytes, "", "some.cache");
  if (!image) {
    fuzz::require_message(image, "some.cache");
    return;
  }
  const std::string again = adaptive::encode_cache(*image);
  fuzz::require(again == bytes);
  fuzz::require(adaptive::encode_cache(adaptive::merge_caches(*image, *image)) == again);
  for (const adaptive::CachedSlice& slice : image->slices) {
    for (const adaptive::CachedRow& row : slice.rows) {
      for (const float x : {-3.14159265f, 0.0f, 1.0f}) {
        const float density = row.knots.empty() ? row.fit.density(x) : row.knots.density(x);
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
