// Describes a row of the table in words that another command accepts.
#pragma once

#include "tress/adaptive/target.h"
#include "tress/adaptive/telemetry.h"

namespace tress::cli {

/// Describes node `node` of a slice for its line of telemetry. `fiber`: its parameters by name. `angles`: of the node,
/// in degrees. `command`: a whole command line that learns this row anew: `tress-lab fit` for a density, `tress-lab
/// far-field` for samples (none with a medulla, a cortex that scatters or water, which that command does not support).
/// Empty if the slice belongs to no known fiber.
adaptive::TelemetryWriter::Extra words_of_row(const adaptive::SliceDescription& slice, std::uint32_t node,
                                              double epsilon);

}  // namespace tress::cli
