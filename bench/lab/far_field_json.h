// What tress-lab far-field and tress-lab lobes measure of one fiber, and how it is written as JSON.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/options.h"
#include "models/default_model.h"
#include "references/far_field.h"
#include "references/registry.h"
#include "references/taught_fiber.h"
#include "tress/adaptive/options.h"
#include "tress/fiber/parameters.h"

namespace tress::lab {

inline constexpr std::array<const char*, 3> channel_names{"red", "green", "blue"};

/// Angles in degrees, as typed. Every value in range.
struct FarFieldSettings {
  std::string model{fiber::usual_model};  ///< of references::models()
  double eccentricity = 0.85, alpha = 0.2, tilt = 3, eta = 1.55;
  double theta_r = 30, phi_r = 45;  ///< where light comes from
  std::vector<double> sigma_a{0};   ///< per major semi-axis: grey, or three channels
  cli::Resolution bins{36, 36};     ///< of theta_i, of phi_i
  std::uint64_t paths = 1'000'000, seed = 0;
  adaptive::Options table;
  bool loses_masked_light = false;

  std::size_t channels() const { return sigma_a.size(); }
  const fiber::ModelInfo& info() const { return *references::find_model(model); }
};

fiber::FiberParameters parameters_of(const FarFieldSettings& settings);

/// What was measured, and the rows that it was measured with.
struct MeasuredFarField {
  references::Lesson lesson;
  bool has_rows = false;
  references::FarField field;
};

/// Rows are learned first. In the calling oneTBB arena; same settings, same bits.
MeasuredFarField measure_far_field(const FarFieldSettings& settings);

/// Says which rows did not converge.
void warn_of_rows(const FarFieldSettings& settings, const MeasuredFarField& measured);

/// All that tress-lab far-field --json prints; numbers to 7 digits.
nlohmann::ordered_json far_field_json(const FarFieldSettings& settings, const MeasuredFarField& measured);

/// The options of the fiber, of the direction and of the measurement, but for the model; parsing fills `settings`,
/// which must outlive it.
void add_far_field_options(CLI::App* app, FarFieldSettings& settings);

/// What the parser cannot see: a message, empty if all is well.
std::string far_field_contradiction(const FarFieldSettings& settings);

}  // namespace tress::lab
