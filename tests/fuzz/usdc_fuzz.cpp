// Any bytes as a binary USD file, or as a USD archive.
#include "fuzz/groom_target.h"
#include "scene/read/grooms/usd_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const bool is_archive = size > 0 && data[0] == 'P' && (size < 2 || data[1] == 'K');
  return tress::fuzz::run_groom_reader(data, size, is_archive ? tress::scene::read_usdz : tress::scene::read_usdc);
}
