// The container of Alembic's files since 2013: groups of groups and data, and the properties that they represent.
//
// A file begins with `Ogawa`, 255 once it is closed, version 1 (u16, big endian) and the u64 place of the root group;
// the rest is little endian. A group is a u64 number of children and a u64 each, whose top bit says data. Data are a
// u64 size and bytes, samples behind a key of 16. Types: 0 bool, 1 u8, 2 i8, 3 u16, 4 i16, 5 u32, 6 i32, 7 u64, 8 i64,
// 9 f16, 10 f32, 11 f64.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/read/grooms/groom_file.h"
#include "tress/base/error.h"

namespace tress::scene {

/// A property of an object, from its header.
struct OgawaProperty {
  enum class Kind : std::uint8_t { compound, scalar, array };
  std::string name, metadata;
  bool is_text() const { return pod >= 12; }
  Kind kind = Kind::compound;
  std::uint8_t pod = 0;      ///< type of a number, in the file's code (above)
  std::uint32_t extent = 1;  ///< numbers in a value
  std::uint64_t samples = 0;
  std::uint64_t first_change = 1, last_change = 0;  ///< samples before the first and after the last change equal those
  std::uint32_t time_sampling = 0;
  std::uint64_t group = 0;  ///< place of its samples or its properties; 0: none

  /// The metadata value for a key such as "geoScope"; empty if it is missing.
  std::string_view value_of(std::string_view key) const;
};

/// The samples around a time, and its position between them.
struct OgawaMoment {
  std::uint64_t before = 0, after = 0;
  double share = 0;
};

struct OgawaObject {
  std::string name, metadata;
  std::uint64_t group = 0;
};

/// Reads within the bytes only. It keeps the first failure; afterwards everything is empty.
class OgawaFile {
 public:
  /// `name` is the file named in errors, which give the byte. The bytes must outlive it. done_with: called for long
  /// samples.
  OgawaFile(std::span<const unsigned char> bytes, std::string name, DoneWith done_with = {});

  const OgawaObject& top() const { return top_; }
  std::vector<OgawaObject> children(const OgawaObject& object);
  std::vector<OgawaProperty> properties(const OgawaObject& object);
  std::vector<OgawaProperty> properties(const OgawaProperty& compound);

  /// The samples around a time in seconds; the first or the last beyond them.
  OgawaMoment around(const OgawaProperty& property, double seconds) const;
  /// The number of frames per second at which the archive was written: from its metadata, else from the distance of
  /// samples if these do not fall on frames of 24 per second. Empty if neither gives it.
  std::optional<double> frames_per_second() const;
  /// The time of a sample, seconds; 0 if it is not recorded.
  double seconds_of(const OgawaProperty& property, std::uint64_t sample) const;
  /// A sample, without its key; empty if it is missing.
  std::span<const unsigned char> sample(const OgawaProperty& property, std::uint64_t index = 0);
  /// The numbers of a sample, converted from any type.
  std::vector<float> floats(const OgawaProperty& property, std::uint64_t index = 0);
  std::vector<double> doubles(const OgawaProperty& property, std::uint64_t index = 0);
  std::vector<std::int64_t> integers(const OgawaProperty& property, std::uint64_t index = 0);

  /// The text of a property, to its first 0 character; empty if it has none.
  std::string text(const OgawaProperty& property);

  void fail(std::uint64_t byte, std::string expected, std::string found);
  const std::optional<Error>& error() const { return error_; }

 private:
  struct Group {
    std::uint64_t at = 0, children = 0;
  };

  Group group(std::uint64_t at);
  std::uint64_t child(const Group& group, std::uint64_t index);
  std::span<const unsigned char> data(std::uint64_t child);
  template <class T>
  T read(std::uint64_t at);
  template <class T>
  std::vector<T> numbers(const OgawaProperty& property, std::uint64_t index);
  void read_metadata(std::span<const unsigned char> bytes);
  void read_time_samplings(std::span<const unsigned char> bytes);
  std::vector<OgawaProperty> properties_of(std::uint64_t group);

  std::span<const unsigned char> bytes_;
  std::string name_;
  DoneWith done_with_;
  std::vector<std::string> metadata_{""};
  struct TimeSampling {
    double period = 1;
    std::vector<double> times;  ///< times of a period, at least one
    double of(std::uint64_t sample) const;
  };
  std::vector<TimeSampling> time_samplings_;
  OgawaObject top_;
  std::string archive_metadata_;
  std::uint64_t left_;  ///< number of groups that may still be visited: the file's size limits it
  std::optional<Error> error_;
};

}  // namespace tress::scene
