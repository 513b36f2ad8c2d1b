#include "cli/argument.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

namespace tress::cli {

std::string Range::words() const {
  return fmt::format("a number {} {} and {} {}", low_open ? ">" : ">=", low, high_open ? "<" : "<=", high);
}

bool Range::contains(double x) const { return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high); }

std::optional<double> parse_number(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::uint64_t> parse_unsigned(const std::string& text) {
  std::uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

std::optional<std::vector<double>> parse_numbers(const std::string& text) {
  std::vector<double> values;
  std::size_t begin = 0;
  while (true) {
    const std::size_t comma = text.find(',', begin);
    const std::optional<double> value = parse_number(text.substr(begin, comma - begin));
    if (!value) return std::nullopt;
    values.push_back(*value);
    if (comma == std::string::npos) return values;
    begin = comma + 1;
  }
}

std::optional<Resolution> parse_resolution(const std::string& text) {
  const std::size_t by = text.find('x');
  if (by == std::string::npos) return std::nullopt;
  const auto width = parse_unsigned(text.substr(0, by));
  const auto height = parse_unsigned(text.substr(by + 1));
  constexpr std::uint64_t largest = std::numeric_limits<int>::max();
  if (!width || !height || *width > largest || *height > largest) return std::nullopt;
  return Resolution{static_cast<int>(*width), static_cast<int>(*height)};
}

std::optional<image::Window> parse_crop(const std::string& text) {
  constexpr std::uint64_t largest = 1 << 24;
  std::vector<int> edges;
  std::size_t begin = 0;
  while (begin != std::string::npos) {
    const std::size_t comma = text.find(',', begin);
    const auto edge = parse_unsigned(text.substr(begin, comma == std::string::npos ? comma : comma - begin));
    if (!edge || *edge > largest) return std::nullopt;
    edges.push_back(static_cast<int>(*edge));
    begin = comma == std::string::npos ? comma : comma + 1;
  }
  if (edges.size() != 4 || edges[0] >= edges[2] || edges[1] >= edges[3]) return std::nullopt;
  return image::Window{edges[0], edges[1], edges[2] - edges[0], edges[3] - edges[1]};
}

}  // namespace tress::cli
