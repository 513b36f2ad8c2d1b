// A cache as a source of rows, from bytes that may hold anything. Everything is checked before it is used: each section
// against its checksum, each count against the bytes that remain, each value against its range.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cache/byte_source.h"
#include "cache/format.h"
#include "tress/adaptive/cache.h"

namespace tress::inline v0_2::adaptive {

/// Stops at the first fault: error() reports it, and no more slices or rows follow until rewind().
class CacheReader final : public RowSource {
 public:
  /// `bytes` must outlive it; `name` stands for the file in errors.
  CacheReader(const ByteSource& bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  /// Reads and checks the whole file. Call it first; use the other functions only if it returns true.
  bool check(const std::string& wanted_model);
  /// Set by check().
  const CacheContents& contents() const { return contents_; }
  const Error& error() const { return *error_; }

  const std::string& model() const override { return model_; }
  void rewind() override { begin(format::Section::sketches); }
  /// Begins to read this many rows of one slice, from the bytes of sections rows and sketches, instead of a whole file.
  void begin_rows(const SliceDescription& slice, std::uint32_t rows, const ByteSource& table,
                  const ByteSource& sketches);
  const SliceDescription* next_slice() override;
  const CachedRow* next_row() override;
  std::optional<Error> failure() const override { return error_; }

 private:
  struct Frame {
    std::size_t start = 0, size = 0;  ///< place of the payload, in bytes
  };

  // Each reads one section.
  bool header(ByteReader& in, std::uint64_t* hash);
  bool frame(ByteReader& in, format::Section section);
  bool read_model();
  bool same_model(const std::string& wanted, std::uint64_t hash);
  /// Reads to the end of all sections up to this one.
  bool read_to_the_end(format::Section deepest);
  bool checksum_of(std::size_t start, std::size_t size, std::uint64_t* sum);

  // The steps of read_to_the_end() and of a round by next_slice() and next_row(). They read only sections up to
  // `deepest`.
  void begin(format::Section deepest);
  bool reads(format::Section section) const { return section <= deepest_; }
  bool end_of(format::Section section);
  bool end_of_slices();
  bool slice(ByteReader& in);
  bool axis(ByteReader& in, const char* what, std::uint32_t size, std::vector<float>* coordinates);
  bool row(ByteReader& in);
  /// Checks a row of knots and counts it. No program reads such rows any more.
  bool skip_knots(ByteReader& in, std::uint32_t number_of_knots);
  bool ribbons(ByteReader& in, std::uint32_t parts);
  bool mixture(ByteReader& in, std::uint32_t components);
  bool sketch(ByteReader& in);

  bool count(ByteReader& in, std::size_t size, const char* what, std::uint32_t* number);
  bool number(ByteReader& in, const char* what, float least, float largest, float* value);
  bool not_negative(ByteReader& in, const char* what, float* value);

  ByteReader& reader(format::Section section) { return readers_[static_cast<std::size_t>(section) - 1]; }
  std::string here(const ByteReader& in, std::size_t back = 0) const;
  bool fail(std::string place, std::string expected, std::string found);

  const ByteSource& bytes_;
  std::string name_;
  std::string model_;
  std::uint32_t version_ = 0;
  std::array<Frame, format::section_count> frames_{};
  CacheContents contents_;
  std::optional<Error> error_;

  format::Section deepest_ = format::Section::sketches;
  std::array<ByteReader, format::section_count> readers_{};
  format::Section where_ = format::Section::model;  ///< the section being read, for errors
  bool begun_ = false;                              ///< the number of slices has been read
  std::uint32_t slices_left_ = 0, rows_left_ = 0, least_node_ = 0;
  bool has_slice_ = false;  ///< slice_ has been read in this round
  SliceDescription slice_;
  CachedRow row_;
  std::uint64_t knot_rows_ = 0;                                 ///< rows of knots so far in this round
  std::uint32_t bins_ = 0;                                      ///< bins of each sketch of the slice
  std::uint32_t needed_version_ = format::version_of_mixtures;  ///< the lowest version that can hold what was read
};

}  // namespace tress::inline v0_2::adaptive
