// Any bytes as a .data file.
#include "fuzz/groom_target.h"
#include "scene/read/grooms/usc_data.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return tress::fuzz::run_groom_reader(data, size, tress::scene::read_usc_data);
}
