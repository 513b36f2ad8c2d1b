// Arrays of Python instead of files of a scene.
#pragma once

#include <pybind11/pybind11.h>

#include "scene/read/load_scene.h"

namespace tress::python {

/// arrays: for each name that stands for a file in the scene, a tuple (kind, dict), kind "strands", "mesh" or
/// "environment". Call it with the GIL. Every number is copied once. Raises an error that names the array.
scene::FilesInMemory files_of(const pybind11::dict& arrays);

}  // namespace tress::python
