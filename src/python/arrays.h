// numpy arrays without copies: checked views of arrays that come in, and arrays over our own memory that go out.
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

/// Shape and type as text for messages: "float64 (3, 2)".
std::string words(const pybind11::array& array);

/// Views the numbers of a C-contiguous array of T of shape (N, columns), or (N) if columns is 0, without a copy; valid
/// as long as the array. Raises an error that names `place` if the array is another.
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

/// An array that owns the vector, whose items are `columns` values of T each; with 0, one T each, in one dimension.
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
