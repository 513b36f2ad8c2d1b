#include "image/view_transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>

namespace tress::image {
namespace {

constexpr std::array<const char*, 3> names{"standard", "neutral", "agx"};

float clamped(float x) { return x > 0 ? std::min(x, 1.0f) : 0.0f; }

float encode_srgb(float linear) {
  const float x = clamped(linear);
  return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
}

glm::vec3 encode_srgb(const glm::vec3& linear) {
  return {encode_srgb(linear.x), encode_srgb(linear.y), encode_srgb(linear.z)};
}

/// Makes a color finite and not negative.
glm::vec3 bounded(const glm::vec3& color) {
  static constexpr float brightest = 1e6f;
  const auto one = [](float x) { return x > 0 ? std::min(x, brightest) : 0.0f; };
  return {one(color.x), one(color.y), one(color.z)};
}

/// Converts linear to linear values by the specification of Khronos, ToneMapping/PBR_Neutral.
glm::vec3 khronos_neutral(glm::vec3 color) {
  constexpr float fresnel = 0.04f, compressed_from = 0.8f - fresnel, desaturation = 0.15f;
  const float least = std::min({color.x, color.y, color.z});
  color -= least < 2 * fresnel ? least - least * least / (4 * fresnel) : fresnel;
  const float peak = std::max({color.x, color.y, color.z});
  if (peak < compressed_from) return color;
  constexpr float room = 1 - compressed_from;
  const float new_peak = 1 - room * room / (peak + room - compressed_from);
  const float whiteness = 1 - 1 / (desaturation * (peak - new_peak) + 1);
  return glm::mix(color * (new_peak / peak), glm::vec3(new_peak), whiteness);
}

/// The polynomial that approximates the sigmoid of AgX, from [0, 1] to [0, 1].
float agx_curve(float x) {
  const float x2 = x * x, x4 = x2 * x2;
  return 15.5f * x4 * x2 - 40.14f * x4 * x + 31.96f * x4 - 6.868f * x2 * x + 0.4298f * x2 + 0.1191f * x - 0.00232f;
}

/// Converts linear to display values: inset of the primaries, logarithm in stops, curve, outset of the primaries.
glm::vec3 agx(const glm::vec3& color) {
  const glm::mat3 inset(0.842479062253094f, 0.0423282422610123f, 0.0423756549057051f,   //
                        0.0784335999999992f, 0.878468636469772f, 0.0784336f,            //
                        0.0792237451477643f, 0.0791661274605434f, 0.879142973793104f);  // by columns
  constexpr float least_stop = -12.47393f, most_stop = 4.026069f;
  glm::vec3 drawn = inset * color;
  for (int c = 0; c < 3; ++c) {
    const float stops = std::log2(std::max(drawn[c], 1e-10f));
    drawn[c] = agx_curve(clamped((stops - least_stop) / (most_stop - least_stop)));
  }
  return glm::inverse(inset) * drawn;
}

}  // namespace

std::vector<std::string> view_names() { return {names.begin(), names.end()}; }

std::optional<View> view_of(std::string_view name) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<View>(found - names.begin());
}

glm::vec3 displayed(View view, const glm::vec3& linear) {
  switch (view) {
    case View::neutral:
      return encode_srgb(khronos_neutral(bounded(linear)));
    case View::agx: {
      const glm::vec3 shown = agx(bounded(linear));
      return {clamped(shown.x), clamped(shown.y), clamped(shown.z)};
    }
    case View::standard:
      break;
  }
  return encode_srgb(linear);
}

}  // namespace tress::image
