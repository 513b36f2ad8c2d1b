#include "scene/read/grooms/usda_values.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/ext/matrix_transform.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <string>
#include <type_traits>
#include <utility>

namespace tress::scene {
namespace {

void keep(double x, UsdaNumbers kept_as, UsdaValue* value) {
  if (kept_as == UsdaNumbers::doubles) return value->precise.push_back(x);
  std::vector<float>& numbers = value->numbers;
  numbers.push_back(to_float(x));
  if (kept_as == UsdaNumbers::floats || numbers.size() < 3) return;
  value->triples.emplace_back(numbers[0], numbers[1], numbers[2]);
  numbers.clear();
}

/// Reads numbers and texts of a value with all its brackets. For a long one, memory for as many triples as its commas
/// allow is allocated once, because a growing vector copies itself. Text that is counted is read next, so that none is
/// counted twice.
void read_items(TextCursor* text, UsdaNumbers kept_as, UsdaValue* value) {
  if (kept_as == UsdaNumbers::triples && text->peek() == '[')
    value->triples.reserve((text->commas_before(']') + 1) / 3 + 1);
  int depth = 0;
  do {
    const char c = text->peek();
    if (c == '[' || c == '(') {
      text->take(c);
      if (++depth > 8) return text->fail("at most 8 brackets in one another", "more");
    } else if (c == ']' || c == ')') {
      if (depth == 0) return text->fail_here("a value");
      text->take(c);
      --depth;
    } else if (c == ',') {
      if (depth == 0) return text->fail_here("a value");
      text->take(c);
    } else if (c == '"' || c == '\'') {
      value->texts.emplace_back(text->quoted());
    } else if (c == '@' || c == '<' || c == '{') {
      text->skip_value();
    } else if (depth == 0 && text->peek_word() == "None") {
      text->word();
    } else if (c == 'N' || c == 't' || c == 'f' || c == 'T' || c == 'F') {  // None, true, false
      value->texts.emplace_back(text->word());
    } else {
      keep(text->number(), kept_as, value);
    }
  } while (depth > 0 && !text->error());
}

glm::dmat4 rotation(const std::string& axes, const std::vector<double>& degrees) {
  // rotateXYZ turns about x first: for column vectors, z y x.
  glm::dmat4 turn(1.0);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto axis = static_cast<int>(axes[i] - 'X');
    glm::dvec3 about(0.0);
    about[axis] = 1;
    const double angle = degrees[axes.size() == 1 ? 0 : static_cast<std::size_t>(axis)] * std::numbers::pi / 180;
    turn = glm::rotate(glm::dmat4(1.0), angle, about) * turn;
  }
  return turn;
}

glm::dmat4 of_quaternion(const std::vector<double>& q) {
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(size > 0)) return glm::dmat4(1.0);
  const double w = q[0] / size, x = q[1] / size, y = q[2] / size, z = q[3] / size;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0},
          {0, 0, 0, 1}};
}

/// Applies one operation such as "translate" with its numbers; false if it is unknown or has the wrong numbers.
bool operation(const std::string& kind, const std::vector<double>& n, glm::dmat4* out) {
  if (kind == "translate" && n.size() == 3) {
    *out = glm::translate(glm::dmat4(1.0), glm::dvec3(n[0], n[1], n[2]));
  } else if (kind == "scale" && n.size() == 3) {
    *out = glm::scale(glm::dmat4(1.0), glm::dvec3(n[0], n[1], n[2]));
  } else if (kind == "orient" && n.size() == 4) {
    *out = of_quaternion(n);
  } else if (kind == "transform" && n.size() == 16) {
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) (*out)[c][r] = n[static_cast<std::size_t>(4 * c + r)];
  } else if (kind.starts_with("rotate")) {
    const std::string axes = kind.substr(6);
    static constexpr const char* known[] = {"X", "Y", "Z", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"};
    if (std::ranges::find(known, axes) == std::end(known) || n.size() != axes.size()) return false;
    *out = rotation(axes, n);
  } else {
    return false;
  }
  return true;
}

/// Adds to numbers a share of the way to those after them; false if their counts differ.
bool meet(const UsdaValue& after, float share, UsdaValue* value) {
  const auto add = [&](auto& numbers, const auto& later) {
    using Number = std::remove_cvref_t<decltype(numbers[0])>;
    constexpr bool is_double = std::is_same_v<Number, double>;
    for (std::size_t i = 0; i < numbers.size(); ++i)
      numbers[i] += static_cast<std::conditional_t<is_double, double, float>>(share) * (later[i] - numbers[i]);
  };
  if (value->numbers.size() != after.numbers.size() || value->precise.size() != after.precise.size() ||
      value->triples.size() != after.triples.size())
    return false;
  add(value->numbers, after.numbers);
  add(value->precise, after.precise);
  add(value->triples, after.triples);
  return true;
}

}  // namespace

UsdaValue read_usda_value(TextCursor* text, bool samples, UsdaNumbers kept_as, std::optional<double> frame,
                          bool is_held) {
  UsdaValue before, after;  // around the frame: the last sample that is not later, and the first that is
  if (!samples) {
    read_items(text, kept_as, &before);
    return before;
  }
  text->expect('{', "before time samples");
  std::optional<double> from, to;
  bool is_animated = false;
  while (!text->error() && !text->take('}')) {
    const double time = text->number();
    text->expect(':', "behind the time of a sample");
    is_animated = is_animated || from || to;
    const bool is_later = frame ? time > *frame : from.has_value();
    if (is_later ? frame && (!to || time < *to) : !from || time >= *from) {
      UsdaValue& value = is_later ? after : before;
      (is_later ? to : from) = time;
      value = {};
      read_items(text, kept_as, &value);
    } else {
      text->skip_value();
    }
    text->take(',');
    if (text->at_end()) text->fail_here("\"}\" behind time samples");
  }
  if (!from && to) before = std::move(after);
  const bool is_on_sample = from && frame && *from == *frame;
  const bool is_met = is_on_sample || (from && to && !is_held &&
                                       meet(after, static_cast<float>((*frame - *from) / (*to - *from)), &before));
  if (from && frame && !is_met) before.held_since = from;
  before.is_animated = is_animated;
  return before;
}

void read_usda_attribute_metadata(TextCursor* text, UsdaValue* value) {
  if (!text->take('(')) return;
  while (!text->error() && !text->take(')')) {
    if (text->at_end()) return text->fail_here("\")\" behind metadata");
    if (text->peek() == '"' || text->peek() == '\'') {
      text->quoted();  // skips a comment
      continue;
    }
    if (text->take(';') || text->take(',')) continue;
    const std::string key(text->word());
    if (key.empty()) return text->fail_here("a key of metadata");
    if (!text->take('=')) continue;  // "append" comes before its key
    if (key != "interpolation") {
      text->skip_value();
      continue;
    }
    const std::string_view name = text->quoted();
    if (name == "constant") value->scope = AttributeScope::constant;
    if (name == "uniform") value->scope = AttributeScope::uniform;
    if (name == "varying") value->scope = AttributeScope::varying;
    if (name == "vertex") value->scope = AttributeScope::vertex;
  }
}

UsdaTransform usda_transform(const std::map<std::string, UsdaValue, std::less<>>& attributes) {
  UsdaTransform transform;
  const auto order = attributes.find("xformOpOrder");
  if (order == attributes.end()) return transform;
  for (std::string name : order->second.texts) {
    if (name == "!resetXformStack!") {
      transform.resets = true;
      transform.to_parent = glm::dmat4(1.0);
      continue;
    }
    const bool inverts = name.starts_with("!invert!");
    if (inverts) name = name.substr(8);
    const auto found = attributes.find(name);
    if (found == attributes.end() || !name.starts_with("xformOp:")) {
      transform.fault = name;
      continue;
    }
    const std::string kind = name.substr(8, name.find(':', 8) - 8);
    glm::dmat4 one(1.0);
    if (!operation(kind, found->second.precise, &one)) transform.fault = name;
    if (inverts && glm::determinant(one) != 0) one = glm::inverse(one);
    transform.to_parent = transform.to_parent * one;
  }
  return transform;
}

}  // namespace tress::scene
