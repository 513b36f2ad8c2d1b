// Any bytes as an .obj file: refused by the line, or a mesh that can be placed.
#include <array>

#include "fuzz/fuzz.h"
#include "scene/read/assembly.h"
#include "scene/read/input_files.h"
#include "scene/read/obj_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tress;
  const auto file = scene::parse_obj_file(fuzz::bytes_of(data, size), "some.obj");
  if (!file) {
    fuzz::require_message(file, "some.obj");
    return 0;
  }
  for (const glm::uvec3& triangle : file->triangles) {
    for (int corner = 0; corner < 3; ++corner) fuzz::require(triangle[corner] < file->positions.size());
  }
  std::vector<std::string> warnings;
  const auto mesh = scene::place_mesh(std::array{scene::MeshAtMoment{&*file, {}}}, {}, "some.obj", &warnings);
  if (!mesh) fuzz::require_message(mesh, "some.obj");
  return 0;
}
