// What a row of the table is of, in words that another command takes.
#pragma once

#include "tress/adaptive/target.h"
#include "tress/adaptive/telemetry.h"

namespace tress::cli {

/// Of node `node` of a slice, for its line of telemetry: `fiber`, its parameters by name; `angles`, of the node, in
/// degrees; `command`, a whole command line that learns this row anew: `tress-lab fit` of a density, `tress-lab
/// far-field` of samples (none where there is a medulla, which that command has not). Empty if the slice is of no fiber
/// known here.
adaptive::TelemetryWriter::Extra words_of_row(const adaptive::SliceDescription& slice, std::uint32_t node,
                                              double epsilon);

}  // namespace tress::cli
