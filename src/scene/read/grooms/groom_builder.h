// Sets of curves, each with its basis, transform and attributes, into one groom.
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

/// How often an attribute is given: once, a curve, where segments meet, a vertex; unset in a file: by its number.
enum class AttributeScope : std::uint8_t { constant, uniform, varying, vertex };

std::string words(AttributeScope scope);

template <class T>
struct CurveAttribute {
  std::vector<T> values = {};  ///< empty: the file has none
  std::optional<AttributeScope> scope = {};
  std::string name = {};  ///< in the file, for remarks
};

/// Curves as a prim of a file has them.
struct CurveSet {
  std::string name;  ///< path of the prim
  CurveKind kind;
  std::vector<std::uint32_t> vertex_counts;  ///< per curve
  std::vector<glm::vec3> vertices;           ///< their sum
  /// Of cubic B-splines that are not periodic: as many more a curve than its vertices as 4, or as 2 where the outermost
  /// are left out; empty: uniform.
  std::vector<double> knots = {};
  glm::dmat4 to_file{1.0};                ///< of column vectors
  CurveAttribute<float> width = {};       ///< diameters, before the transform
  CurveAttribute<glm::vec3> color = {};   ///< linear RGB
  CurveAttribute<glm::vec3> normal = {};  ///< the minor axis, before the transform
  std::vector<std::int64_t> id = {};      ///< per curve, or empty
  std::vector<glm::vec2> root_uv = {};    ///< per curve, or empty
};

/// The curves of a set for which `keep` is not 0, with their attributes; those whose number fits neither the vertices
/// nor the curves go.
CurveSet part_of(const CurveSet& set, std::span<const unsigned char> keep);

/// Makes one point of every strand from `from` on that has a point that is not finite, and notes it as broken; what to
/// say of them, nothing where there are none.
std::optional<IgnoredAttribute> leave_out_broken(const std::string& set, std::size_t from, GroomFile* file);

/// Collects them. What an attribute cannot give is said as an ignored attribute, and so are sets whose numbers do not
/// fit each other.
class GroomBuilder {
 public:
  /// `name` is the file named in errors.
  GroomBuilder(std::string name, std::string format);

  /// Curves too short for a segment stay as strands without points, and those with a point that is not finite as broken
  /// ones. All are drawn by one basis: where sets differ, as Bezier segments. Fails where there are more points than a
  /// file may have.
  std::optional<Error> add(CurveSet set);

  /// Names something that no picture will show, once.
  void ignore(const std::string& name, const std::string& why);

  /// For remarks, units and what is ignored, before finish().
  GroomFile& file() { return file_; }

  /// Fails where there are no strands: by the fault of the first set that was left out, else by what is not used.
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

  std::string name_;
  GroomFile file_;
  std::optional<Error> fault_;  ///< of the first set that was left out
  std::set<std::string> ignored_;
};

}  // namespace tress::scene
