#include "cli/row_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "cli/hair_words.h"
#include "cli/telemetry_lines.h"
#include "fiber/rough_rows.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/lobes.h"

namespace tress::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string lobe_of(std::uint32_t slice_lobe) {
  if (slice_lobe == fiber::trt_rest_slice) return "TRT-REST";
  return fiber::lobe_names[static_cast<std::size_t>(fiber::lobe_of_slice(static_cast<int>(slice_lobe)))];
}

adaptive::TelemetryWriter::Extra of_density(const adaptive::SliceKey& key, float phi_r, float theta_d, double epsilon) {
  const std::string lobe = lobe_of(key.lobe);
  const double eta = as_typed(key.parameters[0]), e = as_typed(key.parameters[1]), sigma = degrees(key.parameters[2]);
  return {{"fiber", json_text(Json{{"lobe", lobe}, {"eta", eta}, {"eccentricity", e}, {"sigma_deg", sigma}})},
          {"angles", json_text(Json{{"phi_r_deg", degrees(phi_r)}, {"theta_d_deg", degrees(theta_d)}})},
          {"command", json_text(fmt::format(
                          "tress-lab fit --lobe {} --eta {} --e {} --sigma {} --phi {} --theta-d {} --epsilon {}", lobe,
                          eta, e, sigma, degrees(phi_r), std::min(degrees(theta_d), 89.9), epsilon))}};
}

adaptive::TelemetryWriter::Extra of_samples(const adaptive::SliceDescription& slice, float theta_r, float phi_r) {
  const std::vector<HairParameter> p = hair_parameters(slice);
  Json fiber;
  for (const HairParameter& parameter : p) fiber[parameter.name] = parameter.value;
  adaptive::TelemetryWriter::Extra words{
      {"fiber", json_text(fiber)},
      {"angles", json_text(Json{{"theta_r_deg", degrees(theta_r)}, {"phi_r_deg", degrees(phi_r)}})}};
  if (p.size() == 4) {
    words.emplace("command",
                  json_text(fmt::format(
                      "tress-lab far-field --model rough --eta {} --e {} --alpha {} --tilt {} --theta-r {} --phi-r {}",
                      p[0].value, p[1].value, p[2].value, p[3].value, degrees(theta_r), degrees(phi_r))));
  }
  return words;
}

}  // namespace

adaptive::TelemetryWriter::Extra words_of_row(const adaptive::SliceDescription& slice, std::uint32_t node,
                                              double epsilon) {
  const auto width = static_cast<std::uint32_t>(slice.axis_b.size());
  if (node >= slice.node_count()) return {};
  const float a = slice.axis_a[node / width], b = slice.axis_b[node % width];
  if (slice.kind == adaptive::SliceKind::samples)
    return slice.key.lobe == fiber::rough_slice_lobe ? of_samples(slice, a, b) : adaptive::TelemetryWriter::Extra{};
  const std::uint32_t lobe = slice.key.lobe;
  const bool is_known = (lobe >= 1 && lobe <= 3) || lobe == fiber::glint_slice || lobe == fiber::trt_rest_slice;
  return is_known ? of_density(slice.key, a, b, epsilon) : adaptive::TelemetryWriter::Extra{};
}

}  // namespace tress::cli
