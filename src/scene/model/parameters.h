// All keys of a scene file and numbers of the command line: ranges, units, defaults, and one sentence each. Readers,
// options, messages, Python's classes, scenes/schema.json and the tables of scenes/KEYS.md follow this one table. A
// new number of a material is a row here, and in scene.h a member of Material and a row of `material_numbers`; tests
// write the schema and the tables then (TRESS_REWRITE=1 in the environment, Parameters.*), and the build the classes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tress::scene {

constexpr double world_cm = 1e6;                                   ///< largest distance of a coordinate from the origin
constexpr std::int64_t most_image_pixels = std::int64_t{1} << 26;  ///< width times height
constexpr double past_int64 = 9223372036854775808.0;               ///< 2^63; a range that ends here includes 2^63 - 1
constexpr double past_uint64 = 2 * past_int64;                     ///< 2^64; a range that ends here includes 2^64 - 1

/// A range that includes both ends unless they are open.
struct Range {
  double least, most;
  bool least_open = false, most_open = false;

  /// Returns false for NaN.
  constexpr bool contains(double x) const {
    return (least_open ? x > least : x >= least) && (most_open ? x < most : x <= most);
  }
  friend constexpr bool operator==(const Range&, const Range&) = default;
};

/// The type of a value. If numbers are by name, `choices` are the names and the value is an object. `either`: three
/// numbers, or one of the choices. number_or_choice: one number, or one of the choices.
enum class ValueKind {
  number,
  whole,
  triple,
  numbers_by_name,
  triples_by_name,
  either,
  number_or_choice,
  choice,
  text,
  flag,
  only_true
};

struct Parameter {
  std::string_view key;     ///< in a scene file, with N for every index, "/materials/N/eta"; empty: none
  std::string_view option;  ///< of the command line, "--spp"; empty: none
  ValueKind kind = ValueKind::number;
  Range range{0, 0};         ///< for every number
  std::string_view unit;     ///< "degrees", "cm"; empty: a plain number
  std::string_view choices;  ///< "y, z"
  std::string_view usual;    ///< the default in words; "needed" if it must be given; empty: none
  std::string_view sentence;
  bool varies = false;  ///< whether a source may replace it (source.h)
};

/// All parameters; keys are in the order of the documentation, followed by options without a key.
std::span<const Parameter> parameters();

/// Finds a parameter by the place of a value in a scene file, "/materials/3/gain/TT": any index matches, and names are
/// those of the row. Null if there is no such parameter.
const Parameter* parameter_at(std::string_view place);

/// The keys of the object at a place of a scene file, in the order of the table: "/materials/3" has name, eta and so
/// on.
std::vector<std::string> keys_at(std::string_view place);

/// The choices of a parameter one by one, in the order of the table.
std::vector<std::string> choices_of(const Parameter& parameter);

/// Finds a parameter by the name of an option, "--spp", which must exist. An option has one meaning and range in every
/// command.
const Parameter& option_parameter(std::string_view option);

/// The range in words: "0.5..1", "0.5..45 degrees", "a whole number, 1..65536", "a number > 0 and <= 1".
std::string words(const Parameter& parameter);

}  // namespace tress::scene
