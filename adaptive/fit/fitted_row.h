// The row of largest likelihood for its exits, with the energies of its parts.
#pragma once

#include "fit/fit_ribbons.h"
#include "fit/part_energies.h"
#include "fit/row_exits.h"
#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::adaptive {

/// The masses, and the decays of the parts, are those of `energies`, which must have some light. parent: may be null.
RibbonRow fitted_row(const RowExits& exits, const PartEnergies& energies, const RibbonRow* parent,
                     const RibbonFitRule& rule);

/// Returns the row's shapes with the masses and decays of `energies`.
RibbonRow with_energies(const RibbonRow& row, const PartEnergies& energies);

}  // namespace tress::inline v0_2::adaptive
