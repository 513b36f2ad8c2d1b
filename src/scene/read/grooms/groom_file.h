// What every reader of strands fills: a groom as its file has it, in the file's units and axes.
#pragma once

#include <cstdint>
#include <functional>
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

/// One set of curves of the file: a prim, an object, or the whole of it. For people.
struct GroomPart {
  std::string name;              ///< its path in the file; empty where the format has none
  std::uint64_t strands = 0;     ///< before any are left out
  std::uint64_t points = 0;      ///< as written
  std::string curve = "points";  ///< "cubic bspline, pinned"
};

/// Something of the file that no picture will show.
struct IgnoredAttribute {
  std::string name, why;
};

/// Of strands without widths beside others that have some; so is every width below 0, by the rounding of bases.
constexpr float width_not_said = -1;

/// Strands as the file has them, degenerate ones included, transforms of the file applied. Arrays a point follow
/// `points`, arrays a strand the strands; an empty one was not in the file.
struct GroomFile {
  std::string format;                      ///< "a .hair groom"
  std::vector<GroomPart> parts = {};       ///< at least one
  std::optional<StrandBasis> basis = {};   ///< of all strands; unset: the file does not say
  std::vector<std::uint32_t> first_point;  ///< strand count + 1 entries, the first 0; as the basis needs them
  std::vector<glm::vec3> points;           ///< finite, within largest_coordinate
  /// Where the points are at later moments of the shutter, as many each, with the same promises; `points` are those
  /// of its opening. Empty: they rest.
  std::vector<std::vector<glm::vec3>> later = {};
  /// Widths at the later moments, as `width`, which has them then too; empty: they stay.
  std::vector<std::vector<float>> later_width = {};
  bool is_animated = false;  ///< the file has other samples for other times
  /// Per point, a diameter, finite, >= 0, or width_not_said; empty: default_width. Where it is 0 nothing is seen.
  std::vector<float> width = {};
  float default_width = 0;                 ///< 0: the file has none
  std::vector<glm::vec3> color = {};       ///< linear RGB in [0, 1], per point or, as many, per strand
  glm::vec3 default_color{0.0f};           ///< where `color` is empty
  bool has_color = false;                  ///< whether the file has any color
  std::string attribute = "color";         ///< what of the file the color is, where another attribute was asked for
  std::vector<glm::vec3> normal = {};      ///< per point: along the minor axis of the cross-section, any length
  std::vector<std::int64_t> id = {};       ///< per strand
  std::vector<glm::vec2> root_uv = {};     ///< per strand
  std::optional<double> cm_per_unit = {};  ///< as the file says
  std::optional<bool> y_up = {};           ///< y of the file is up, else z, as the file says
  /// Strands with points that are not finite, by rising index: all their points are one, and they are not drawn.
  std::vector<std::uint32_t> broken = {};
  std::vector<std::string> remarks = {};    ///< what was chosen, what was converted
  std::vector<std::string> materials = {};  ///< what it says of them, one text each
  std::vector<IgnoredAttribute> ignored = {};

  std::size_t strand_count() const { return first_point.empty() ? 0 : first_point.size() - 1; }
  /// Of the point, which belongs to the strand.
  float width_at(std::size_t point) const { return width.empty() ? default_width : width[point]; }
  glm::vec3 color_at(std::size_t strand, std::size_t point) const {
    return color.empty() ? default_color : color[color.size() == points.size() ? point : strand];
  }
};

/// Coordinates and widths beyond this are damage: their squares must stay far from overflow.
constexpr float largest_coordinate = 1e9f;
/// As a float; what a float cannot hold is infinite.
inline float to_float(double x) {
  constexpr double most = std::numeric_limits<float>::max();
  if (x > most) return std::numeric_limits<float>::infinity();
  return x < -most ? -std::numeric_limits<float>::infinity() : static_cast<float>(x);
}
/// A name of a file as it may be told: control characters could move a terminal's cursor.
inline std::string printable(std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = '?';
  return name;
}
/// No file may have more of either: indices have 32 bits.
constexpr std::uint64_t most_groom_points = 0xffffffffu;

/// Told of a part of a file's bytes that has been read and will hardly be looked at again. Unset: nobody asks.
using DoneWith = std::function<void(std::span<const unsigned char>)>;
/// How much readers read before they tell it.
constexpr std::size_t done_block = std::size_t{8} << 20;

/// A file to be read, and what a reader may ask for besides.
struct GroomInput {
  std::span<const unsigned char> bytes;
  std::string name;  ///< of the file, in errors
  /// The bytes of another file that this one names, relative to it; unset: other files may not be read.
  std::function<Result<std::vector<unsigned char>>(const std::string& path)> other_file = {};
  std::optional<std::uint32_t> points_per_strand = {};  ///< of formats that do not say
  /// To be read in place of the color, by formats that have attributes with names: three numbers, or one, which counts
  /// for all three. Empty: the color.
  std::string attribute = {};
  DoneWith done_with = {};
  /// Of what is animated: linear between the samples around it, the first or last beyond them; unset: the first sample.
  std::optional<double> frame = {};
  /// Of formats that count in seconds; unset: the file's own, or 24 where it says none.
  std::optional<double> frames_per_second = {};
};

}  // namespace tress::scene
