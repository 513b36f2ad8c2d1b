// Sets of curves, each with its basis, transform and attributes, into one groom.
#pragma once

#include <glm/ext/matrix_double4x4.hpp>
#include <optional>
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
  glm::dmat4 to_file{1.0};                   ///< of column vectors
  CurveAttribute<float> width = {};          ///< diameters, before the transform
  CurveAttribute<glm::vec3> color = {};      ///< linear RGB
  CurveAttribute<glm::vec3> normal = {};     ///< the minor axis, before the transform
  std::vector<std::int64_t> id = {};         ///< per curve, or empty
  std::vector<glm::vec2> root_uv = {};       ///< per curve, or empty
};

/// Collects them. What an attribute cannot give is said as an ignored attribute; what the curves cannot be is an error.
class GroomBuilder {
 public:
  /// `name` is the file named in errors.
  GroomBuilder(std::string name, std::string format);

  /// Fails where numbers do not fit each other or points are not finite. Curves too short for a segment stay as strands
  /// without points. All are drawn by one basis: where sets differ, as Bezier segments.
  std::optional<Error> add(CurveSet set);

  /// For remarks, units and what is ignored, before finish().
  GroomFile& file() { return file_; }

  /// Fails where there are no strands.
  Result<GroomFile> finish();

 private:
  std::optional<Error> check(const CurveSet& set) const;
  void choose_basis(const CurveSet& set);
  void add_widths(CurveSet* set, std::size_t old_points, bool as_given);
  void add_vectors(const CurveSet& set, const CurveAttribute<glm::vec3>& attribute, std::size_t old_points,
                   bool is_color);
  std::optional<AttributeScope> scope_of(const CurveSet& set, std::size_t values, std::optional<AttributeScope> said,
                                         const std::string& attribute);
  std::optional<Error> place(const CurveSet& set, std::size_t old_points);

  std::string name_;
  GroomFile file_;
};

}  // namespace tress::scene
