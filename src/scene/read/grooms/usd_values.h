// Attributes of a prim of USD: their values, and their transforms.
#pragma once

#include <cstdint>
#include <glm/ext/matrix_double4x4.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scene/read/grooms/groom_builder.h"

namespace tress::scene {

/// The numbers of a value without brackets, or its words: "bspline", ["xformOp:translate"]. Time samples give the first
/// one, or the value at a frame. Numbers with a fraction are linear between the samples around it. All others, and
/// those whose count differs in the next sample, are taken from the sample before.
struct UsdValue {
  std::vector<float> numbers;
  std::vector<double> precise;     ///< used instead, if few numbers were requested in full precision
  std::vector<glm::vec3> triples;  ///< used instead, if triples were requested; `numbers` has the rest
  std::vector<std::string> texts;
  std::optional<AttributeScope> scope;  ///< its interpolation
  bool is_animated = false;             ///< there were more time samples
  bool is_blocked = false;              ///< the file says `None`: no value, also not a default
  std::string not_read = {};            ///< why the file has numbers or words that are not here; usually empty
  /// The time of the one sample that the values come from, if the frame is after it and the next sample has another
  /// count or does not exist.
  std::optional<double> held_since = {};
};

/// The form in which the numbers of a value are kept. Quaternions are doubles, between samples on the shorter way.
enum class UsdNumbers : std::uint8_t { floats, doubles, triples, quaternions };

/// A transform, for column vectors.
struct UsdTransform {
  glm::dmat4 to_parent{1.0};
  bool resets = false;       ///< whether it ignores the transforms of its parents (!resetXformStack!)
  std::string fault = {};    ///< an operation that is unknown or has the wrong numbers
  std::string missing = {};  ///< one that has no value
};

/// The rotation of a quaternion, real part first, of any length; none for 0.
glm::dmat4 usd_rotation(const double* quaternion);

/// The transform of a prim from its xformOpOrder and the operations that it names.
UsdTransform usd_transform(const std::map<std::string, UsdValue, std::less<>>& attributes);

}  // namespace tress::scene
