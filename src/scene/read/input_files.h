// Reads the files of a scene: their bytes, their kind by the first bytes, and the formats of meshes and environments.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/ext/vector_uint3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "scene/model/environment.h"
#include "scene/model/texture.h"
#include "tress/base/error.h"

namespace tress::scene {

/// The size of a regular file of 1 to `most_bytes` bytes. `what` completes "expected ...".
Result<std::uintmax_t> input_file_size(const std::filesystem::path& file, const std::string& what,
                                       std::uintmax_t most_bytes);

/// The bytes of a regular file of at most `most_bytes`. `what` completes "expected ...". Never waits on pipes or
/// devices.
Result<std::vector<unsigned char>> read_input_file(const std::filesystem::path& file, const std::string& what,
                                                   std::uintmax_t most_bytes);

/// Unpacks gzip, at most `most_bytes` of it; bytes of another kind are returned unchanged. Fails if they are damaged;
/// `name` is the file for the message.
Result<std::vector<unsigned char>> unpacked(std::vector<unsigned char> bytes, const std::string& name,
                                            std::uintmax_t most_bytes);

/// Whether bytes begin like a gzip file.
bool is_packed(std::span<const unsigned char> bytes);

/// The first bytes of a regular file, at most `bytes` of them.
Result<std::vector<unsigned char>> read_file_start(const std::filesystem::path& file, const std::string& what,
                                                   std::size_t bytes);

/// The number of bytes that kind_of() reads.
constexpr std::size_t bytes_of_kind = 64;

/// The format that the first bytes of a file identify: "an Alembic archive (Ogawa)", "a PNG picture"; empty if it is
/// unknown.
std::string known_kind_of(std::span<const unsigned char> start);

/// The same; without a known mark, a description of the bytes: "a text that begins \"solid\"", "binary data that begins
/// 00 01 02 03". Printable, for messages.
std::string kind_of(std::span<const unsigned char> start);

// Wavefront .obj files: the polygons, their normals and texture coordinates.

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

// Radiance pictures (.hdr, RGBE), and environments from them and from OpenEXR.

struct HdrPicture {
  int width = 0, height = 0;
  std::vector<glm::vec3> pixels;          ///< row-major, top row first; finite, >= 0
  std::vector<std::string> remarks = {};  ///< conversions and repairs
};

/// Whether the bytes begin like such a file.
bool is_hdr_file(std::span<const unsigned char> bytes);

/// Parses the bytes of an RGBE file whose scan lines run left to right from the top (-Y +X), run-length encoded by
/// component or flat. A value is mantissa * 2^(exponent - 136). Values are divided by the EXPOSUREs and COLORCORRs of
/// the header, because they are the radiance times these. The size is checked against `most_pixels` and against the
/// number of bytes before memory is allocated; a file that ends early is an error. `name` is the file named in errors,
/// which give the byte.
Result<HdrPicture> parse_hdr_file(std::span<const unsigned char> bytes, const std::string& name,
                                  std::size_t most_pixels);

/// Makes an environment of a latitude-longitude map, top row up, with as many pixels as its sides require. Radiance is
/// at most 1e12. Negative values become 0, with a warning; NaN and infinity are errors. A map that is not twice as wide
/// as high is a warning too. `name` is the file named in errors.
Result<Environment> make_environment(HdrPicture map, const std::string& name, double rotate_rad, float scale,
                                     std::vector<std::string>* warnings);

/// Loads a latitude-longitude map, top row up: OpenEXR with R, G, B, or RGBE (.hdr), detected by its first bytes, not
/// by its name. At most 2^27 pixels; otherwise as make_environment().
Result<Environment> load_environment(const std::filesystem::path& file, double rotate_rad, float scale,
                                     std::vector<std::string>* warnings);

// Textures of meshes and of the roots of strands.

/// The tiles of a name with <UDIM> that exist, by their numbers; empty for another name.
std::map<int, std::filesystem::path> udim_files(const std::filesystem::path& file);

/// Loads a color picture: PNG, whose values are sRGB, or OpenEXR with linear R, G, B, detected by its first bytes. At
/// most 2^26 pixels. Values outside [0, 1] are clamped, with a warning, because an albedo is a share. A name with
/// <UDIM> stands for the files that have the number of a tile in its place, of which there must be one.
Result<Texture> load_texture(const std::filesystem::path& file, std::vector<std::string>* warnings,
                             bool is_encoded = true);

}  // namespace tress::scene
