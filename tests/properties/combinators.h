// Small generators to make others of: they reach their whole range at any size of case, and shrink to plain values.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "properties/property.h"

namespace tress::testing {

/// 0 to n - 1, whatever the size of the case (inRange() alone begins with the first few); shrinks to 0.
template <class Integer>
rc::Gen<Integer> below(Integer n) {
  return rc::gen::resize(rc::kNominalSize, rc::gen::inRange<Integer>(0, n));
}

/// One of the values; shrinks to the first.
template <class Value>
rc::Gen<Value> pick(std::vector<Value> values) {
  const std::size_t count = values.size();
  return rc::gen::map(below(count), [values = std::move(values)](std::size_t i) { return values[i]; });
}

/// One of the generators; shrinks as that one does.
template <class Value>
rc::Gen<Value> either(rc::Gen<Value> first, rc::Gen<Value> second) {
  return rc::gen::oneOf(std::move(first), std::move(second));
}

/// a + (b - a) k / 2^20; shrinks to a.
inline rc::Gen<float> between(float a, float b) {
  return rc::gen::map(below(1 << 20),
                      [a, b](int k) { return static_cast<float>(a + (static_cast<double>(b) - a) * k / (1 << 20)); });
}

/// Up to `most` of what `one` makes; shrinks by leaving out.
template <class Value>
rc::Gen<std::vector<Value>> up_to(std::size_t most, rc::Gen<Value> one) {
  return rc::gen::map(rc::gen::container<std::vector<rc::Maybe<Value>>>(most, rc::gen::maybe(std::move(one))),
                      [](const std::vector<rc::Maybe<Value>>& maybe) {
                        std::vector<Value> kept;
                        for (const rc::Maybe<Value>& value : maybe) {
                          if (value) kept.push_back(*value);
                        }
                        return kept;
                      });
}

}  // namespace tress::testing
