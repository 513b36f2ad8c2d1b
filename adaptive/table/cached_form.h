// The form in which a cache stores a row.
#pragma once

#include "table/row.h"
#include "table/slice.h"

namespace tress::adaptive {

/// The cached row from which an open row started: it had converged, at a larger epsilon. Null for other rows.
const CachedRow* earlier_of(const Row& row);
/// Returns earlier_of(row) if there is one; otherwise the row as it is now, refused rows as open. slot: the row's own.
CachedRow cached_form(const Row& row, const Slot& slot);

}  // namespace tress::adaptive
