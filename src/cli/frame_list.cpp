#include "cli/frame_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <set>

#include "cli/options.h"

namespace tress::cli {
namespace {

constexpr std::int64_t last_frame = 1'000'000;
constexpr std::size_t most_frames = 1'000'000;

struct Range {
  std::int64_t first = 0, last = 0, step = 1;
};

std::optional<Range> parse_range(const std::string& text) {
  const std::size_t by = text.find('x');
  const std::string ends = text.substr(0, by);
  const std::size_t dash = ends.find('-', 1);  // a dash before the first number is its sign
  const auto first = parse_signed(ends.substr(0, dash));
  const auto last = dash == std::string::npos ? first : parse_signed(ends.substr(dash + 1));
  const auto step = by == std::string::npos ? std::optional<std::uint64_t>(1) : parse_unsigned(text.substr(by + 1));
  if (!first || !last || !step || *step == 0 || *last < *first || *first < -last_frame || *last > last_frame)
    return std::nullopt;
  if (dash == std::string::npos && by != std::string::npos) return std::nullopt;
  return Range{*first, *last, static_cast<std::int64_t>(std::min<std::uint64_t>(*step, 4 * last_frame))};
}

}  // namespace

std::optional<std::vector<int>> parse_frames(const std::string& text) {
  std::vector<int> frames;
  std::set<int> seen;
  for (std::size_t begin = 0; begin != std::string::npos;) {
    const std::size_t comma = text.find(',', begin);
    const auto range = parse_range(text.substr(begin, comma == std::string::npos ? comma : comma - begin));
    if (!range) return std::nullopt;
    for (std::int64_t frame = range->first; frame <= range->last; frame += range->step) {
      if (seen.insert(static_cast<int>(frame)).second) frames.push_back(static_cast<int>(frame));
      if (frames.size() > most_frames || range->step > last_frame) break;
    }
    if (frames.size() > most_frames) return std::nullopt;
    begin = comma == std::string::npos ? comma : comma + 1;
  }
  return frames;
}

}  // namespace tress::cli
