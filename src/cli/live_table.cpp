#include "cli/live_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <vector>

#include "base/pi.h"
#include "cli/row_words.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::cli {
namespace {

using Json = nlohmann::ordered_json;
using adaptive::RowState;

constexpr int azimuths = 361;

Json degrees_of(const std::vector<float>& axis) {
  Json list = Json::array();
  for (const float x : axis) list.push_back(std::round(double(x) / degree * 100) / 100);
  return list;
}

char letter_of(RowState state) {
  switch (state) {
    case RowState::open:
      return 'o';
    case RowState::converged:
      return 'c';
    case RowState::refused:
      return 'r';
    default:
      return '.';
  }
}

const char* word_of(RowState state) {
  switch (state) {
    case RowState::open:
      return "open";
    case RowState::converged:
      return "converged";
    case RowState::refused:
      return "refused";
    default:
      return "no row yet";
  }
}

Json parsed(const adaptive::TelemetryWriter::Extra& words, const char* name) {
  const auto found = words.find(name);
  return found == words.end() ? Json(nullptr) : Json::parse(found->second, nullptr, false);
}

/// "TT: eta 1.55, eccentricity 0.85, sigma_deg 5.73".
std::string name_of(const adaptive::SliceDescription& slice, double epsilon) {
  const Json fiber = parsed(words_of_row(slice, 0, epsilon), "fiber");
  if (!fiber.is_object()) return fmt::format("slice {}", slice.key.lobe);
  std::string lobe = "all lobes", text;
  for (const auto& [name, value] : fiber.items()) {
    if (name == "lobe")
      lobe = value.get<std::string>();
    else if (value.is_number())
      text += fmt::format("{}{} {:.4g}", text.empty() ? "" : ", ", name, value.get<double>());
  }
  return lobe + ": " + text;
}

}  // namespace

Json table_json(const adaptive::Service& service) {
  Json slices = Json::array();
  for (adaptive::SliceId id = 0; id < std::min(service.slice_count(), most_slices); ++id) {
    const adaptive::SliceDescription& slice = service.slice(id);
    const bool is_sampled = slice.kind == adaptive::SliceKind::samples;
    std::string states;
    std::vector<float> error, light;
    for (std::uint32_t a = 0; a < slice.axis_a.size(); ++a) {
      for (std::uint32_t b = 0; b < slice.axis_b.size(); ++b) {
        const adaptive::RowView row = service.peek(id, a, b);
        states += letter_of(row.state);
        error.push_back(row.objective);
        light.push_back(static_cast<float>(service.light(id, a, b)));
      }
    }
    slices.push_back({{"name", name_of(slice, service.options().epsilon)},
                      {"name_a", is_sampled ? "theta_r" : "phi_r"},
                      {"name_b", is_sampled ? "phi_r" : "theta_d"},
                      {"a", degrees_of(slice.axis_a)},
                      {"b", degrees_of(slice.axis_b)},
                      {"states", states},
                      {"error", error},
                      {"light", light}});
  }
  return {{"slices", std::move(slices)}};
}

Json row_json(const adaptive::Service& service, std::uint32_t id, std::uint32_t node) {
  if (id >= service.slice_count() || node >= service.slice(id).node_count()) return {{"words", "no such row"}};
  const adaptive::SliceDescription& slice = service.slice(id);
  const auto width = static_cast<std::uint32_t>(slice.axis_b.size());
  const adaptive::RowView row = service.peek(id, node / width, node % width);
  const double epsilon = service.options().epsilon;
  std::string words = fmt::format("{}; {}", name_of(slice, epsilon), word_of(row.state));
  const auto of_row = words_of_row(slice, node, epsilon);
  const Json angles = parsed(of_row, "angles");
  if (angles.is_object()) {
    for (const auto& [name, value] : angles.items()) words += fmt::format(", {} {:.4g}", name, value.get<double>());
  }
  Json fields{{"words", words}, {"command", parsed(of_row, "command")}};
  if (slice.kind == adaptive::SliceKind::samples) {
    fields["words"] = words + "; a row of samples, over a cylinder: the command shows it";
    return fields;
  }
  std::vector<adaptive::TracedRay> rays;
  fiber::make_elliptical_target()->trace(slice, slice.axis_a[node / width], slice.axis_b[node % width], rays);
  const adaptive::TracedNodes target(rays, slice.blur_rad);
  const bool has_fit = row.fit != nullptr;
  Json phi = Json::array(), g = Json::array(), fit = Json::array(), parts = Json::array();
  for (int i = 0; i < azimuths; ++i) {
    const double x = -180 + 360.0 * i / (azimuths - 1);
    phi.push_back(x);
    g.push_back(target.density(static_cast<float>(x * degree)));
    if (has_fit) fit.push_back(row.density(static_cast<float>(x * degree)));
  }
  const double objective = double(row.objective);
  fields["words"] =
      fmt::format("{}; energy {:.4g}{}{}", words, target.energy(),
                  has_fit ? fmt::format(", error at most {:.3g} of epsilon {:.3g}", objective, epsilon) : "",
                  row.fit != nullptr ? fmt::format(", {} components", row.fit->component_count) : "");
  if (row.fit != nullptr) {
    const adaptive::Mixture mixture = *row.fit;
    for (const adaptive::Component& part : mixture.parts()) {
      parts.push_back(Json::array());
      for (const double x : phi) parts.back().push_back(part.weight * part.shape.density(float(x * degree)));
    }
    parts.push_back(std::vector<double>(phi.size(), double(mixture.uniform_weight) / (2 * std::numbers::pi)));
  }
  fields["phi_deg"] = std::move(phi);
  if (!parts.empty()) fields["parts"] = std::move(parts);
  fields["target"] = std::move(g);
  if (has_fit) fields["fit"] = std::move(fit);
  return fields;
}

}  // namespace tress::cli
