#include "python/arrays.h"

namespace py = pybind11;

namespace tress::python {

std::string words(const py::array& array) {
  std::string text = std::string(py::str(array.dtype())) + " (";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  text += ")";
  if ((array.flags() & py::array::c_style) == 0) text += ", not C-contiguous";
  return text;
}

}  // namespace tress::python
