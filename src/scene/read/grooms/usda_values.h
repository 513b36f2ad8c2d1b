// Attributes of a prim in a USD text: their values, and the transforms that they say.
#pragma once

#include <cstdint>
#include <glm/ext/matrix_double4x4.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/read/grooms/groom_builder.h"
#include "scene/read/grooms/text_cursor.h"

namespace tress::scene {

/// The numbers of a value, brackets taken off, or its words: "bspline", ["xformOp:translate"]. Of time samples the
/// first, or those of a frame: numbers with a fraction linear between the samples around it, the rest, and
/// those of which the next sample has another number, of the one before. None has no numbers.
struct UsdaValue {
  std::vector<float> numbers;
  std::vector<double> precise;     ///< instead, where few numbers were asked for in full
  std::vector<glm::vec3> triples;  ///< instead, where they were asked for by three; `numbers` has what is left over
  std::vector<std::string> texts;
  std::optional<AttributeScope> scope;  ///< its interpolation
  bool is_animated = false;             ///< there were more time samples
  /// The time of the sample that these are alone, where a frame is behind it: the next has another number, or there is
  /// none.
  std::optional<double> held_since = {};
};

/// As what the numbers of a value are kept.
enum class UsdaNumbers : std::uint8_t { floats, doubles, triples };

/// What stands behind the "=" of an attribute; samples: it is a table of time samples. frame: of them the one; unset:
/// the first. is_held: not to be met in between, as counts and ids.
UsdaValue read_usda_value(TextCursor* text, bool samples, UsdaNumbers kept_as, std::optional<double> frame = {},
                          bool is_held = false);

/// The metadata in parentheses behind an attribute, if there is any: its interpolation.
void read_usda_attribute_metadata(TextCursor* text, UsdaValue* value);

/// Of column vectors.
struct UsdaTransform {
  glm::dmat4 to_parent{1.0};
  bool resets = false;     ///< the transforms of its parents do not count (!resetXformStack!)
  std::string fault = {};  ///< an operation that is not known or has other numbers than it needs
};

/// The transform of a prim by its xformOpOrder and the operations that it names.
UsdaTransform usda_transform(const std::map<std::string, UsdaValue, std::less<>>& attributes);

}  // namespace tress::scene
