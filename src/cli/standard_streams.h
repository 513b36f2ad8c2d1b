// Standard input, output and error as a process may be given them: closed, full, or a pipe that nobody reads.
#pragma once

#include <optional>

#include "tress/base/error.h"

namespace tress::cli {

/// To be called first. Puts something in the place of closed streams, lest a file that is opened takes the number of
/// one and is written into by messages; writing there fails. A pipe without a reader, or a file as large as is allowed,
/// becomes an error of that write, where it would have killed the process with all that it has not saved.
void prepare_standard_streams();

/// Error if standard output has not taken all of the results.
std::optional<Error> flush_results();

}  // namespace tress::cli
