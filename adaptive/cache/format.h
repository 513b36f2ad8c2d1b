// The parts of the cache format that encoder and decoder share. CACHE_FORMAT.md defines every byte.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <tuple>

#include "cache/bytes.h"
#include "tress/adaptive/cache.h"
#include "tress/version.h"

namespace tress::inline v0_2::adaptive::format {

constexpr std::string_view magic{"\x89TRESS\r\n", 8};  // as in PNG: text-mode transfers break it
/// A file has the lowest version that can hold it: 1, 3 with slices of samples, or 4 with such slices of more than the
/// usual parameters. Files of version 2 have rows of knots, which are no longer written.
constexpr std::uint32_t version_of_mixtures = 1, version_of_knots = 2, version_of_samples = 3,
                        version_of_parameters = 4;
static_assert(version_of_parameters == cache_format_version);
constexpr std::size_t header_bytes = 24;
constexpr std::size_t section_header_bytes = 24;

enum class Section : std::uint32_t { model = 1, slices = 2, rows = 3, sketches = 4 };
constexpr std::uint32_t section_count = 4;

// Smallest sizes of encoded things: they bound a count before memory is allocated for it.
constexpr std::size_t slice_bytes = 28;
constexpr std::size_t row_bytes = 28;
constexpr std::size_t mixture_bytes = 12;
constexpr std::size_t component_bytes = 24;
constexpr std::size_t knot_bytes = 12;
constexpr std::size_t bin_bytes = 12;

constexpr std::size_t longest_model_name = 256;
constexpr std::uint64_t most_nodes_of_slice = std::uint64_t{1} << 20;
constexpr float least_blur_rad = 1e-4f, largest_blur_rad = 3.1415927f;
// Scales are kept in [0.004, 0.5]; the slack covers rounding of a float's last bits.
constexpr float least_scale = 0.004f * 0.9999f, largest_scale = 0.5f * 1.0001f;

/// The representation of a converged row: byte 6 of a row.
enum class Kind : std::uint8_t { mixture = 0, knots = 1, ribbons = 2 };
inline bool is_knot_count(std::uint32_t count) { return count == 32 || count == 64 || count == 128; }

/// Takes a cache piece by piece, from its first byte to its last. Returns false if there is no room, and is then not
/// called again.
using ByteSink = std::function<bool(std::string_view)>;
/// Writes the whole file, in pieces of some 32 KB, from five rounds over the rows. False if the sink has no room, the
/// rows have a failure(), or the rounds differ.
bool write_cache(RowSource& rows, const ByteSink& out);
/// The bytes of a cache; empty where write_cache() fails.
std::string cache_bytes(RowSource& rows);

/// Writes the row as it stands in section rows, without what its state does not store.
void write_row(ByteWriter& out, const CachedRow& row);
/// Writes the sketch of an open row as it stands in section sketches.
void write_sketch(ByteWriter& out, const CachedRow& row);
/// The lowest version of a file that can hold the slice.
std::uint32_t version_of(const SliceDescription& slice);
/// The number of parameters that a slice has in a file of that version.
constexpr std::size_t stored_parameters(std::uint32_t version) {
  return version >= version_of_parameters ? std::tuple_size_v<decltype(SliceKey::parameters)>
         : version >= version_of_samples  ? SliceKey::usual_parameters
                                          : SliceKey::density_parameters;
}
/// Writes the slice's description as it stands in section slices of a file of that version.
void write_description(ByteWriter& out, const SliceDescription& slice, std::uint32_t version);
/// The description as bytes, which compare as descriptions do.
std::string described(const SliceDescription& slice);

}  // namespace tress::inline v0_2::adaptive::format
