// What the properties are about, at random and with the corners in it: mixtures, sketches, rows, tables.
// Made of RapidCheck's combinators, so that a counterexample shrinks to few slices, rows, components and plain numbers.
// Compiled once, in generators.cpp: combinators are templates that take their time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "properties/property.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {

inline constexpr const char* any_model = "moving-peaks-1";

/// [-pi, pi), both ends among them.
rc::Gen<float> any_azimuth();
/// At most eight components, scales and weights at their bounds among them.
rc::Gen<Mixture> any_mixture();
/// The same, with weights and attributes as rows have them: of a picture's light, not of what a file may hold.
rc::Gen<Mixture> common_mixture();
/// Of one or two parts with mass.
rc::Gen<RibbonRow> any_ribbons();
/// Bins of a sketch of so many, neighbours and the last one, with few distinct values, so that merges meet ties.
rc::Gen<std::vector<SketchBin>> any_sketch(std::uint32_t bins);

/// One of a few keys, in the order of a file: the first `keys` of slices of densities, the last of samples.
SliceKey key_of(std::size_t index);
inline constexpr std::size_t keys = 5, all_keys = 6;
/// 2 x 3 nodes. `other`: axes that no slice of this key should have, in one model.
SliceDescription description_of(std::size_t index, bool other = false);
/// A whole table, the empty one included; slices without rows, with other axes, keys that two tables share or not; rows
/// open, refused, of a mixture, of ribbons; counts and generations at their bounds.
rc::Gen<TableSnapshot> any_image();
/// At least one of them.
rc::Gen<std::vector<TableSnapshot>> any_images(std::size_t most);
/// Plain numbers: any below n, of a count of their own.
rc::Gen<std::vector<std::uint32_t>> any_numbers(std::size_t count, std::uint32_t n);

/// The bytes of the merge, what equality of tables means here.
std::string merged(const TableSnapshot& a, const TableSnapshot& b);

// How RapidCheck shows a counterexample.
void showValue(const Mixture& fit, std::ostream& out);
void showValue(const RibbonRow& row, std::ostream& out);
void showValue(const SketchBin& bin, std::ostream& out);
void showValue(const CachedRow& row, std::ostream& out);
void showValue(const TableSnapshot& image, std::ostream& out);

}  // namespace tress::inline v0_2::adaptive
