// Wavefront .obj files: the polygons, nothing else.
#pragma once

#include <cstdint>
#include <glm/ext/vector_uint3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::scene {

/// File units, file axes.
struct ObjFile {
  std::vector<glm::vec3> positions;   ///< finite
  std::vector<glm::uvec3> triangles;  ///< indices into positions, in range; at least one
};

/// Parses the bytes of an .obj file. Faces name vertices as v, v/vt, v//vn or v/vt/vn, those read so far, from 1 on or
/// from -1 backwards; polygons become fans of triangles around their first vertex. Texture coordinates, normals, lines,
/// points, groups and materials are read over; curved surfaces are refused. Memory is a small multiple of the number of
/// bytes. `name` is the file named in errors, which give the line.
Result<ObjFile> parse_obj_file(std::span<const unsigned char> bytes, const std::string& name);

}  // namespace tress::scene
