// A row as a cache has it.
#pragma once

#include "table/row.h"
#include "table/slice.h"

namespace tress::adaptive {

/// What a cache held of a row that is not converged, if it was to be answered at a larger epsilon; else null.
const CachedRow* earlier_of(const Row& row);
/// slot: of the row. Refused rows as open ones; where there is an earlier_of(), that.
CachedRow cached_form(const Row& row, const Slot& slot);

}  // namespace tress::adaptive
