#include "base/numbered_file.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

namespace tress::inline v0_2 {
namespace {

/// Returns the start of the last run of # and its length, or a length of 0 if the name has no #.
std::pair<std::size_t, std::size_t> mark_in(const std::string& name) {
  const std::size_t last = name.rfind('#');
  if (last == std::string::npos) return {0, 0};
  std::size_t first = last;
  while (first > 0 && name[first - 1] == '#') --first;
  return {first, last - first + 1};
}

}  // namespace

bool names_frames(const std::filesystem::path& file) { return mark_in(file.filename().string()).second > 0; }

std::filesystem::path of_frame(const std::filesystem::path& file, int frame) {
  std::string name = file.filename().string();
  const auto [first, length] = mark_in(name);
  if (length == 0) return file;
  std::string number = std::to_string(frame);
  const std::size_t zeros = length - std::min(length, number.size());
  number.insert(frame < 0 ? 1 : 0, zeros, '0');
  name.replace(first, length, number);
  return file.parent_path() / name;
}

}  // namespace tress::inline v0_2
