// The pages, which are compiled into the program: src/live/web and the chart library.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace tress::live {

/// Contents by file name, such as "charts.js".
using WebAssets = std::map<std::string, std::string_view>;
const WebAssets& web_assets();

/// A page that needs no other file: each {{name}} in asset `page` is replaced by the asset of that name, {{data}} by
/// `data`. Text in the data cannot end the script that contains it. An asset is one of `own` or of web_assets().
std::string whole_page(const std::string& page, const nlohmann::ordered_json& data, const WebAssets& own = {});

/// JSON that is safe in JavaScript within HTML; bytes that are not UTF-8 are replaced.
std::string script_text(const nlohmann::ordered_json& data);

}  // namespace tress::live
