// Linear RGB (Rec. 709).
#pragma once

#include <glm/vec3.hpp>

namespace tress::inline v0_2 {

/// Returns the relative luminance, and the share of each channel in it.
inline glm::vec3 luminance_terms(const glm::vec3& color) { return color * glm::vec3(0.2126f, 0.7152f, 0.0722f); }
inline float luminance(const glm::vec3& color) {
  const glm::vec3 terms = luminance_terms(color);
  return terms.r + terms.g + terms.b;
}
inline double luminance(const glm::dvec3& color) { return 0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z; }

}  // namespace tress::inline v0_2
