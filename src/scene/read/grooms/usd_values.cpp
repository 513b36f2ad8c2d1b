#include "scene/read/grooms/usd_values.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/ext/matrix_transform.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <string>
#include <utility>

namespace tress::scene {
namespace {

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

/// Applies one operation such as "translate" with its numbers; false if it is unknown or has the wrong numbers.
bool operation(const std::string& kind, const std::vector<double>& n, glm::dmat4* out) {
  const bool moves = kind.starts_with("translate");
  if (moves || kind.starts_with("scale")) {  // along all axes, or one: translateX
    const std::string axis = kind.substr(moves ? 9 : 5);
    const bool is_one = axis == "X" || axis == "Y" || axis == "Z";
    if ((!axis.empty() && !is_one) || n.size() != (is_one ? 1 : 3)) return false;
    glm::dvec3 by(moves ? 0.0 : 1.0);
    for (int i = 0; i < 3; ++i)
      if (!is_one || i == axis[0] - 'X') by[i] = n[is_one ? 0 : static_cast<std::size_t>(i)];
    *out = moves ? glm::translate(glm::dmat4(1.0), by) : glm::scale(glm::dmat4(1.0), by);
  } else if (kind == "orient" && n.size() == 4) {
    *out = usd_rotation(n.data());
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

}  // namespace

glm::dmat4 usd_rotation(const double* q) {
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(size > 0)) return glm::dmat4(1.0);
  const double w = q[0] / size, x = q[1] / size, y = q[2] / size, z = q[3] / size;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0},
          {0, 0, 0, 1}};
}

UsdTransform usd_transform(const std::map<std::string, UsdValue, std::less<>>& attributes) {
  UsdTransform transform;
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
    if (!name.starts_with("xformOp:")) {
      transform.fault = name;
      continue;
    }
    if (found == attributes.end() || (found->second.precise.empty() && found->second.not_read.empty())) {
      transform.missing = name;  // USD skips it
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
