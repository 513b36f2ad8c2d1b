// The pages, which are compiled into the program: src/live/web and the chart library.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace tress::live {

/// Contents by name of the file, "charts.js".
using WebAssets = std::map<std::string, std::string_view>;
const WebAssets& web_assets();

/// A page that needs no other file: each {{name}} of asset `page` becomes the asset of that name, {{data}} becomes
/// `data`. Text of the data cannot end the script that it stands in. An asset is one of `own` or of web_assets().
std::string whole_page(const std::string& page, const nlohmann::ordered_json& data, const WebAssets& own = {});

/// As JavaScript within HTML takes it; bytes that are no UTF-8 are replaced.
std::string script_text(const nlohmann::ordered_json& data);

}  // namespace tress::live
