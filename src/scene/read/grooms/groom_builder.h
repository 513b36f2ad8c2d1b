// Collects sets of curves, each with its basis, transform and attributes, into one groom.
#pragma once

#include <glm/ext/matrix_double4x4.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "scene/read/grooms/curve_bases.h"
#include "scene/read/grooms/groom_file.h"

namespace tress::scene {

/// How often an attribute is given: once, per curve, where segments meet, or per vertex; if the file does not record
/// it, it follows from the number of values.
enum class AttributeScope : std::uint8_t { constant, uniform, varying, vertex };

std::string words(AttributeScope scope);

template <class T>
struct CurveAttribute {
  std::vector<T> values = {};  ///< empty if the file has none
  std::optional<AttributeScope> scope = {};
  std::string name = {};  ///< in the file, for remarks
};

/// Curves of one prim of a file.
struct CurveSet {
  std::string name;  ///< path of the prim
  CurveKind kind;
  std::vector<std::uint32_t> vertex_counts;  ///< per curve
  std::vector<glm::vec3> vertices;           ///< their sum
  /// For cubic B-splines that are not periodic: as many as all vertices plus 4 for each curve, or plus 2 if the
  /// outermost ones are left out; empty: uniform.
  std::vector<double> knots = {};
  glm::dmat4 to_file{1.0};                ///< for column vectors
  CurveAttribute<float> width = {};       ///< diameters, before the transform
  CurveAttribute<glm::vec3> color = {};   ///< linear RGB
  CurveAttribute<glm::vec3> normal = {};  ///< the minor axis, before the transform
  std::vector<std::int64_t> id = {};      ///< per curve, or empty
  std::vector<glm::vec2> root_uv = {};    ///< per curve, or empty
};

/// The curves of a set for which `keep` is not 0, with their attributes; attributes whose number fits neither the
/// vertices nor the curves are dropped.
CurveSet part_of(const CurveSet& set, std::span<const unsigned char> keep);

/// Replaces every strand from `from` on that has a non-finite point by a single point, and records it as broken.
/// Returns a remark about them, or nothing if there are none.
std::optional<IgnoredAttribute> leave_out_broken(const std::string& set, std::size_t from, GroomFile* file);

/// The color clamped to [0, 1], where NaN becomes 0. Counts the colors that this changes by more than rounding.
glm::vec3 clamped_color(glm::vec3 color, std::uint64_t* changed);
constexpr const char* why_clamped = "they are clamped to [0, 1]";

/// Whether a matrix is a rotation, a uniform scale as instances of a scene may have it, and a translation, but for the
/// rounding of floats.
bool is_similarity(const glm::dmat4& matrix);

/// Collects the sets. Attributes with an invalid number of values, and sets whose numbers do not fit each other, are
/// reported as ignored attributes.
class GroomBuilder {
 public:
  /// `name` is the file named in errors.
  GroomBuilder(std::string name, std::string format);

  /// Adds a set. Curves too short for a segment stay as strands without points, and those with a non-finite point as
  /// broken ones. All are drawn with one basis; if sets differ, as Bezier segments. Fails if there are more points than
  /// a file may have.
  std::optional<Error> add(CurveSet set);

  /// Begins a prototype: the sets that follow are in its coordinates, and are drawn only where it has an instance.
  /// Prototypes may be in one another.
  void begin_prototype();
  /// Ends the one that began last. Returns its number.
  std::size_t end_prototype();
  bool is_in_prototype() const { return open_.size() > 1; }
  /// Whether instances at a place can share strands: a rotation, a uniform scale > 0 and a translation. If not, a
  /// remark says that they are copies.
  bool can_share(const glm::dmat4& to_parent);
  /// Draws a prototype once more, in the coordinates of the one that is open, or of the file. to_parent: that
  /// can_share(). Fails if there are more than a groom may have.
  std::optional<Error> add_instance(std::size_t prototype, const glm::dmat4& to_parent);

  /// Reports once something that no picture will show.
  void ignore(const std::string& name, const std::string& why);

  /// Gives access to remarks, units and ignored attributes, before finish().
  GroomFile& file() { return file_; }

  /// Fails if there are no strands: with the error of the first set that was left out, else with a list of unused data.
  Result<GroomFile> finish();

 private:
  std::optional<Error> check(const CurveSet& set) const;
  std::optional<Error> check_size(const CurveSet& set) const;
  bool bend_by_knots(CurveSet* set);
  void choose_basis(const CurveSet& set);
  void add_widths(CurveSet* set, std::size_t old_points, bool as_given);
  void add_vectors(const CurveSet& set, const CurveAttribute<glm::vec3>& attribute, std::size_t old_points,
                   bool is_color);
  std::optional<AttributeScope> scope_of(const CurveSet& set, std::size_t values, std::optional<AttributeScope> said,
                                         const std::string& attribute);
  void place(const CurveSet& set, std::size_t old_points, std::size_t old_strands);

  /// Sets that follow each other in a prototype, by numbers of strands and parts.
  struct Run {
    std::size_t first, end, first_part, end_part;
  };
  struct Drawn {
    std::size_t run;
    glm::dmat4 place;
  };
  void extend_run(std::size_t old_strands);

  std::string name_;
  GroomFile file_;
  std::vector<Run> runs_;
  bool is_run_open_ = false;
  std::vector<std::vector<Drawn>> open_{1};  ///< what the file draws, then the prototypes that are open
  std::vector<std::vector<Drawn>> prototypes_;
  std::size_t instances_ = 0;
  bool has_copies_ = false;
  std::optional<Error> fault_;  ///< error of the first set that was left out
  std::set<std::string> ignored_;
};

}  // namespace tress::scene
