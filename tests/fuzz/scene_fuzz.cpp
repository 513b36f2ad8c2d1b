// Any bytes as a scene file: refused by the path in it, or a description.
#include "fuzz/fuzz.h"
#include "scene/read/scene_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tress;
  const auto scene = scene::parse_scene_file(fuzz::bytes_of(data, size), "some.json");
  if (!scene) fuzz::require_message(scene, "some.json");
  return 0;
}
