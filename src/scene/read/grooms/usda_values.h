// Attributes of a prim in a USD text: their values, and the transforms that they say.
#pragma once

#include <glm/ext/matrix_double4x4.hpp>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/read/grooms/groom_builder.h"
#include "scene/read/grooms/text_cursor.h"

namespace tress::scene {

/// The numbers of a value, brackets taken off, or its words: "bspline", ["xformOp:translate"]. Of time samples the
/// first.
struct UsdaValue {
  std::vector<float> numbers;
  std::vector<double> precise;  ///< instead, where few numbers were asked for in full
  std::vector<std::string> texts;
  std::optional<AttributeScope> scope;  ///< its interpolation
  bool is_animated = false;             ///< there were more time samples
};

/// What stands behind the "=" of an attribute; samples: it is a table of time samples. precise: as double.
UsdaValue read_usda_value(TextCursor* text, bool samples, bool precise);

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
