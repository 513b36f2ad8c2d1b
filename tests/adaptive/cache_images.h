// Small fixed table images for the tests of the cache. Arbitrary ones: tests/properties/generators.h.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "adaptive/random_ribbons.h"
#include "tress/adaptive/cache.h"

namespace tress::inline v0_2::adaptive {

inline CachedRow converged_row(std::uint32_t node, float objective) {
  CachedRow row;
  row.node = node;
  row.state = RowState::converged;
  row.generation = 1;
  row.energy = 0.75f;
  row.objective = objective;
  row.count = 64;
  row.density()->fit.component_count = 2;
  row.density()->fit.components[0] = {{0.5f, 0.1f, 0.2f}, 0.5f, 2.0f, 0.25f};
  row.density()->fit.components[1] = {{-2.5f, 0.004f, 0.5f}, 0.2f, 3.0f, 0.0f};
  row.density()->fit.uniform_weight = 0.05f;
  row.density()->fit.uniform_attribute_mean = 2.5f;
  row.density()->fit.uniform_attribute_variance = 0.5f;
  return row;
}

/// Parts of 0.5, 0.25, 0 and 0.125; `seed`: of their ribbons.
inline CachedRow ribbon_row(std::uint32_t node, float objective, std::size_t parts = 2, std::uint64_t seed = 1) {
  const float masses[] = {0.5f, 0.25f, 0.0f, 0.125f};
  std::vector<RibbonRow::Part> all;
  for (std::size_t p = 0; p < parts; ++p) all.push_back({random_ribbon(seed + p, true), masses[p]});
  CachedRow row;
  row.node = node;
  row.state = RowState::converged;
  row.generation = 1;
  row.objective = objective;
  row.count = 4096;
  row.learned = CachedSamples{std::make_shared<const RibbonRow>(all)};
  row.energy = row.ribbons()->total_mass();
  return row;
}

inline CachedRow open_row(std::uint32_t node, std::vector<SketchBin> sketch) {
  CachedRow row;
  row.node = node;
  row.energy = 0.5f;
  row.count = sketch.size();
  row.density()->sketch = std::move(sketch);
  return row;
}

inline SketchBin sketch_bin(std::uint32_t index, std::uint32_t offset, float g) {
  return {index, std::uint64_t{offset} << 32 | std::bit_cast<std::uint32_t>(g)};
}

/// Two slices; a converged and two open rows.
inline TableSnapshot small_image() {
  CachedSlice first{{{1, {1.55f, 0.85f, 0.2f}}, {0.0f, 0.5f}, {0.0f, 0.3f, 1.2f}, 0.2f}, {}};
  first.rows = {converged_row(1, 0.004f), open_row(4, {sketch_bin(3, 77, 0.25f), sketch_bin(90, 5, 0.0f)})};
  CachedSlice second{{{2, {1.55f, 0.85f, 0.3f}}, {0.0f}, {0.0f, 1.0f}, 0.3f}, {open_row(0, {})}};
  return {"elliptical-test", {first, second}};
}

/// 2 x 2 nodes, of samples.
inline CachedSlice slice_of_samples() {
  CachedSlice slice{{{16, {1.55f, 0.85f, 0.3f, 0.05f, 0, 0, 0, 2}}, {0.0f, 0.5f}, {0.0f, 1.2f}, 0}, {}};
  slice.description.kind = SliceKind::samples;
  slice.rows = {ribbon_row(0, 0.04f), open_row(1, {}), ribbon_row(3, 0.03f, 4)};
  slice.rows[1].learned = CachedSamples{};
  return slice;
}

/// As small_image(), with a slice of samples.
inline TableSnapshot samples_image() {
  TableSnapshot image = small_image();
  image.slices.push_back(slice_of_samples());
  return image;
}

}  // namespace tress::inline v0_2::adaptive
