// The table as a file: CACHE_FORMAT.md has it byte by byte.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tress/adaptive/knot_density.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/target.h"
#include "tress/base/error.h"
#include "tress/base/replace_file.h"

namespace tress::adaptive {

enum class RowState : std::uint8_t {
  absent = 0,     ///< only counted; answered by tracing the node
  open = 1,       ///< being learned; answered by g at the node
  converged = 2,  ///< answered by its fit, a mixture or a knot table
  refused = 3,    ///< failed too many tests; answered by g at the node for good
};

/// One observed pair of a sketch: raw bits, see sketch/sketch.h. Merging is the minimum.
struct SketchBin {
  std::uint32_t index;
  std::uint64_t bits;
  friend bool operator==(const SketchBin&, const SketchBin&) = default;
};

struct CachedRow {
  std::uint32_t node = 0;           ///< a * axis_b.size() + b
  RowState state = RowState::open;  ///< open or converged
  std::uint32_t generation = 0;     ///< raised each time the row is reopened
  Mixture fit;                      ///< converged rows without knots; empty for open ones
  KnotDensity knots;                ///< converged rows that are a knot table, of mass `energy`; empty for all others
  float energy = 0;
  float objective = 0;            ///< bound that passed the test, relative squared L2; 0 for open rows
  std::uint64_t count = 0;        ///< g evaluations that taught it
  std::vector<SketchBin> sketch;  ///< open rows, ascending index
};

struct CachedSlice {
  SliceDescription description;
  std::vector<CachedRow> rows;  ///< ascending node
};

/// A whole table as plain data: slices in order of their keys.
struct TableSnapshot {
  std::string model;  ///< Target::model_name()
  std::vector<CachedSlice> slices;
};

/// xxHash3 of the model's name and of the rules that fix what g and a sketch are.
std::uint64_t model_hash(const std::string& model);

/// Reads and checks everything before it allocates: counts are bounded by the bytes that are there.
/// `model`: refused if the file is of another; empty accepts any.
Result<TableSnapshot> load_cache(const std::filesystem::path& file, const std::string& model);
/// Puts the image in the place of the file, whatever it holds. Temporary file beside it, flushed, renamed, folder
/// flushed: the old file is there until the new one is whole. Links stay links. Under the lock of merge_into_cache.
/// `removed`, if asked for: the temporary files that killed saves had left.
std::optional<Error> save_cache(const std::filesystem::path& file, const TableSnapshot& image,
                                std::vector<std::filesystem::path>* removed = nullptr);

/// What merge_into_cache found and did.
struct CacheUpdate {
  enum class Outcome {
    created,  ///< no file was there
    merged,   ///< joined with what the file held
    refused,  ///< what is there is no cache of this model: left as it is, nothing is saved
  };
  Outcome outcome = Outcome::created;
  TableSnapshot image;                         ///< what the file now holds; empty if refused
  std::optional<Error> refusal;                ///< why, if refused
  std::vector<std::filesystem::path> removed;  ///< temporary files that killed saves had left
};

/// Saves the image joined with what the file holds by now, so that no session's rows are lost, however many save into
/// one file. Any thread or process, on any machine that shares the folder: they take turns by a lock on `FILE.lock`
/// (where the file system has no locks, each save is still whole, but may miss another of the same moment). Blocks
/// meanwhile. Error if the file could not be written; it is then as it was.
Result<CacheUpdate> merge_into_cache(const std::filesystem::path& file, TableSnapshot image);

/// The bytes that save_cache writes.
std::string encode_cache(const TableSnapshot& image);
/// `name` stands for the file in errors.
Result<TableSnapshot> decode_cache(const std::string& bytes, const std::string& model, const std::string& name);

/// Row-wise maximum in a total order (CACHE_FORMAT.md): commutative, associative, idempotent.
/// Both images must be of one model (asserted).
TableSnapshot merge_caches(const TableSnapshot& a, const TableSnapshot& b);

/// Hash of the encoded image, 16 hexadecimal digits: what a picture's header carries.
std::string cache_hash(const TableSnapshot& image);

}  // namespace tress::adaptive
