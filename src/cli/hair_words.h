// Describes the hair behind the slices of a table in words: the meaning of a key, and the difference of two keys.
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
/// Degrees that give the same float when converted back to radians.
double degrees(float radians);

/// "TT", "TRT", "TRRT", "GLINT", "TRT without GLINT", "rough"; otherwise the number.
std::string lobe_word(const adaptive::SliceDescription& slice);

struct HairParameter {
  std::string name;
  double value = 0;
};
/// For a slice of densities: eta, eccentricity and blur_deg. For one of samples: eta, eccentricity, roughness, tilt_deg
/// and, if there are a medulla, a cortex that scatters or water, their parameters.
std::vector<HairParameter> hair_parameters(const adaptive::SliceDescription& slice);

/// The roughness whose usual widths have this blur. Empty if the blur is at a limit, or no roughness has it.
std::optional<double> roughness_of_blur(const adaptive::SliceDescription& slice);

/// "eta 1.55, eccentricity 0.85, blur 5.7296 degrees (roughness 0.2)".
std::string hair_words(const adaptive::SliceDescription& slice);

/// A parameter in which two slices of one lobe differ.
struct HairDifference {
  std::string name;
  double here = 0, there = 0;
};
std::vector<HairDifference> hair_differences(const adaptive::SliceDescription& here,
                                             const adaptive::SliceDescription& there);
/// The slice of the same lobe and kind that differs in the fewest parameters, and among those by the least. Null
/// without such slices.
const adaptive::SliceDescription* nearest_hair(const adaptive::SliceDescription& slice,
                                               const std::vector<adaptive::SliceDescription>& among);

/// The contents of a slice of a table.
struct SliceContents {
  adaptive::SliceDescription slice;
  std::uint64_t open = 0, converged = 0;
  std::uint64_t samples = 0;      ///< number from which the converged rows were learned
  std::vector<float> objectives;  ///< bounds of the errors of converged rows
};

/// A kind of hair in a table: the slices that have its parameters.
struct TableHair {
  std::vector<HairParameter> parameters;  ///< eta, eccentricity and other parameters that all its slices share
  std::vector<std::string> lobes;
  std::uint64_t nodes = 0, open = 0, converged = 0, samples = 0;
  double error_median = 0, error_max = 0;
};
/// Slices of densities are one hair if their blurs belong to one roughness; a slice may belong to several.
std::vector<TableHair> hair_of(const std::vector<SliceContents>& slices);

std::string words(const std::vector<HairParameter>& parameters);
nlohmann::ordered_json to_json(const TableHair& hair);

}  // namespace tress::cli
