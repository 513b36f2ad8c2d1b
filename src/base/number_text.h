// Numbers in sentences.
#pragma once

#include <charconv>
#include <string>

namespace tress::inline v0_2 {

/// A number with six significant digits and without trailing zeros: "0.01", "1e+30", "nan"; the same in any locale.
inline std::string number_text(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number, std::chars_format::general, 6).ptr};
}

}  // namespace tress::inline v0_2
