// Scene-linear light as a display shows it: what a preview does before it rounds to 8 bits.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tress::image {

/// standard: clamped to [0, 1], sRGB (IEC 61966-2-1): what is brighter than 1 is cut off, each channel by itself.
/// neutral: Khronos PBR Neutral (Khronos Group, 2024): colors up to about 0.8 stay as they are but for 0.04 less
/// light, above that the largest channel is compressed and the color goes to white.
/// agx: AgX (Sobotka, 2022) without a look, its curve by the polynomial of Wrensch (2023), 0.002 off at the root of
/// the mean square: like film, 10 stops below middle grey and 6.5 above, the colors of bright light going to white.
enum class View { standard, neutral, agx };

/// "standard", "neutral", "agx": in the order of the enumeration.
std::vector<std::string> view_names();
/// By one of these names; nothing by another.
std::optional<View> view_of(std::string_view name);

/// Scene-linear RGB with the primaries of sRGB to the values that a display gets, each in [0, 1]; NaN is 0. The same
/// grey of three channels stays grey. Pure.
glm::vec3 displayed(View view, const glm::vec3& linear);

}  // namespace tress::image
