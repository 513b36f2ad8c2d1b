#include "cli/hair_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

#include "fiber/rough_rows.h"
#include "fiber/row_axes.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::cli {
namespace {

using adaptive::SliceDescription;
using adaptive::SliceKind;

constexpr double widest_deg = 45;

/// The usual blur for a roughness, as in slices. Radians.
float usual_blur(int slice_lobe, double roughness) {
  fiber::FiberParameters fiber;
  fiber.roughness = static_cast<float>(roughness);
  const auto order = static_cast<std::size_t>(fiber::slice_order(slice_lobe));
  return std::max(fiber::azimuthal_sigmas(fiber)[order - 1], fiber::smallest_grid_sigma);
}

bool is_hair_lobe(std::uint32_t lobe) {
  return (lobe >= 1 && lobe <= 3) || lobe == fiber::glint_slice || lobe == fiber::trt_rest_slice;
}

bool has_blur_of(const SliceDescription& slice, double roughness) {
  const float usual = usual_blur(static_cast<int>(slice.key.lobe), roughness);
  return std::abs(slice.key.parameters[2] - usual) <= 1e-5f * usual;
}

/// The parameter in words, such as "blur 5.73 degrees".
std::string in_words(const HairParameter& parameter) {
  constexpr std::string_view ending = "_deg";
  const bool is_angle = parameter.name.ends_with(ending);
  std::string name = is_angle ? parameter.name.substr(0, parameter.name.size() - ending.size()) : parameter.name;
  std::ranges::replace(name, '_', ' ');
  return fmt::format("{} {:.5g}{}", name, parameter.value, is_angle ? " degrees" : "");
}

/// Adds up the contents of the slices.
TableHair table_hair(std::vector<HairParameter> parameters, const std::vector<const SliceContents*>& slices) {
  TableHair hair;
  hair.parameters = std::move(parameters);
  std::vector<float> objectives;
  for (const SliceContents* contents : slices) {
    hair.lobes.push_back(lobe_word(contents->slice));
    hair.nodes += contents->slice.node_count();
    hair.open += contents->open;
    hair.converged += contents->converged;
    hair.samples += contents->samples;
    objectives.insert(objectives.end(), contents->objectives.begin(), contents->objectives.end());
  }
  if (objectives.empty()) return hair;
  std::ranges::sort(objectives);
  hair.error_median = static_cast<double>(objectives[(objectives.size() - 1) / 2]);
  hair.error_max = static_cast<double>(objectives.back());
  return hair;
}

}  // namespace

double as_typed(float x) { return std::stod(fmt::format("{}", x)); }

double degrees(float radians) {
  const double exact = static_cast<double>(radians) * 180 / std::numbers::pi;
  const double rounded = std::round(exact * 1e4) / 1e4;
  return static_cast<float>(rounded * std::numbers::pi / 180) == radians ? rounded : exact;
}

std::string lobe_word(const SliceDescription& slice) {
  const std::uint32_t lobe = slice.key.lobe;
  if (slice.kind == SliceKind::samples) return lobe == fiber::rough_slice_lobe ? "rough" : std::to_string(lobe);
  if (lobe == fiber::trt_rest_slice) return "TRT without GLINT";
  return lobe < fiber::lobe_names.size() ? fiber::lobe_names[lobe] : std::to_string(lobe);
}

std::vector<HairParameter> hair_parameters(const SliceDescription& slice) {
  const auto& p = slice.key.parameters;
  std::vector<HairParameter> parameters{{"eta", as_typed(p[0])}, {"eccentricity", as_typed(p[1])}};
  if (slice.kind == SliceKind::density) {
    parameters.push_back({"blur_deg", degrees(p[2])});
    return parameters;
  }
  parameters.push_back({"roughness", as_typed(p[2])});
  parameters.push_back({"tilt_deg", degrees(p[3])});
  const char* const names[] = {"medulla",
                               "medulla_scattering",
                               "medulla_asymmetry",
                               "medulla_absorption",
                               "cortex_scattering",
                               "cortex_asymmetry",
                               "wetness"};
  const auto of_part = [&](std::size_t from, std::size_t count) {
    for (std::size_t i = from; p[4 + from] > 0 && i < from + count; ++i)
      parameters.push_back({names[i], as_typed(p[4 + i])});
  };
  of_part(0, 4);
  of_part(4, 2);
  of_part(6, 1);
  return parameters;
}

std::optional<double> roughness_of_blur(const SliceDescription& slice) {
  if (slice.kind != SliceKind::density || !is_hair_lobe(slice.key.lobe)) return std::nullopt;
  const float blur = slice.key.parameters[2];
  if (blur <= fiber::smallest_grid_sigma || degrees(blur) >= widest_deg) return std::nullopt;
  constexpr double reference = 0.2;  // a roughness whose usual blurs are all within the limits
  const double roughness = reference * double{blur} / double{usual_blur(static_cast<int>(slice.key.lobe), reference)};
  const double rounded = std::round(roughness * 1e5) / 1e5;
  return rounded >= 0.01 && rounded <= 1 ? std::optional(rounded) : std::nullopt;
}

std::string words(const std::vector<HairParameter>& parameters) {
  std::string text;
  for (const HairParameter& parameter : parameters) text += (text.empty() ? "" : ", ") + in_words(parameter);
  return text;
}

std::string hair_words(const SliceDescription& slice) {
  const std::optional<double> roughness = roughness_of_blur(slice);
  return words(hair_parameters(slice)) + (roughness ? fmt::format(" (roughness {:.6g})", *roughness) : std::string());
}

std::vector<HairDifference> hair_differences(const SliceDescription& here, const SliceDescription& there) {
  std::vector<HairDifference> differences;
  const std::vector<HairParameter> a = hair_parameters(here), b = hair_parameters(there);
  const auto value_in = [](const std::vector<HairParameter>& all, const std::string& name) {
    const auto found = std::ranges::find(all, name, &HairParameter::name);
    return found == all.end() ? 0 : found->value;
  };
  for (const HairParameter& parameter : a) {
    const double other = value_in(b, parameter.name);
    if (other != parameter.value) differences.push_back({parameter.name, parameter.value, other});
  }
  for (const HairParameter& parameter : b) {
    if (parameter.value != 0 && std::ranges::find(a, parameter.name, &HairParameter::name) == a.end())
      differences.push_back({parameter.name, 0, parameter.value});
  }
  return differences;
}

const SliceDescription* nearest_hair(const SliceDescription& slice, const std::vector<SliceDescription>& among) {
  const SliceDescription* nearest = nullptr;
  std::pair<std::size_t, double> least{std::numeric_limits<std::size_t>::max(), 0};
  for (const SliceDescription& other : among) {
    if (other.kind != slice.kind || other.key.lobe != slice.key.lobe) continue;
    std::pair<std::size_t, double> apart{0, 0};
    for (const HairDifference& difference : hair_differences(slice, other)) {
      ++apart.first;
      const double scale = std::abs(difference.here) + std::abs(difference.there);
      apart.second += std::abs(difference.here - difference.there) / std::max(scale, 1e-9);
    }
    if (apart < least) {
      least = apart;
      nearest = &other;
    }
  }
  return nearest;
}

std::vector<TableHair> hair_of(const std::vector<SliceContents>& slices) {
  std::vector<TableHair> all;
  std::vector<bool> is_listed(slices.size(), false);
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const SliceDescription& slice = slices[i].slice;
    const std::optional<double> roughness = roughness_of_blur(slice);
    if (!roughness || is_listed[i]) continue;
    std::vector<const SliceContents*> together;
    std::vector<std::size_t> members;
    for (std::size_t j = 0; j < slices.size(); ++j) {
      const SliceDescription& other = slices[j].slice;
      if (other.kind != SliceKind::density || other.key.parameters[0] != slice.key.parameters[0] ||
          other.key.parameters[1] != slice.key.parameters[1] || !is_hair_lobe(other.key.lobe) ||
          !has_blur_of(other, *roughness))
        continue;
      together.push_back(&slices[j]);
      members.push_back(j);
    }
    if (together.size() < 2) continue;
    for (const std::size_t j : members) is_listed[j] = true;
    std::vector<HairParameter> parameters = hair_parameters(slice);
    parameters.back() = {"roughness", *roughness};
    all.push_back(table_hair(std::move(parameters), together));
  }
  for (std::size_t i = 0; i < slices.size(); ++i) {
    if (!is_listed[i]) all.push_back(table_hair(hair_parameters(slices[i].slice), {&slices[i]}));
  }
  return all;
}

nlohmann::ordered_json to_json(const TableHair& hair) {
  nlohmann::ordered_json fields;
  for (const HairParameter& parameter : hair.parameters) fields[parameter.name] = parameter.value;
  fields["lobes"] = hair.lobes;
  fields["nodes"] = hair.nodes;
  fields["rows"] = {{"open", hair.open}, {"converged", hair.converged}};
  fields["samples"] = hair.samples;
  if (hair.converged > 0) fields["error"] = {{"median", hair.error_median}, {"max", hair.error_max}};
  return fields;
}

}  // namespace tress::cli
