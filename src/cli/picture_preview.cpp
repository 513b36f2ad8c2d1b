#include "cli/picture_preview.h"

#include <cstdlib>
#include <string_view>

namespace tress::cli {
namespace {

std::string_view entry_of(const std::map<std::string, std::string>& header, const char* name) {
  const auto found = header.find(name);
  return found == header.end() ? std::string_view() : std::string_view(found->second);
}

}  // namespace

image::Preview preview_of(const std::map<std::string, std::string>& header) {
  image::Preview preview;
  preview.alpha = entry_of(header, "alpha").ends_with(alpha_of_png);
  preview.exposure_stops = std::strtod(std::string(entry_of(header, "exposure")).c_str(), nullptr);
  const std::string_view view = entry_of(header, "view");
  if (const auto known = image::view_of(view.substr(0, view.find(',')))) preview.view = *known;
  return preview;
}

}  // namespace tress::cli
