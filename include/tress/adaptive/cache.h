// The table as a file: CACHE_FORMAT.md has it byte by byte.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tress/adaptive/knot_density.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/ribbon.h"
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
  Mixture fit;                      ///< converged rows that are neither of the next two; empty for open ones
  KnotDensity knots;                ///< converged rows that are a knot table, of mass `energy`; empty for all others
  /// Converged rows of slices of samples, of mass `energy`; null for all others. Shared: it does not change.
  std::shared_ptr<const RibbonRow> ribbons;
  float energy = 0;
  float objective = 0;            ///< bound that passed the test, relative squared L2; 0 for open rows
  std::uint64_t count = 0;        ///< g evaluations that taught it, or paths
  std::vector<SketchBin> sketch;  ///< open rows of slices of densities, ascending index
};

struct CachedSlice {
  SliceDescription description;
  std::vector<CachedRow> rows;  ///< ascending node
};

/// A whole table as plain data: slices in order of their keys. For tables that are small: it takes ten times the memory
/// of the table that it was made of. What may be large goes row by row, as a RowSource.
struct TableSnapshot {
  std::string model;  ///< Target::model_name()
  std::vector<CachedSlice> slices;
};

/// A table as its rows, one after the other: slices in ascending order of their keys, the rows of each in ascending
/// order of node. Takes the memory of one row, however many there are. One thread; begins before the first slice.
class RowSource {
 public:
  virtual ~RowSource() = default;
  /// Target::model_name()
  virtual const std::string& model() const = 0;
  /// Goes back to before the first slice. Every round gives the same, as long as what is read stays as it is.
  virtual void rewind() = 0;
  /// The next slice; what is left of the one before is passed over. Null after the last. Good until the next call.
  virtual const SliceDescription* next_slice() = 0;
  /// The next row of that slice, null after its last. Good until the next call.
  virtual const CachedRow* next_row() = 0;
  /// Why the rows ended early, if they did: the file that they come from could not be read to its end.
  virtual std::optional<Error> failure() const { return std::nullopt; }
};

/// The rows of a snapshot, which must outlive it.
class SnapshotRows final : public RowSource {
 public:
  explicit SnapshotRows(const TableSnapshot& table) : table_(table) {}
  const std::string& model() const override { return table_.model; }
  void rewind() override { slice_ = row_ = 0; }
  const SliceDescription* next_slice() override {
    row_ = 0;
    return slice_ < table_.slices.size() ? &table_.slices[slice_++].description : nullptr;
  }
  const CachedRow* next_row() override {
    if (slice_ == 0 || row_ == table_.slices[slice_ - 1].rows.size()) return nullptr;
    return &table_.slices[slice_ - 1].rows[row_++];
  }

 private:
  const TableSnapshot& table_;
  std::size_t slice_ = 0, row_ = 0;  ///< the next ones
};

/// Two tables of one model as one: the row-wise maximum in a total order (CACHE_FORMAT.md); commutative, associative,
/// idempotent. Both must outlive it and are used by it alone.
class MergedRows final : public RowSource {
 public:
  /// Both must be of the same model.
  MergedRows(RowSource& a, RowSource& b);
  const std::string& model() const override { return a_.rows.model(); }
  void rewind() override;
  const SliceDescription* next_slice() override;
  const CachedRow* next_row() override;
  std::optional<Error> failure() const override;

 private:
  struct Side {
    RowSource& rows;
    const SliceDescription* slice = nullptr;  ///< the next one that is not yet told
    const CachedRow* row = nullptr;           ///< likewise
    bool tells = false;                       ///< its slice is the running one
    bool has_slice = false, has_row = false;  ///< what these point to has been told: the next is to be read
  };
  static void read_slice(Side& side);
  static void read_row(Side& side);

  Side a_, b_;
  CachedRow joined_;
};

/// All of it in memory.
TableSnapshot collect(RowSource& rows);

/// xxHash3 of the model's name and of the rules that fix what g and a sketch are.
std::uint64_t model_hash(const std::string& model);

/// What a cache holds, counted.
struct CacheContents {
  std::uint32_t format = 0;  ///< version
  std::uint64_t bytes = 0;   ///< of the file
  std::uint64_t slices = 0, open_rows = 0, converged_rows = 0;
  std::uint64_t knot_rows = 0;    ///< of the converged ones, those that are knot tables
  std::uint64_t ribbon_rows = 0;  ///< likewise, those of slices of samples
  std::string hash;               ///< as cache_hash()
  std::uint64_t rows() const { return open_rows + converged_rows; }
};

/// Bytes that a slice without its rows, or a row with its sketch, takes in a cache. format: CacheContents::format.
std::size_t cached_bytes(const SliceDescription& slice, std::uint32_t format);
std::size_t cached_bytes(const CachedRow& row);

/// A cache file as a source of rows, in about 100 KB of memory. It is the file as it was opened, whatever takes its
/// place meanwhile. Should somebody write into it meanwhile, failure() says so, or what is made of it is refused.
class CacheFile final : public RowSource {
 public:
  /// Checks everything before it returns: each section against its checksum, each count against the bytes that remain,
  /// each value against its range. `model`: refused if the file is of another; empty accepts any.
  static Result<std::unique_ptr<CacheFile>> open(const std::filesystem::path& file, const std::string& model);
  ~CacheFile() override;

  const CacheContents& contents() const;

  const std::string& model() const override;
  void rewind() override;
  const SliceDescription* next_slice() override;
  const CachedRow* next_row() override;
  std::optional<Error> failure() const override;

 private:
  struct Opened;
  explicit CacheFile(std::unique_ptr<Opened> opened);
  std::unique_ptr<Opened> opened_;
};

/// CacheFile::open() and all of it in memory.
Result<TableSnapshot> load_cache(const std::filesystem::path& file, const std::string& model);

/// What a save did.
struct CacheSave {
  CacheContents contents;                      ///< what the file now holds
  std::vector<std::filesystem::path> removed;  ///< temporary files that killed saves had left
};

/// Puts the rows in the place of the file, whatever it holds. Temporary file beside it, flushed, renamed, folder
/// flushed: the old file is there until the new one is whole. Links stay links. Under the lock of merge_into_cache.
/// Goes through the rows five times, in about 100 KB of memory.
Result<CacheSave> replace_cache(const std::filesystem::path& file, RowSource& rows);
/// Of a snapshot.
std::optional<Error> save_cache(const std::filesystem::path& file, const TableSnapshot& image);

/// What merge_into_cache found and did.
struct CacheUpdate : CacheSave {
  enum class Outcome {
    created,  ///< no file was there
    merged,   ///< joined with what the file held
    refused,  ///< what is there is no cache of this model: left as it is, nothing is saved
  };
  Outcome outcome = Outcome::created;
  std::optional<Error> refusal;  ///< why, if refused
};

/// Saves the rows joined with what the file holds by now, so that no session's rows are lost, however many save into
/// one file. Any thread or process, on any machine that shares the folder: they take turns by a lock on `FILE.lock`
/// (where the file system has no locks, each save is still whole, but may miss another of the same moment). Blocks
/// meanwhile. Error if the file could not be written; it is then as it was. As replace_cache in time and memory.
Result<CacheUpdate> merge_into_cache(const std::filesystem::path& file, RowSource& rows);
Result<CacheUpdate> merge_into_cache(const std::filesystem::path& file, const TableSnapshot& image);

/// The bytes that save_cache writes.
std::string encode_cache(const TableSnapshot& image);
/// `name` stands for the file in errors.
Result<TableSnapshot> decode_cache(const std::string& bytes, const std::string& model, const std::string& name);

/// MergedRows of two snapshots of one model (asserted).
TableSnapshot merge_caches(const TableSnapshot& a, const TableSnapshot& b);

/// Hash of the encoded table, 16 hexadecimal digits: what a picture's header carries.
std::string cache_hash(RowSource& rows);
std::string cache_hash(const TableSnapshot& image);

}  // namespace tress::adaptive
