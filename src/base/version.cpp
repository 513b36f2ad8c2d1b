#include "tress/version.h"

#define TRESS_TEXT_OF(x) #x
#define TRESS_TEXT(x) TRESS_TEXT_OF(x)

namespace tress::inline v0_2 {

const char* version() {
  return TRESS_TEXT(TRESS_VERSION_MAJOR) "." TRESS_TEXT(TRESS_VERSION_MINOR) "." TRESS_TEXT(TRESS_VERSION_PATCH);
}

}  // namespace tress::inline v0_2
