// Reads a cache from bytes that may hold anything; reader.h describes it.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/content_hash.h"
#include "base/pi.h"
#include "cache/reader.h"
#include "observations/sketch.h"

namespace tress::inline v0_2::adaptive {
namespace {

using format::Section;

constexpr float huge = 3.402823466e+38f;

/// By number of the section, from 1.
constexpr const char* section_names[] = {"", "section model", "section pages", "section rows", "section sketches"};

std::string byte(std::size_t position) { return "byte " + std::to_string(position); }

bool is_known(std::uint32_t version) {
  return version >= format::version_of_mixtures && version <= format::version_of_parameters;
}

/// What a file of this version has that earlier versions have not.
const char* reason_of(std::uint32_t version) {
  if (version == format::version_of_parameters) return " with more parameters";
  if (version == format::version_of_samples) return " with slices of samples";
  return version == format::version_of_knots ? " with knot rows" : " without knot rows";
}

/// The number of bins of each sketch in the slice. A slice of samples has no sketches.
std::uint32_t bins_of(const SliceDescription& slice) {
  return slice.kind == SliceKind::samples ? 0 : Sketch::bin_count(slice.blur_rad);
}

}  // namespace

bool is_model_name(std::string_view name) {
  return !name.empty() && name.size() <= format::longest_model_name &&
         std::ranges::all_of(name, [](char c) { return c >= ' ' && c <= '~'; });
}

std::string CacheReader::here(const ByteReader& in, std::size_t back) const {
  return section_names[static_cast<std::size_t>(where_)] + (", " + byte(in.position() - back));
}

bool CacheReader::fail(std::string place, std::string expected, std::string found) {
  error_ = Error{name_, std::move(place), std::move(expected), std::move(found)};
  const bool unreadable = std::ranges::any_of(readers_, [](const ByteReader& in) { return in.unreadable(); });
  if (unreadable) error_ = Error{name_, error_->place, "bytes that can be read", "a file that changes or fails"};
  return false;
}

bool CacheReader::check(const std::string& wanted_model) {
  ByteReader in(&bytes_, 0, bytes_.size());
  std::uint64_t hash = 0;
  const bool whole = header(in, &hash) && frame(in, Section::model) && read_model() && same_model(wanted_model, hash) &&
                     frame(in, Section::slices) && read_to_the_end(Section::slices) && frame(in, Section::rows) &&
                     read_to_the_end(Section::rows) && frame(in, Section::sketches) &&
                     read_to_the_end(Section::sketches) &&
                     (in.remaining() == 0 ||
                      fail(byte(in.position()), "the end of the file", std::to_string(in.remaining()) + " more bytes"));
  std::uint64_t sum = 0;
  if (!whole || !checksum_of(0, bytes_.size(), &sum)) return false;
  contents_.format = version_;
  contents_.bytes = bytes_.size();
  contents_.hash = hexadecimal(sum);
  rewind();
  return true;
}

bool CacheReader::header(ByteReader& in, std::uint64_t* hash) {
  if (bytes_.size() < format::header_bytes) {
    return fail(byte(bytes_.size()), "a header of " + std::to_string(format::header_bytes) + " bytes",
                "the end of the file");
  }
  if (in.text(format::magic.size()) != format::magic) return fail(byte(0), "the magic of a tress cache", "another");
  version_ = in.u32();
  if (!is_known(version_)) {
    const std::uint32_t turned =
        version_ >> 24 | (version_ >> 8 & 0xff00u) | (version_ << 8 & 0xff0000u) | version_ << 24;
    return fail(byte(8),
                "format version " + std::to_string(format::version_of_mixtures) + " to " +
                    std::to_string(format::version_of_parameters),
                is_known(turned) ? "version " + std::to_string(turned) + " with its highest byte first"
                                 : (version_ > format::version_of_parameters ? "later version " : "version ") +
                                       std::to_string(version_));
  }
  const std::uint32_t sections = in.u32();
  if (sections != format::section_count) {
    return fail(byte(12), std::to_string(format::section_count) + " sections", std::to_string(sections));
  }
  *hash = in.u64();
  return true;
}

bool CacheReader::same_model(const std::string& wanted, std::uint64_t hash) {
  const auto described = [](const std::string& name, std::uint64_t number) {
    return "model " + name + " (hash " + hexadecimal(number) + ")";
  };
  const std::string& expected = wanted.empty() ? model_ : wanted;
  if (hash == model_hash(expected) && model_ == expected) return true;
  return fail(byte(16), described(expected, model_hash(expected)), described(model_, hash));
}

bool CacheReader::checksum_of(std::size_t start, std::size_t size, std::uint64_t* sum) {
  ByteReader in(&bytes_, start, size);
  ContentHash hash;
  while (in.remaining() > 0) {
    const std::string_view piece = in.text(std::min(in.remaining(), ByteReader::largest_buffer));
    if (piece.empty()) return fail(byte(in.position()), "bytes that can be read", "a file that changes or fails");
    hash.add(piece);
  }
  *sum = hash.value();
  return true;
}

/// Reads the header of a section: its length, which must be within the file, and its checksum.
bool CacheReader::frame(ByteReader& in, Section section) {
  where_ = section;
  const std::size_t at = in.position();
  if (in.remaining() < format::section_header_bytes) {
    return fail(here(in), "a section header of " + std::to_string(format::section_header_bytes) + " bytes",
                std::to_string(in.remaining()) + " bytes");
  }
  const std::uint32_t found = in.u32();
  if (found != static_cast<std::uint32_t>(section)) {
    return fail(here(in, 4), "section " + std::to_string(static_cast<std::uint32_t>(section)), std::to_string(found));
  }
  if (const std::uint32_t zero = in.u32(); zero != 0) return fail(here(in, 4), "0", std::to_string(zero));
  const std::uint64_t length = in.u64();
  const std::uint64_t sum = in.u64();
  if (length > in.remaining()) {
    return fail(here(in, 16), "at most the " + std::to_string(in.remaining()) + " bytes that remain",
                "a length of " + std::to_string(length));
  }
  const Frame payload{at + format::section_header_bytes, static_cast<std::size_t>(length)};
  std::uint64_t actual = 0;
  if (!checksum_of(payload.start, payload.size, &actual)) return false;
  if (actual != sum) {
    return fail(here(in), "checksum " + hexadecimal(sum), hexadecimal(actual));
  }
  frames_[static_cast<std::size_t>(section) - 1] = payload;
  in = ByteReader(&bytes_, payload.start + payload.size, bytes_.size() - payload.start - payload.size);
  return true;
}

bool CacheReader::end_of(Section section) {
  const ByteReader& in = reader(section);
  where_ = section;
  if (in.short_of_bytes()) return fail(here(in), "more bytes", "the end of the section");
  if (in.remaining() == 0) return true;
  return fail(here(in), "the end of the section", std::to_string(in.remaining()) + " more bytes");
}

bool CacheReader::read_model() {
  const Frame& payload = frames_[0];
  reader(Section::model) = ByteReader(&bytes_, payload.start, payload.size);
  ByteReader& in = reader(Section::model);
  std::uint32_t size = 0;
  if (!count(in, 1, "characters", &size)) return false;
  if (size == 0 || size > format::longest_model_name) {
    return fail(here(in, 4), "a name of 1 to " + std::to_string(format::longest_model_name) + " characters",
                std::to_string(size));
  }
  model_ = in.text(size);
  if (!is_model_name(model_)) return fail(here(in, size), "a name in printable ASCII", "another character");
  return end_of(Section::model);
}

bool CacheReader::read_to_the_end(Section deepest) {
  begin(deepest);
  contents_ = {};
  while (next_slice() != nullptr) {
    ++contents_.slices;
    while (deepest >= Section::rows && next_row() != nullptr) {
      ++(row_.state == RowState::converged ? contents_.converged_rows : contents_.open_rows);
      contents_.ribbon_rows += row_.ribbons() != nullptr ? 1 : 0;
    }
  }
  contents_.knot_rows = knot_rows_;
  return !error_;
}

void CacheReader::begin(Section deepest) {
  deepest_ = deepest;
  for (std::size_t i = 1; i < static_cast<std::size_t>(deepest); ++i) {
    readers_[i] = ByteReader(&bytes_, frames_[i].start, frames_[i].size);
  }
  begun_ = has_slice_ = false;
  needed_version_ = format::version_of_mixtures;
  slices_left_ = rows_left_ = 0;
  knot_rows_ = 0;
  error_.reset();
}

void CacheReader::begin_rows(const SliceDescription& slice, std::uint32_t rows, const ByteSource& table,
                             const ByteSource& sketches) {
  begin(Section::sketches);
  reader(Section::rows) = ByteReader(&table, 0, table.size());
  reader(Section::sketches) = ByteReader(&sketches, 0, sketches.size());
  slice_ = slice;
  rows_left_ = rows;
  least_node_ = 0;
  bins_ = bins_of(slice);
}

const SliceDescription* CacheReader::next_slice() {
  while (next_row() != nullptr) {
  }
  if (error_) return nullptr;
  where_ = Section::slices;
  ByteReader& in = reader(Section::slices);
  if (!begun_ && !count(in, format::slice_bytes, "pages", &slices_left_)) return nullptr;
  const bool first = !begun_;
  begun_ = true;
  if (slices_left_ == 0) {
    if (first || has_slice_) (void)end_of_slices();
    has_slice_ = false;
    return nullptr;
  }
  --slices_left_;
  const std::string start = here(in);
  const SliceKey before = slice_.key;
  if (!slice(in)) return nullptr;
  if (has_slice_ && !(before < slice_.key)) {
    (void)fail(start, "pages in ascending order of their keys", "a key not above the one before");
    return nullptr;
  }
  has_slice_ = true;
  if (!reads(Section::rows)) return &slice_;
  where_ = Section::rows;
  ByteReader& rows = reader(Section::rows);
  const std::uint32_t nodes = slice_.node_count();
  if (!count(rows, format::row_bytes, "rows", &rows_left_)) return nullptr;
  if (rows_left_ > nodes) {
    (void)fail(here(rows, 4), "at most " + std::to_string(nodes) + " rows", std::to_string(rows_left_));
    return nullptr;
  }
  least_node_ = 0;
  bins_ = bins_of(slice_);
  return &slice_;
}

/// After the last slice each section must be used up.
bool CacheReader::end_of_slices() {
  if (!reads(Section::rows)) return end_of(Section::slices);
  if (version_ != needed_version_) {
    return fail(byte(8), "format version " + std::to_string(needed_version_) + reason_of(needed_version_),
                std::to_string(version_));
  }
  return end_of(Section::rows) && (!reads(Section::sketches) || end_of(Section::sketches));
}

const CachedRow* CacheReader::next_row() {
  std::uint64_t knot_rows_before = 0;
  do {
    if (error_ || rows_left_ == 0) return nullptr;
    --rows_left_;
    where_ = Section::rows;
    knot_rows_before = knot_rows_;
    if (!row(reader(Section::rows))) return nullptr;
    least_node_ = row_.node + 1;
  } while (knot_rows_ != knot_rows_before);  // they are left out
  if (reads(Section::sketches) && row_.state == RowState::open) {
    where_ = Section::sketches;
    if (!sketch(reader(Section::sketches))) return nullptr;
  }
  return &row_;
}

/// Reads a count of things of at least `size` bytes each; the bytes that remain bound it.
bool CacheReader::count(ByteReader& in, std::size_t size, const char* what, std::uint32_t* number) {
  *number = in.u32();
  if (in.short_of_bytes()) return fail(here(in), std::string("the number of ") + what, "the end of the section");
  if (*number > in.remaining() / size) {
    return fail(
        here(in, 4),
        std::string("at most ") + std::to_string(in.remaining() / size) + " " + what + " in the bytes that remain",
        std::to_string(*number));
  }
  return true;
}

/// Reads a float in [least, largest]. A negative zero is refused, because the encoder writes none.
bool CacheReader::number(ByteReader& in, const char* what, float least, float largest, float* value) {
  *value = in.f32();
  if (in.short_of_bytes()) return fail(here(in), what, "the end of the section");
  if (*value >= least && *value <= largest && !(*value == 0 && std::signbit(*value))) return true;
  return fail(here(in, 4), std::string(what) + " in [" + std::to_string(least) + ", " + std::to_string(largest) + "]",
              std::to_string(*value));
}
bool CacheReader::not_negative(ByteReader& in, const char* what, float* value) {
  return number(in, what, 0, huge, value);
}

bool CacheReader::axis(ByteReader& in, const char* what, std::uint32_t size, std::vector<float>* coordinates) {
  coordinates->clear();
  coordinates->reserve(size);
  for (std::uint32_t i = 0; i < size; ++i) {
    float coordinate = 0;
    if (!number(in, what, -huge, huge, &coordinate)) return false;
    if (i > 0 && coordinate <= coordinates->back()) {
      return fail(here(in, 4), std::string(what) + " above " + std::to_string(coordinates->back()),
                  std::to_string(coordinate));
    }
    coordinates->push_back(coordinate);
  }
  return true;
}

bool CacheReader::slice(ByteReader& in) {
  slice_.key = {};
  slice_.key.lobe = in.u32();
  const bool has_kind = version_ >= format::version_of_samples;
  const std::uint32_t kind = has_kind ? in.u32() : 0;
  if (kind > static_cast<std::uint32_t>(SliceKind::samples)) {
    return fail(here(in, 4), "kind 0 (densities) or 1 (samples)", std::to_string(kind));
  }
  slice_.kind = static_cast<SliceKind>(kind);
  const bool samples = slice_.kind == SliceKind::samples;
  for (std::size_t i = 0; i < format::stored_parameters(version_); ++i) {
    const float largest = samples || i < SliceKey::density_parameters ? huge : 0;
    if (!number(in, "a finite parameter", -largest, largest, &slice_.key.parameters[i])) return false;
  }
  needed_version_ = std::max(needed_version_, format::version_of(slice_));
  if (!number(in, "blur", samples ? 0 : format::least_blur_rad, samples ? 0 : format::largest_blur_rad,
              &slice_.blur_rad)) {
    return false;
  }
  const std::uint64_t a = in.u32();
  const std::uint64_t b = in.u32();
  if (in.short_of_bytes()) return fail(here(in), "the sizes of the axes", "the end of the section");
  if (a == 0 || b == 0 || a * b > format::most_nodes_of_slice) {
    return fail(here(in, 8), "1 to " + std::to_string(format::most_nodes_of_slice) + " nodes",
                std::to_string(a) + " x " + std::to_string(b));
  }
  if (a + b > in.remaining() / 4) {
    return fail(here(in, 8), "at most " + std::to_string(in.remaining() / 4) + " coordinates", std::to_string(a + b));
  }
  return axis(in, "coordinate a", static_cast<std::uint32_t>(a), &slice_.axis_a) &&
         axis(in, "coordinate b", static_cast<std::uint32_t>(b), &slice_.axis_b);
}

bool CacheReader::row(ByteReader& in) {
  const std::uint32_t nodes = slice_.node_count();
  if (in.remaining() < format::row_bytes) return fail(here(in), "a row", "the end of the section");
  row_.node = in.u32();
  if (row_.node < least_node_ || row_.node >= nodes) {
    return fail(here(in, 4), "a node in [" + std::to_string(least_node_) + ", " + std::to_string(nodes) + ")",
                std::to_string(row_.node));
  }
  const std::uint32_t state = in.u8();
  if (state != static_cast<std::uint32_t>(RowState::open) && state != static_cast<std::uint32_t>(RowState::converged)) {
    return fail(here(in, 1), "state 1 (open) or 2 (converged)", std::to_string(state));
  }
  row_.state = static_cast<RowState>(state);
  const bool converged = row_.state == RowState::converged;
  const std::uint32_t parts = in.u8();
  const std::uint32_t kind = in.u8();
  const bool samples = slice_.kind == SliceKind::samples;
  const bool knots = kind == static_cast<std::uint32_t>(format::Kind::knots);
  const auto ribbons_kind = static_cast<std::uint32_t>(format::Kind::ribbons);
  if (!converged ? kind != 0 : samples ? kind != ribbons_kind : kind >= ribbons_kind) {
    return fail(here(in, 1),
                !converged ? "kind 0 of an open row"
                : samples  ? "kind 2 (ribbons)"
                           : "kind 0 (mixture) or 1 (knots)",
                std::to_string(kind));
  }
  const std::uint32_t most = !converged ? 0 : samples ? RibbonRow::most_parts : Mixture::max_components;
  if (converged && samples && parts == 0) return fail(here(in, 2), "1 to 4 ribbons", "0");
  if (knots && !format::is_knot_count(parts)) return fail(here(in, 2), "32, 64 or 128 knots", std::to_string(parts));
  if (!knots && parts > most) {
    return fail(here(in, 2), "at most " + std::to_string(most) + (samples ? " ribbons" : " components"),
                std::to_string(parts));
  }
  if (const std::uint32_t zero = in.u8(); zero != 0) return fail(here(in, 1), "0", std::to_string(zero));
  row_.generation = in.u32();
  if (!not_negative(in, "energy", &row_.energy) || !number(in, "objective", 0, converged ? huge : 0, &row_.objective)) {
    return false;
  }
  row_.count = in.u64();
  if (samples) {
    row_.learned = CachedSamples{};
    return !converged || ribbons(in, parts);
  }
  row_.learned = CachedDensity{};
  if (knots) return skip_knots(in, parts);
  return !converged || mixture(in, parts);
}

bool CacheReader::skip_knots(ByteReader& in, std::uint32_t number_of_knots) {
  needed_version_ = std::max(needed_version_, format::version_of_knots);
  ++knot_rows_;
  float value = 0;
  for (std::uint32_t i = 0; i < 3 * number_of_knots; ++i) {
    if (!not_negative(in, "density, attribute or variance of a knot", &value)) return false;
  }
  return true;
}

bool CacheReader::ribbons(ByteReader& in, std::uint32_t parts) {
  std::array<float, RibbonRow::most_parts> masses{};
  for (std::uint32_t p = 0; p < parts; ++p) {
    if (!not_negative(in, "mass of a part", &masses[p])) return false;
  }
  const std::string start = here(in);
  const std::size_t size = parts * RibbonRow::part_bytes;
  if (size > in.remaining()) {
    return fail(start, "at most " + std::to_string(in.remaining()) + " bytes of ribbons", std::to_string(size));
  }
  const std::string_view bytes = in.text(size);
  if (in.short_of_bytes()) return fail(start, "ribbons", "the end of the section");
  RibbonRow row;
  if (!row.unpack(std::as_bytes(std::span(bytes)), std::span(masses).first(parts))) {
    return fail(start, "ribbons as they are packed", "other bytes, or masses");
  }
  if (row.total_mass() != row_.energy) {
    return fail(start, "ribbons of mass " + std::to_string(row_.energy), std::to_string(row.total_mass()));
  }
  row_.learned = CachedSamples{std::make_shared<const RibbonRow>(row)};
  return true;
}

bool CacheReader::mixture(ByteReader& in, std::uint32_t components) {
  Mixture* fit = &row_.density()->fit;
  fit->component_count = components;
  if (!not_negative(in, "weight of the uniform part", &fit->uniform_weight) ||
      !not_negative(in, "attribute", &fit->uniform_attribute_mean) ||
      !not_negative(in, "variance of the attribute", &fit->uniform_attribute_variance)) {
    return false;
  }
  for (std::uint32_t i = 0; i < fit->component_count; ++i) {
    Component& part = fit->components[i];
    if (!number(in, "mode", -pi_f, pi_f, &part.shape.mu) ||
        !number(in, "scale", format::least_scale, format::largest_scale, &part.shape.s_left) ||
        !number(in, "scale", format::least_scale, format::largest_scale, &part.shape.s_right) ||
        !not_negative(in, "weight", &part.weight) || !not_negative(in, "attribute", &part.attribute_mean) ||
        !not_negative(in, "variance of the attribute", &part.attribute_variance)) {
      return false;
    }
  }
  return true;
}

bool CacheReader::sketch(ByteReader& in) {
  std::uint32_t number = 0;
  if (!count(in, format::bin_bytes, "bins", &number)) return false;
  std::vector<SketchBin> bins;
  bins.reserve(std::min(number, bins_));
  for (std::uint32_t i = 0; i < number; ++i) {
    const std::uint32_t least = i == 0 ? 0 : bins.back().index + 1;
    const std::uint32_t index = in.u32();
    if (index < least || index >= bins_) {
      return fail(here(in, 4), "a bin in [" + std::to_string(least) + ", " + std::to_string(bins_) + ")",
                  std::to_string(index));
    }
    const std::uint64_t bits = in.u64();
    const float g = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    if (!std::isfinite(g) || std::signbit(g)) return fail(here(in, 8), "g finite and >= 0", std::to_string(g));
    bins.push_back({index, bits});
  }
  if (row_.density() != nullptr) row_.density()->sketch = std::move(bins);
  return true;
}

Result<TableSnapshot> decode_cache(const std::string& bytes, const std::string& model, const std::string& name) {
  const MemoryBytes source(bytes);
  CacheReader reader(source, name);
  if (!reader.check(model)) return reader.error();
  return collect(reader);
}

}  // namespace tress::inline v0_2::adaptive
