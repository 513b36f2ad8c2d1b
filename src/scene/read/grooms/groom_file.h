// The result of every reader of strands: a groom in its file's units and axes.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/ext/matrix_double4x4.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene/model/scene.h"
#include "tress/base/error.h"

namespace tress::scene {

/// One set of curves of the file, for display: a prim, an object, or the whole file.
struct GroomPart {
  std::string name;              ///< its path in the file; empty if the format has none
  std::uint64_t strands = 0;     ///< before any are left out
  std::uint64_t points = 0;      ///< number in the file
  std::string curve = "points";  ///< such as "cubic bspline, pinned"
  std::uint64_t instances = 1;   ///< how often they are drawn
};

/// Strands that the file draws at several places: instances, which share them.
struct SharedStrands {
  std::uint32_t first = 0, end = 0;
  /// By instance, at the moments of the shutter: from the coordinates of its points to those of the file, in its unit;
  /// each a rotation, a uniform scale > 0 and a translation.
  std::vector<std::vector<glm::dmat4>> places = {};
  /// Whether the points are in the file's coordinates, where the first instance is when the shutter opens; else in
  /// those of the prototype, without GroomFile::origin.
  bool is_settled = false;
};

/// Data of the file that no picture will show.
struct IgnoredAttribute {
  std::string name, why;
};

/// The width of strands without one, beside others that have some. Any width below 0 means the same, because conversion
/// between bases rounds.
constexpr float width_not_said = -1;

/// Strands of the file, including degenerate ones, with the transforms of the file applied. Arrays per point follow
/// `points`, arrays per strand the strands; an empty one was not in the file.
struct GroomFile {
  std::string format;                      ///< "a .hair groom"
  std::vector<GroomPart> parts = {};       ///< at least one
  std::vector<SharedStrands> shared = {};  ///< by rising `first`; other strands are drawn once
  std::optional<StrandBasis> basis = {};   ///< for all strands; unset if the file does not record it
  std::vector<std::uint32_t> first_point;  ///< strand count + 1 entries, the first 0, valid for the basis
  std::vector<glm::vec3> points;           ///< finite, within largest_coordinate
  /// The points at later moments of the shutter, with the same number and guarantees; `points` are at its opening.
  /// Empty if they rest.
  std::vector<std::vector<glm::vec3>> later = {};
  /// Widths at the later moments, in the form of `width`, which must then be there too; empty if they do not change.
  std::vector<std::vector<float>> later_width = {};
  glm::dvec3 origin{0.0};    ///< has been subtracted from all points (GroomInput::origin)
  bool is_animated = false;  ///< whether the file has other samples for other times
  /// Per point, a diameter, finite, >= 0, or width_not_said; empty: default_width. A strand is invisible where it is 0.
  std::vector<float> width = {};
  float default_width = 0;                 ///< 0 if the file has none
  std::vector<glm::vec3> color = {};       ///< linear RGB in [0, 1], per point or per strand, by its size
  glm::vec3 default_color{0.0f};           ///< if `color` is empty
  bool has_color = false;                  ///< whether the file has any color
  std::string attribute = "color";         ///< the attribute from which the color was read, if another was requested
  std::vector<glm::vec3> normal = {};      ///< per point: along the minor axis of the cross-section, any length
  std::vector<std::int64_t> id = {};       ///< per strand
  std::vector<glm::vec2> root_uv = {};     ///< per strand
  std::optional<double> cm_per_unit = {};  ///< from the file
  std::optional<bool> y_up = {};           ///< from the file: whether y is up, else z
  /// Strands with non-finite points, by rising index: all their points are equal, and they are not drawn.
  std::vector<std::uint32_t> broken = {};
  std::vector<std::string> remarks = {};    ///< choices and conversions
  std::vector<std::string> materials = {};  ///< descriptions of the file's materials, one text each
  std::vector<IgnoredAttribute> ignored = {};

  std::size_t strand_count() const { return first_point.empty() ? 0 : first_point.size() - 1; }
  /// The width of a point; negative if it is not given.
  float width_at(std::size_t point) const { return width.empty() ? default_width : width[point]; }
  glm::vec3 color_at(std::size_t strand, std::size_t point) const {
    return color.empty() ? default_color : color[color.size() == points.size() ? point : strand];
  }
};

/// Coordinates and widths beyond this mean a damaged file: their squares must stay far from overflow.
constexpr float largest_coordinate = 1e9f;
/// Converts to float; values too large for a float become infinite.
inline float to_float(double x) {
  constexpr double most = std::numeric_limits<float>::max();
  if (x > most) return std::numeric_limits<float>::infinity();
  return x < -most ? -std::numeric_limits<float>::infinity() : static_cast<float>(x);
}
/// A name of a file that is safe to print: control characters could move a terminal's cursor.
inline std::string printable(std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = '?';
  return name;
}
/// The largest number of points or strands in a file: indices have 32 bits.
constexpr std::uint64_t most_groom_points = 0xffffffffu;
/// The largest number of instances in a groom.
constexpr std::size_t most_instances = 1'000'000;

/// Called with a part of a file's bytes that has been read and will hardly be read again. May be empty.
using DoneWith = std::function<void(std::span<const unsigned char>)>;
/// The number of bytes that readers read between two such calls.
constexpr std::size_t done_block = std::size_t{8} << 20;

/// Parts of a file may share bytes, names or layers, but no valid file expands to this many times its own size.
constexpr std::uint64_t most_sharing = 16;

/// A file to be read, and further requests to its reader.
struct GroomInput {
  std::span<const unsigned char> bytes;
  std::string name;  ///< the file's name in errors
  /// Reads another file that this one names, relative to it; empty: other files may not be read.
  std::function<Result<std::vector<unsigned char>>(const std::string& path)> other_file = {};
  std::optional<std::uint32_t> points_per_strand = {};  ///< for formats that do not record it
  /// The attribute to be read instead of the color, for formats with named attributes: three numbers, or one, which is
  /// used for all three. Empty: the color.
  std::string attribute = {};
  DoneWith done_with = {};
  /// The frame for animated data: linear between the samples around it, constant beyond the first and last; unset: the
  /// first sample.
  std::optional<double> frame = {};
  /// The frame rate for formats that count in seconds; unset: the file's own, or 24 if it has none.
  std::optional<double> frames_per_second = {};
  /// The point that becomes 0, in the file's units and axes, for formats that have transforms: it is subtracted in
  /// double before coordinates are rounded to floats.
  glm::dvec3 origin{0.0};
};

}  // namespace tress::scene
