// The table as a file. CACHE_FORMAT.md defines every byte.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tress/adaptive/mixture.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/target.h"
#include "tress/base/error.h"
#include "tress/base/replace_file.h"

namespace tress::inline v0_2::adaptive {

enum class RowState : std::uint8_t {
  absent = 0,     ///< only counted; queries are answered by tracing the node
  open = 1,       ///< being learned; queries are answered by g at the node
  converged = 2,  ///< queries are answered by its fit
  refused = 3,    ///< failed too many tests; queries are answered by g at the node for good
};

/// One observed pair of a sketch, as 64 raw bits: the distance from the bin's centre comes first, so merging takes the
/// minimum (ESTIMATOR.md, E3).
struct SketchBin {
  std::uint32_t index;
  std::uint64_t bits;
  friend bool operator==(const SketchBin&, const SketchBin&) = default;
};

/// What a row of a slice of densities has learned.
struct CachedDensity {
  Mixture fit;                    ///< of a converged row; otherwise empty
  std::vector<SketchBin> sketch;  ///< of an open row, in ascending order of index
};

/// What a row of a slice of samples has learned.
struct CachedSamples {
  /// Null for an open row. Shared, since ribbons of a converged row do not change.
  std::shared_ptr<const RibbonRow> ribbons;
};

struct CachedRow {
  std::uint32_t node = 0;           ///< a * axis_b.size() + b
  RowState state = RowState::open;  ///< open or converged
  std::uint32_t generation = 0;     ///< raised each time the row is reopened
  float energy = 0;                 ///< mass of the target; of a converged row of samples, of its ribbons
  float objective = 0;              ///< the bound that passed the test, relative squared L2; 0 for open rows
  std::uint64_t count = 0;          ///< number of g evaluations, or of paths, from which it was learned
  std::variant<CachedDensity, CachedSamples> learned;  ///< by the kind of its slice

  /// Null for a row of a slice of samples.
  const CachedDensity* density() const { return std::get_if<CachedDensity>(&learned); }
  CachedDensity* density() { return std::get_if<CachedDensity>(&learned); }
  /// Null but for a row of a slice of samples that has them.
  const RibbonRow* ribbons() const {
    const auto* samples = std::get_if<CachedSamples>(&learned);
    return samples != nullptr ? samples->ribbons.get() : nullptr;
  }
};

struct CachedSlice {
  SliceDescription description;
  std::vector<CachedRow> rows;  ///< in ascending order of node
};

/// A whole table as plain data, with slices in the order of their keys. It takes ten times the memory of the table
/// itself, so use it for small tables only. Pass a table that may be large row by row, as a RowSource.
struct TableSnapshot {
  std::string model;  ///< Target::model_name()
  std::vector<CachedSlice> slices;
};

/// A table as a sequence of rows: slices in ascending order of their keys, the rows of each in ascending order of node.
/// It takes the memory of one row, however many there are. One thread; it starts before the first slice.
class RowSource {
 public:
  virtual ~RowSource() = default;
  /// Target::model_name()
  virtual const std::string& model() const = 0;
  /// Goes back to before the first slice. Every round gives the same rows as long as the source does not change.
  virtual void rewind() = 0;
  /// Returns the next slice and skips the remaining rows of the one before; null after the last. Valid until the next
  /// call.
  virtual const SliceDescription* next_slice() = 0;
  /// Returns the next row of that slice, or null after its last. Valid until the next call.
  virtual const CachedRow* next_row() = 0;
  /// The reason why the rows ended early, if they did: their file could not be read to its end.
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

/// Two tables of one model merged: the row-wise maximum in a total order (CACHE_FORMAT.md). Commutative, associative,
/// idempotent. Both tables must outlive it, and only it may use them.
class MergedRows final : public RowSource {
 public:
  /// Merges a and b, which must be of the same model.
  MergedRows(RowSource& a, RowSource& b);
  const std::string& model() const override { return a_.rows.model(); }
  void rewind() override;
  const SliceDescription* next_slice() override;
  const CachedRow* next_row() override;
  std::optional<Error> failure() const override;

 private:
  struct Side {
    RowSource& rows;
    const SliceDescription* slice = nullptr;  ///< the next slice that is not yet returned
    const CachedRow* row = nullptr;           ///< the next row that is not yet returned
    bool is_current = false;                  ///< whether its slice is the current one
    bool has_slice = false, has_row = false;  ///< slice and row were returned: read the next
  };
  static void read_slice(Side& side);
  static void read_row(Side& side);

  Side a_, b_;
  CachedRow joined_;
};

/// Reads all rows into memory.
TableSnapshot collect(RowSource& rows);

/// xxHash3 of the model's name and of the rules that define g and a sketch.
std::uint64_t model_hash(const std::string& model);

/// Counts of the contents of a cache.
struct CacheContents {
  std::uint32_t format = 0;  ///< format version
  std::uint64_t bytes = 0;   ///< size of the file
  std::uint64_t slices = 0, open_rows = 0, converged_rows = 0;
  /// Rows of knots, which versions before 0.3 wrote. They are left out of what is read, and so learned anew.
  std::uint64_t knot_rows = 0;
  std::uint64_t ribbon_rows = 0;  ///< converged rows of slices of samples
  std::string hash;               ///< the result of cache_hash()
  std::uint64_t rows() const { return open_rows + converged_rows; }
};

/// The bytes that a slice without its rows, or a row with its sketch, takes in a cache. format: CacheContents::format.
std::size_t cached_bytes(const SliceDescription& slice, std::uint32_t format);
std::size_t cached_bytes(const CachedRow& row);

/// A cache file as a source of rows, in about 100 KB of memory. It stays the file that was opened, even if another
/// replaces it meanwhile. If another process writes into the file, failure() reports it, or a reader refuses the
/// rows.
class CacheFile final : public RowSource {
 public:
  /// Opens the file and checks everything before it returns: each section against its checksum, each count against the
  /// bytes that remain, each value against its range. `model`: a file of another model is refused; empty accepts any.
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

/// Opens a file as CacheFile::open() does and reads all of it into memory.
Result<TableSnapshot> load_cache(const std::filesystem::path& file, const std::string& model);

/// The result of a save.
struct CacheSave {
  CacheContents contents;                      ///< contents of the saved file
  std::vector<std::filesystem::path> removed;  ///< temporary files left by saves that were killed
};

/// Replaces the file by the rows, whatever the file contains. It writes a temporary file beside it, flushes it, renames
/// it and flushes the folder, so the old file is there until the new one is whole. Links stay links. Takes the lock of
/// merge_into_cache. It goes through the rows five times, in about 100 KB of memory.
Result<CacheSave> replace_cache(const std::filesystem::path& file, RowSource& rows);
/// Saves a snapshot as replace_cache does.
std::optional<Error> save_cache(const std::filesystem::path& file, const TableSnapshot& image);

/// The result of merge_into_cache.
struct CacheUpdate : CacheSave {
  enum class Outcome {
    created,  ///< there was no file
    merged,   ///< the rows were merged with those of the file
    refused,  ///< the existing file is no cache of this model; it is left as it is and nothing is saved
  };
  Outcome outcome = Outcome::created;
  std::optional<Error> refusal;  ///< the reason, if refused
};

/// Merges the rows with those that the file has by now and saves the result, so that no session's rows are lost,
/// however many save into one file. Any thread or process, on any machine that shares the folder: they take turns by a
/// lock on `FILE.lock`, and a call waits for it. Where the file system has no locks, each save is still whole, but may
/// miss another save of the same moment. Error if the file could not be written; it is then unchanged. Takes the time
/// and memory of replace_cache.
Result<CacheUpdate> merge_into_cache(const std::filesystem::path& file, RowSource& rows);
Result<CacheUpdate> merge_into_cache(const std::filesystem::path& file, const TableSnapshot& image);

/// The bytes that save_cache writes.
std::string encode_cache(const TableSnapshot& image);
/// Decodes the bytes of a cache. `name` stands for the file in errors.
Result<TableSnapshot> decode_cache(const std::string& bytes, const std::string& model, const std::string& name);

/// Merges two snapshots as MergedRows does; they must be of one model (asserted).
TableSnapshot merge_caches(const TableSnapshot& a, const TableSnapshot& b);

/// Hash of the encoded table, 16 hexadecimal digits, as stored in a picture's header.
std::string cache_hash(RowSource& rows);
std::string cache_hash(const TableSnapshot& image);

}  // namespace tress::inline v0_2::adaptive
