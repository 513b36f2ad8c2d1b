#include "fit/fitted_row.h"

#include <array>
#include <cstdint>
#include <span>

namespace tress::inline v0_2::adaptive {

RibbonRow fitted_row(const RowExits& exits, const PartEnergies& energies, const RibbonRow* parent,
                     const RibbonFitRule& rule) {
  std::array<Ribbon, RowExits::most_parts> of_parent;
  PartParents parents{};
  for (std::uint32_t p = 0; parent != nullptr && p < parent->parts(); ++p) {
    if (!(parent->mass(p) > 0)) continue;
    of_parent[p] = parent->ribbon(p);
    parents[p] = &of_parent[p];
  }
  const FittedRibbons fitted = fit_ribbons(exits, parents, rule);
  std::array<RibbonRow::Part, RowExits::most_parts> parts;
  for (std::uint32_t p = 0; p < exits.parts; ++p) {
    if (!(exits.part[p].count > 0)) continue;
    parts[p] = {energies.mended(fitted.ribbon[p], p), static_cast<float>(energies.mass(p))};
  }
  return RibbonRow(std::span(parts).first(exits.parts));
}

RibbonRow with_energies(const RibbonRow& row, const PartEnergies& energies) {
  std::array<RibbonRow::Part, RowExits::most_parts> parts;
  for (std::uint32_t p = 0; p < row.parts(); ++p) {
    if (energies.mass(p) > 0) parts[p] = {energies.mended(row.ribbon(p), p), static_cast<float>(energies.mass(p))};
  }
  return RibbonRow(std::span(parts).first(row.parts()));
}

}  // namespace tress::inline v0_2::adaptive
