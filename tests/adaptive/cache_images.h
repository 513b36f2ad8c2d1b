// Table images for the tests of the cache: a small fixed one, and arbitrary valid ones for RapidCheck.
#pragma once

#include <rapidcheck.h>

#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "adaptive/knot_tables.h"
#include "sketch/sketch.h"
#include "tress/adaptive/cache.h"

namespace tress::adaptive {

inline CachedRow converged_row(std::uint32_t node, float objective) {
  CachedRow row;
  row.node = node;
  row.state = RowState::converged;
  row.generation = 1;
  row.energy = 0.75f;
  row.objective = objective;
  row.count = 64;
  row.fit.component_count = 2;
  row.fit.components[0] = {{0.5f, 0.1f, 0.2f}, 0.5f, 2.0f, 0.25f};
  row.fit.components[1] = {{-2.5f, 0.004f, 0.5f}, 0.2f, 3.0f, 0.0f};
  row.fit.uniform_weight = 0.05f;
  row.fit.uniform_attribute_mean = 2.5f;
  row.fit.uniform_attribute_variance = 0.5f;
  return row;
}

/// `seed`: of its densities and moments.
inline CachedRow knot_row(std::uint32_t node, float objective, std::size_t knots = 32, std::uint64_t seed = 1) {
  CachedRow row;
  row.node = node;
  row.state = RowState::converged;
  row.generation = 1;
  row.energy = 0.75f;
  row.objective = objective;
  row.count = 4 * knots;
  row.knots = rough_table(knots, row.energy, seed);
  return row;
}

inline CachedRow open_row(std::uint32_t node, std::vector<SketchBin> sketch) {
  CachedRow row;
  row.node = node;
  row.energy = 0.5f;
  row.count = sketch.size();
  row.sketch = std::move(sketch);
  return row;
}

inline SketchBin sketch_bin(std::uint32_t index, std::uint32_t offset, float g) {
  return {index, std::uint64_t{offset} << 32 | std::bit_cast<std::uint32_t>(g)};
}

/// Two pages; a converged and two open rows.
inline TableImage small_image() {
  CachedPage first{{{1, {1.55f, 0.85f, 0.2f}}, {0.0f, 0.5f}, {0.0f, 0.3f, 1.2f}, 0.2f}, {}};
  first.rows = {converged_row(1, 0.004f), open_row(4, {sketch_bin(3, 77, 0.25f), sketch_bin(90, 5, 0.0f)})};
  CachedPage second{{{2, {1.55f, 0.85f, 0.3f}}, {0.0f}, {0.0f, 1.0f}, 0.3f}, {open_row(0, {})}};
  return {"elliptical-test", {first, second}};
}

/// As small_image(), with a knot table at a node of its own.
inline TableImage knot_image() {
  TableImage image = small_image();
  image.pages[0].rows.insert(image.pages[0].rows.begin() + 1, knot_row(2, 0.002f));
  return image;
}

/// Few distinct values, so that merges meet ties in every field.
inline rc::Gen<CachedRow> arbitrary_row(std::uint32_t node) {
  return rc::gen::exec([node] {
    const auto pick = [](std::vector<float> values) { return *rc::gen::elementOf(std::move(values)); };
    CachedRow row;
    row.node = node;
    row.generation = *rc::gen::inRange(0u, 2u);
    row.energy = pick({0.0f, 0.25f, 0.5f});
    row.count = *rc::gen::inRange(0u, 3u);
    if (*rc::gen::arbitrary<bool>()) {
      row.state = RowState::converged;
      row.objective = pick({0.0f, 0.001f, 0.01f});
      if (*rc::gen::inRange(0, 3) == 0) {
        row.knots = rough_table(std::size_t{32} << *rc::gen::inRange(0, 3), row.energy, *rc::gen::inRange(0u, 2u));
        return row;
      }
      row.fit.component_count = *rc::gen::inRange(0u, 9u);
      for (std::uint32_t d = 0; d < row.fit.component_count; ++d) {
        row.fit.components[d] = {{pick({-3.0f, 0.0f, 1.5f}), pick({0.004f, 0.1f}), pick({0.2f, 0.5f})},
                                 pick({0.0f, 0.5f}),
                                 pick({0.0f, 2.0f}),
                                 pick({0.0f, 0.5f})};
      }
      row.fit.uniform_weight = pick({0.0f, 0.1f});
      return row;
    }
    for (std::uint32_t index = 0; index < 8; ++index) {
      if (!*rc::gen::arbitrary<bool>()) continue;
      row.sketch.push_back(sketch_bin(index, *rc::gen::inRange(0u, 3u), pick({0.0f, 1.0f})));
    }
    return row;
  });
}

inline rc::Gen<TableImage> arbitrary_image() {
  return rc::gen::exec([] {
    TableImage image{"elliptical-test", {}};
    for (std::uint32_t lobe = 0; lobe < 3; ++lobe) {
      if (*rc::gen::inRange(0, 3) == 0) continue;
      CachedPage page{{{lobe, {1.55f, 0.85f, 0.2f}}, {0.0f, 0.5f}, {0.0f, 0.3f}, 0.2f}, {}};
      // One key with two sets of axes: cannot be in one model, and must not break the order all the same.
      if (lobe == 2 && *rc::gen::arbitrary<bool>()) page.description.axis_b = {0.0f, 0.4f};
      for (std::uint32_t node = 0; node < 4; ++node) {
        if (*rc::gen::arbitrary<bool>()) page.rows.push_back(*arbitrary_row(node));
      }
      image.pages.push_back(page);
    }
    return image;
  });
}

}  // namespace tress::adaptive
