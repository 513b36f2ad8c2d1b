// The public values of the service as text, for logs and test failures. It is not a format: nothing reads it back.
#pragma once

#include <string>

#include "tress/adaptive/cache.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/target.h"
#include "tress/adaptive/telemetry.h"

namespace tress::inline v0_2::adaptive {

/// "absent", "open", "converged" or "refused", as in telemetry. Static storage.
const char* state_name(RowState state);

/// Text such as "lobe 2 (1.55, 0.85, 0.2)".
std::string to_string(const SliceKey& key);
/// The key, the nodes and the blur.
std::string to_string(const SliceDescription& slice);
/// Every setting by its name, with its unit, on one line.
std::string to_string(const Options& options);
/// What a host shows of a pass: queries, share answered by fits, rows by state, memory.
std::string to_string(const PassReport& report);

}  // namespace tress::inline v0_2::adaptive
