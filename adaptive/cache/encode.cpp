#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/content_hash.h"
#include "cache/format.h"

namespace tress::inline v0_2::adaptive {
namespace format {

std::uint32_t version_of(const SliceDescription& slice) {
  if (slice.kind != SliceKind::samples) return version_of_mixtures;
  return slice.key.used_parameters().size() > SliceKey::usual_parameters ? version_of_parameters : version_of_samples;
}

void write_description(ByteWriter& out, const SliceDescription& slice, std::uint32_t version) {
  const bool has_kind = version >= version_of_samples;
  out.u32(slice.key.lobe);
  if (has_kind) out.u32(static_cast<std::uint32_t>(slice.kind));
  for (std::size_t i = 0; i < stored_parameters(version); ++i) out.f32(slice.key.parameters[i]);
  out.f32(slice.kind == SliceKind::density ? slice.blur_rad : 0.0f);
  out.u32(static_cast<std::uint32_t>(slice.axis_a.size()));
  out.u32(static_cast<std::uint32_t>(slice.axis_b.size()));
  for (const float coordinate : slice.axis_a) out.f32(coordinate);
  for (const float coordinate : slice.axis_b) out.f32(coordinate);
}

void write_row(ByteWriter& out, const CachedRow& row) {
  const bool converged = row.state == RowState::converged;
  out.u32(row.node);
  out.u8(static_cast<std::uint8_t>(converged ? RowState::converged : RowState::open));
  const RibbonRow* ribbons = converged ? row.ribbons() : nullptr;
  const Mixture fit = converged && row.density() != nullptr ? row.density()->fit : Mixture{};
  out.u8(static_cast<std::uint8_t>(ribbons != nullptr ? ribbons->parts() : fit.component_count));
  out.u8(static_cast<std::uint8_t>(ribbons != nullptr ? Kind::ribbons : Kind::mixture));
  out.u8(0);
  out.u32(row.generation);
  out.f32(row.energy);
  out.f32(converged ? row.objective : 0.0f);
  out.u64(row.count);
  if (!converged) return;
  if (ribbons != nullptr) {
    for (const float mass : ribbons->masses()) out.f32(mass);
    const std::span<const std::byte> packed = ribbons->packed();
    out.text({reinterpret_cast<const char*>(packed.data()), packed.size()});
    return;
  }
  out.f32(fit.uniform_weight);
  out.f32(fit.uniform_attribute_mean);
  out.f32(fit.uniform_attribute_variance);
  for (const Component& part : fit.parts()) {
    out.f32(part.shape.mu);
    out.f32(part.shape.s_left);
    out.f32(part.shape.s_right);
    out.f32(part.weight);
    out.f32(part.attribute_mean);
    out.f32(part.attribute_variance);
  }
}

void write_sketch(ByteWriter& out, const CachedRow& row) {
  const auto sketch = row.density() != nullptr ? std::span(row.density()->sketch) : std::span<const SketchBin>();
  out.u32(static_cast<std::uint32_t>(sketch.size()));
  for (const SketchBin& bin : sketch) {
    out.u32(bin.index);
    out.u64(bin.bits);
  }
}

namespace {

/// The counts that stand in the file before the rows.
struct Counts {
  std::vector<std::uint32_t> rows;  ///< number of rows of each slice
  std::uint32_t version = version_of_mixtures;
};

Counts count(RowSource& rows) {
  Counts counts;
  rows.rewind();
  while (const SliceDescription* slice = rows.next_slice()) {
    counts.version = std::max(counts.version, version_of(*slice));
    std::uint32_t number = 0;
    while (rows.next_row() != nullptr) ++number;
    counts.rows.push_back(number);
  }
  return counts;
}

/// The payload of a section, which goes to a sink in pieces.
class Payload {
 public:
  static constexpr std::size_t piece = std::size_t{32} << 10;
  explicit Payload(ByteSink take) : take_(std::move(take)) {}
  ByteWriter& writer() { return writer_; }
  /// Call it after each piece of work, and with 1 at the end. False if there is no room.
  bool flush(std::size_t at_least = piece) {
    if (writer_.bytes().size() < at_least) return true;
    const bool taken = take_(writer_.bytes());
    writer_.clear();
    return taken;
  }

 private:
  ByteSink take_;
  ByteWriter writer_;
};

struct Measured {
  std::uint64_t size = 0;
  ContentHash hash;
  Payload payload{[this](std::string_view bytes) {
    size += bytes.size();
    hash.add(bytes);
    return true;
  }};
};

/// Writes the payloads of the last three sections; a null one is left out. False if one has no room, or the rows are
/// not those that were counted.
bool write_payloads(RowSource& rows, const Counts& counts, Payload* slices, Payload* table, Payload* sketches) {
  rows.rewind();
  std::size_t at = 0;
  if (slices != nullptr) slices->writer().u32(static_cast<std::uint32_t>(counts.rows.size()));
  while (const SliceDescription* slice = rows.next_slice()) {
    if (at == counts.rows.size()) return false;
    if (slices != nullptr) write_description(slices->writer(), *slice, counts.version);
    if (slices != nullptr && !slices->flush()) return false;
    if (table != nullptr) table->writer().u32(counts.rows[at]);
    std::uint32_t left = counts.rows[at++];
    while (const CachedRow* row = rows.next_row()) {
      if (left-- == 0) return false;
      if (table != nullptr) write_row(table->writer(), *row);
      if (table != nullptr && !table->flush()) return false;
      if (row->state == RowState::converged) continue;
      if (sketches != nullptr) write_sketch(sketches->writer(), *row);
      if (sketches != nullptr && !sketches->flush()) return false;
    }
    if (left != 0) return false;
  }
  for (Payload* payload : {slices, table, sketches}) {
    if (payload != nullptr && !payload->flush(1)) return false;
  }
  return at == counts.rows.size() && !rows.failure();
}

void write_frame(ByteWriter& out, Section id, std::uint64_t size, std::uint64_t sum) {
  out.u32(static_cast<std::uint32_t>(id));
  out.u32(0);
  out.u64(size);
  out.u64(sum);
}

}  // namespace

std::string described(const SliceDescription& slice) {
  ByteWriter out;
  write_description(out, slice, std::max(version_of_samples, version_of(slice)));
  return out.take();
}

bool write_cache(RowSource& rows, const ByteSink& out) {
  const Counts counts = count(rows);
  Measured slices, table, sketches;
  if (rows.failure() || !write_payloads(rows, counts, &slices.payload, &table.payload, &sketches.payload)) return false;
  ByteWriter model;
  model.u32(static_cast<std::uint32_t>(rows.model().size()));
  model.text(rows.model());

  Payload payload(out);
  ByteWriter& head = payload.writer();
  head.text(magic);
  head.u32(counts.version);
  head.u32(section_count);
  head.u64(model_hash(rows.model()));
  write_frame(head, Section::model, model.bytes().size(), content_hash(model.bytes()));
  head.text(model.bytes());
  write_frame(head, Section::slices, slices.size, slices.hash.value());
  if (!write_payloads(rows, counts, &payload, nullptr, nullptr)) return false;
  write_frame(head, Section::rows, table.size, table.hash.value());
  if (!write_payloads(rows, counts, nullptr, &payload, nullptr)) return false;
  write_frame(head, Section::sketches, sketches.size, sketches.hash.value());
  return write_payloads(rows, counts, nullptr, nullptr, &payload);
}

std::string cache_bytes(RowSource& rows) {
  std::string all;
  const bool is_whole = write_cache(rows, [&all](std::string_view bytes) {
    all.append(bytes);
    return true;
  });
  return is_whole ? std::move(all) : std::string();
}

}  // namespace format

namespace {

// The rules of the service that define g and a sketch. The host's rules are in the model's name.
constexpr std::string_view rules =
    "node rule 1: g at the grid node; blur 1: wrapped Gaussian; axis rule 1: ascending coordinates, node = a * nb + b; "
    "sketch rule 1: max(128, ceil(12 pi / sigma)) bins, minimum of |offset| 31, sign 1, float g 32";

}  // namespace

std::uint64_t model_hash(const std::string& model) {
  std::string text = model;
  text.push_back('\0');
  text.append(rules);
  return content_hash(text);
}

std::size_t cached_bytes(const SliceDescription& slice, std::uint32_t format) {
  ByteWriter out;
  format::write_description(out, slice, format);
  return out.bytes().size() + sizeof(std::uint32_t);  // plus the number of its rows
}

std::size_t cached_bytes(const CachedRow& row) {
  ByteWriter out;
  format::write_row(out, row);
  if (row.state != RowState::converged) format::write_sketch(out, row);
  return out.bytes().size();
}

std::string encode_cache(const TableSnapshot& image) {
  SnapshotRows rows(image);
  return format::cache_bytes(rows);
}

std::string cache_hash(RowSource& rows) {
  ContentHash hash;
  const auto add = [&hash](std::string_view bytes) {
    hash.add(bytes);
    return true;
  };
  return format::write_cache(rows, add) ? hexadecimal(hash.value()) : std::string();
}

std::string cache_hash(const TableSnapshot& image) {
  SnapshotRows rows(image);
  return cache_hash(rows);
}

}  // namespace tress::inline v0_2::adaptive
