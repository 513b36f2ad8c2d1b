// The hair behind the slices of a table, in words: what a key means to a person, and what two keys differ in.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tress/adaptive/target.h"

namespace tress::cli {

/// The number that a float was written as: 0.85, not 0.8500000238.
double as_typed(float x);
/// Degrees that are the same float in radians again.
double degrees(float radians);

/// "TT", "TRT", "TRRT", "GLINT", "TRT without GLINT", "rough"; else the number.
std::string lobe_word(const adaptive::SliceDescription& slice);

struct HairParameter {
  std::string name;
  double value = 0;
};
/// eta, eccentricity and blur_deg of a slice of densities; eta, eccentricity, roughness, tilt_deg and, where there is
/// one, the medulla's four of one of samples.
std::vector<HairParameter> hair_parameters(const adaptive::SliceDescription& slice);

/// The roughness whose usual widths have this blur. Unset of a blur that is held to a limit, and where none has it.
std::optional<double> roughness_of_blur(const adaptive::SliceDescription& slice);

/// "eta 1.55, eccentricity 0.85, blur 5.7296 degrees (roughness 0.2)".
std::string hair_words(const adaptive::SliceDescription& slice);

/// A parameter that two slices of one lobe do not share.
struct HairDifference {
  std::string name;
  double here = 0, there = 0;
};
std::vector<HairDifference> hair_differences(const adaptive::SliceDescription& here,
                                             const adaptive::SliceDescription& there);
/// Of slices of the same lobe and kind the one that differs in the fewest parameters, then by the least; null if there
/// is none.
const adaptive::SliceDescription* nearest_hair(const adaptive::SliceDescription& slice,
                                               const std::vector<adaptive::SliceDescription>& among);

/// What a table holds of a slice.
struct SliceContents {
  adaptive::SliceDescription slice;
  std::uint64_t open = 0, converged = 0;
  std::uint64_t samples = 0;      ///< that taught the converged rows
  std::vector<float> objectives;  ///< of the converged rows: what their errors are known to be below
};

/// A kind of hair in a table: the slices that have its parameters.
struct TableHair {
  std::vector<HairParameter> parameters;  ///< eta, eccentricity and what else all of its slices share
  std::vector<std::string> lobes;
  std::uint64_t nodes = 0, open = 0, converged = 0, samples = 0;
  double error_median = 0, error_max = 0;
};
/// Slices of densities are one hair where their blurs are those of one roughness; a slice may be of several.
std::vector<TableHair> hair_of(const std::vector<SliceContents>& slices);

std::string words(const std::vector<HairParameter>& parameters);
nlohmann::ordered_json to_json(const TableHair& hair);

}  // namespace tress::cli
