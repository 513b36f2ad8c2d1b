// Any bytes as an environment map, EXR or HDR (the first bytes decide): refused, or a map that can be sampled.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>

#include "fuzz/fuzz.h"
#include "scene/read/environment_file.h"
#include "scene/read/input_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tress;
  static const int file = memfd_create("environment", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  fuzz::require(ftruncate(file, 0) == 0 && pwrite(file, data, size, 0) == static_cast<ssize_t>(size));
  std::vector<std::string> warnings;
  const auto environment = scene::load_environment(path, 0, 1, &warnings);
  if (!environment) {
    fuzz::require_message(environment, path);
    return 0;
  }
  const glm::vec3 radiance = environment->radiance({0, 0.6f, 0.8f});
  fuzz::require(std::isfinite(radiance.x + radiance.y + radiance.z) && radiance.x >= 0);
  return 0;
}
