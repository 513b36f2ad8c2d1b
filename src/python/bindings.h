// The parts of the module tress._tress. Each adds its names; src/python/tress/_tress.pyi lists them with their types.
#pragma once

#include <pybind11/pybind11.h>

namespace tress::python {

void bind_picture(pybind11::module_& module);
void bind_strands(pybind11::module_& module);
void bind_render(pybind11::module_& module);
void bind_fit(pybind11::module_& module);
void bind_bcsdf(pybind11::module_& module);
void bind_service(pybind11::module_& module);

}  // namespace tress::python
