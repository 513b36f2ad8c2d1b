// Wavefront .obj files: the polygons, their normals and texture coordinates.
#pragma once

#include <glm/ext/vector_uint3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::scene {

/// A mesh in the file's units and axes.
struct ObjFile {
  std::vector<glm::vec3> positions;   ///< finite
  std::vector<glm::uvec3> triangles;  ///< indices into positions, in range; at least one
  std::vector<glm::vec3> normals;     ///< finite, of any length
  /// Per triangle, indices into normals or no_normal; empty if no corner has one.
  std::vector<glm::uvec3> corner_normals;
  std::vector<glm::vec2> uvs;          ///< within 10^6 of 0
  std::vector<glm::uvec3> corner_uvs;  ///< the same for uvs, and no_uv
};

/// Parses the bytes of an .obj file. Faces name vertices as v, v/vt, v//vn or v/vt/vn, among those read so far, from 1
/// on or from -1 backwards; polygons become fans of triangles around their first vertex. A normal that does not exist,
/// or is not three finite numbers, is left out; so are texture coordinates. Lines, points, groups and materials are
/// skipped; curved surfaces are refused. Memory is a small multiple of the number of bytes. `name` is the file named in
/// errors, which give the line.
Result<ObjFile> parse_obj_file(std::span<const unsigned char> bytes, const std::string& name);

}  // namespace tress::scene
