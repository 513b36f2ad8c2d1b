// A picture in Python.
#pragma once

#include <pybind11/pybind11.h>

#include "image/picture.h"

namespace tress::python {

/// The object tress._tress.Picture. Its channels never move: arrays over them keep the picture alive.
struct SharedPicture {
  image::Picture picture;
  image::Preview preview;
  pybind11::dict stats;  ///< statistics of its render; empty for a picture from a file
};

}  // namespace tress::python
