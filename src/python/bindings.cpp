// The compiled part of the module tress. The public names are in src/python/tress, in plain Python on top of this.
#include "python/bindings.h"

#include <pybind11/pybind11.h>

#include "python/raised.h"
#include "tress/version.h"

PYBIND11_MODULE(_tress, module) {
  module.doc() = "The compiled part of tress.";
  module.attr("__version__") = tress::version();
  tress::python::bind_error(module);
  tress::python::bind_picture(module);
  tress::python::bind_strands(module);
  tress::python::bind_render(module);
  tress::python::bind_fit(module);
  tress::python::bind_service(module);
  tress::python::bind_bcsdf(module);
}
