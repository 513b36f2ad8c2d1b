// The versions of the libraries and of the formats they read and write. CMakeLists.txt reads the numbers from here, and
// C reads the macros.
#pragma once

/// Semantic versioning: while the major version is 0, a minor version may change the interface and a patch does not.
/// What hosts embed is in an inline namespace of major and minor version, which is renamed with them everywhere.
#define TRESS_VERSION_MAJOR 0
#define TRESS_VERSION_MINOR 2
#define TRESS_VERSION_PATCH 0

/// The version as one number: TRESS_VERSION >= TRESS_VERSION_NUMBER(0, 2, 0).
#define TRESS_VERSION_NUMBER(major, minor, patch) ((major) * 1000000 + (minor) * 1000 + (patch))
#define TRESS_VERSION TRESS_VERSION_NUMBER(TRESS_VERSION_MAJOR, TRESS_VERSION_MINOR, TRESS_VERSION_PATCH)

#ifdef __cplusplus
namespace tress {
inline namespace v0_2 {  // as C++17 writes it, for tress.hpp

/// Formats have versions of their own, which rise when an older release can no longer read what is written. This is the
/// newest format of a warm cache (adaptive/cache/CACHE_FORMAT.md); older ones can be read.
inline constexpr unsigned cache_format_version = 4;
/// The `schema` of telemetry headers (adaptive/telemetry/schema.json).
inline constexpr unsigned telemetry_schema_version = 1;

/// The compiled version, "0.2.0". If it differs from the macros, headers and library are of different releases. Static
/// storage; any thread.
const char* version();

}  // namespace v0_2
}  // namespace tress
#endif
