// Converts scene-linear light to values for a display, before a preview rounds them to 8 bits.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tress::image {

/// standard: sRGB (IEC 61966-2-1). Each channel is clamped to [0, 1].
/// neutral: Khronos PBR Neutral (Khronos Group, 2024). Colors up to about 0.8 keep their values minus 0.04; above that
/// the largest channel is compressed and the color goes to white.
/// agx: AgX (Sobotka, 2022) without a look. Its curve is the polynomial of Wrensch (2023), with an RMS error of 0.002.
/// It is like film: it shows 10 stops below middle grey and 6.5 above, and bright colors go to white.
enum class View { standard, neutral, agx };

/// The names "standard", "neutral", "agx", in the order of the enumeration.
std::vector<std::string> view_names();
/// The view with this name; empty for any other name.
std::optional<View> view_of(std::string_view name);

/// Converts scene-linear RGB with the primaries of sRGB to display values in [0, 1]; NaN becomes 0. Grey stays grey.
/// Thread-safe.
glm::vec3 displayed(View view, const glm::vec3& linear);

}  // namespace tress::image
