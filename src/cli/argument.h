// Numbers as typed on the command line, read whole and kept in range.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "image/picture.h"

namespace tress::cli {

/// What a number must be. Both ends belong to the range unless open.
struct Range {
  double low, high;
  bool low_open = false, high_open = false;
  std::string words() const;  ///< "0 < x <= 1"
  bool contains(double x) const;
};

/// The number that the whole text spells, finite; nothing else around it.
std::optional<double> parse_number(const std::string& text);
std::optional<std::uint64_t> parse_unsigned(const std::string& text);
/// Comma-separated numbers.
std::optional<std::vector<double>> parse_numbers(const std::string& text);
/// "640x480".
struct Resolution {
  int width, height;
};
std::optional<Resolution> parse_resolution(const std::string& text);
/// "X0,Y0,X1,Y1": pixels [X0, X1) x [Y0, Y1), at least one, of an image of no more than 2^24 a side.
std::optional<image::Window> parse_crop(const std::string& text);

}  // namespace tress::cli
