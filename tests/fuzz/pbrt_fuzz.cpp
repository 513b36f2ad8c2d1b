// Any bytes as a pbrt scene.
#include "fuzz/groom_target.h"
#include "scene/read/grooms/pbrt_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return tress::fuzz::run_groom_reader(data, size, tress::scene::read_pbrt);
}
