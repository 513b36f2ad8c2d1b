#include <xxhash.h>

#include "cache/format.h"

namespace tress::adaptive {
namespace format {

std::uint64_t checksum(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::string hexadecimal(std::uint64_t value) {
  std::string text(16, '0');
  for (int i = 0; i < 16; ++i) text[15 - i] = "0123456789abcdef"[value >> (4 * i) & 15];
  return text;
}

void write_description(ByteWriter& out, const SliceDescription& slice) {
  out.u32(slice.key.lobe);
  for (const float parameter : slice.key.parameters) out.f32(parameter);
  out.f32(slice.blur_rad);
  out.u32(static_cast<std::uint32_t>(slice.axis_a.size()));
  out.u32(static_cast<std::uint32_t>(slice.axis_b.size()));
  for (const float coordinate : slice.axis_a) out.f32(coordinate);
  for (const float coordinate : slice.axis_b) out.f32(coordinate);
}

void write_row(ByteWriter& out, const CachedRow& row) {
  const bool converged = row.state == RowState::converged;
  out.u32(row.node);
  out.u8(static_cast<std::uint8_t>(converged ? RowState::converged : RowState::open));
  const Kind kind = kind_of(row);
  const std::size_t parts = kind == Kind::knots ? row.knots.knots().size() : row.fit.component_count;
  out.u8(converged ? static_cast<std::uint8_t>(parts) : 0);
  out.u8(static_cast<std::uint8_t>(kind));
  out.u8(0);
  out.u32(row.generation);
  out.f32(row.energy);
  out.f32(converged ? row.objective : 0.0f);
  out.u64(row.count);
  if (!converged) return;
  for (const Knot& knot : row.knots.knots()) {
    out.f32(knot.density);
    out.f32(knot.attribute_mean);
    out.f32(knot.attribute_variance);
  }
  if (kind == Kind::knots) return;
  out.f32(row.fit.uniform_weight);
  out.f32(row.fit.uniform_attribute_mean);
  out.f32(row.fit.uniform_attribute_variance);
  for (const Component& part : row.fit.parts()) {
    out.f32(part.shape.mu);
    out.f32(part.shape.s_left);
    out.f32(part.shape.s_right);
    out.f32(part.weight);
    out.f32(part.attribute_mean);
    out.f32(part.attribute_variance);
  }
}

}  // namespace format

namespace {

// The rules of the service that fix what g and a sketch are. Those of the host are in the model's name.
constexpr std::string_view rules =
    "node rule 1: g at the grid node; blur 1: wrapped Gaussian; axis rule 1: ascending coordinates, node = a * nb + b; "
    "sketch rule 1: max(128, ceil(12 pi / sigma)) bins, minimum of |offset| 31, sign 1, float g 32";

void write_section(ByteWriter& out, format::Section id, const std::string& payload) {
  out.u32(static_cast<std::uint32_t>(id));
  out.u32(0);
  out.u64(payload.size());
  out.u64(format::checksum(payload));
  out.text(payload);
}

}  // namespace

std::uint64_t model_hash(const std::string& model) {
  std::string text = model;
  text.push_back('\0');
  text.append(rules);
  return format::checksum(text);
}

std::string encode_cache(const TableSnapshot& image) {
  ByteWriter model, slices, rows, sketches;
  std::uint32_t version = format::version_of_mixtures;
  model.u32(static_cast<std::uint32_t>(image.model.size()));
  model.text(image.model);
  slices.u32(static_cast<std::uint32_t>(image.slices.size()));
  for (const CachedSlice& slice : image.slices) {
    format::write_description(slices, slice.description);
    rows.u32(static_cast<std::uint32_t>(slice.rows.size()));
    for (const CachedRow& row : slice.rows) {
      format::write_row(rows, row);
      if (format::kind_of(row) == format::Kind::knots) version = format::version_of_knots;
      if (row.state == RowState::converged) continue;
      sketches.u32(static_cast<std::uint32_t>(row.sketch.size()));
      for (const SketchBin& bin : row.sketch) {
        sketches.u32(bin.index);
        sketches.u64(bin.bits);
      }
    }
  }
  ByteWriter out;
  out.text(format::magic);
  out.u32(version);
  out.u32(format::section_count);
  out.u64(model_hash(image.model));
  write_section(out, format::Section::model, model.bytes());
  write_section(out, format::Section::slices, slices.bytes());
  write_section(out, format::Section::rows, rows.bytes());
  write_section(out, format::Section::sketches, sketches.bytes());
  return out.take();
}

std::string cache_hash(const TableSnapshot& image) {
  return format::hexadecimal(format::checksum(encode_cache(image)));
}

}  // namespace tress::adaptive
