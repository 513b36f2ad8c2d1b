// A picture as Python sees it.
#pragma once

#include <pybind11/pybind11.h>

#include "image/picture.h"

namespace tress::python {

/// tress._tress.Picture. Its channels never move: arrays over them hold the picture.
struct SharedPicture {
  image::Picture picture;
  image::Preview preview;
  pybind11::dict stats;  ///< of the render that made it; empty of a file
};

}  // namespace tress::python
