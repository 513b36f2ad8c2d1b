// Any bytes as a USD text.
#include "fuzz/groom_target.h"
#include "scene/read/grooms/usd_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return tress::fuzz::run_groom_reader(data, size, tress::scene::read_usda);
}
