// A plugin on one release of tress: what its calls do there.
#include <string>

#include "tress/base/replace_file.h"
#include "tress/version.h"

extern "C" const char* version_by_host(const char* file) {
  return tress::replace_file(file, tress::version()) ? "a file that cannot be written" : tress::version();
}
