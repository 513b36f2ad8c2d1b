// numpy arrays as what they are in memory: checked views of what comes in, arrays over memory of ours that goes out.
#pragma once

#include <pybind11/numpy.h>

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "python/raised.h"

namespace tress::python {

/// Shape and type as messages have them: "float64 (3, 2)".
std::string words(const pybind11::array& array);

/// The numbers of a C-contiguous array of T of shape (N, columns), or (N) with columns 0, without a copy: good as long
/// as the array. Raises what names `place` where it is another.
template <class T>
std::span<const T> view(const pybind11::array& array, std::size_t columns, const std::string& place) {
  const bool has_shape =
      columns == 0 ? array.ndim() == 1 : array.ndim() == 2 && array.shape(1) == static_cast<pybind11::ssize_t>(columns);
  const bool is_typed = array.dtype().is(pybind11::dtype::of<T>()) || array.dtype().equal(pybind11::dtype::of<T>());
  if (!has_shape || !is_typed || (array.flags() & pybind11::array::c_style) == 0)
    throw Raised({"", place,
                  "a C-contiguous array of " + std::string(pybind11::str(pybind11::dtype::of<T>())) +
                      (columns == 0 ? ", (N)" : ", (N, " + std::to_string(columns) + ")"),
                  words(array)});
  return {static_cast<const T*>(array.data()), static_cast<std::size_t>(array.size())};
}

/// An array that owns the vector, whose items are `columns` of T each; 0: one T each, of one dimension.
template <class T, class Item>
pybind11::array_t<T> array_of(std::vector<Item>&& items, std::size_t columns = 0) {
  static_assert(sizeof(Item) % sizeof(T) == 0);
  auto* kept = new std::vector<Item>(std::move(items));
  const pybind11::capsule owner(kept, [](void* p) { delete static_cast<std::vector<Item>*>(p); });
  std::vector<pybind11::ssize_t> shape{static_cast<pybind11::ssize_t>(kept->size())};
  if (columns > 0) shape.push_back(static_cast<pybind11::ssize_t>(columns));
  return pybind11::array_t<T>(shape, reinterpret_cast<const T*>(kept->data()), owner);
}

}  // namespace tress::python
