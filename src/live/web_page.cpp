#include "live/web_page.h"

#include <nlohmann/json.hpp>

namespace tress::live {

std::string script_text(const nlohmann::ordered_json& data) {
  const std::string json = data.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  std::string text;
  text.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      text += "\\u003c";  // it occurs only within strings, where it means the same
    else
      text += c;
  }
  return text;
}

std::string whole_page(const std::string& page, const nlohmann::ordered_json& data, const WebAssets& own) {
  const auto asset = [&own](const std::string& name) {
    const auto found = own.find(name);
    return found != own.end() ? found->second : web_assets().at(name);
  };
  std::string_view rest = asset(page);
  std::string text;
  for (;;) {
    const std::size_t begin = rest.find("{{");
    const std::size_t end = begin == std::string_view::npos ? begin : rest.find("}}", begin);
    if (end == std::string_view::npos) return text += rest;
    text += rest.substr(0, begin);
    const std::string name(rest.substr(begin + 2, end - begin - 2));
    text += name == "data" ? script_text(data) : std::string(asset(name));
    rest.remove_prefix(end + 2);
  }
}

}  // namespace tress::live
