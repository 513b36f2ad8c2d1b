#include "live/report_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace tress::live {
namespace {

using Json = nlohmann::ordered_json;

double number(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? found->get<double>() : 0;
}

Json field(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() ? *found : Json(nullptr);
}

std::string text_of(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// The numbers of {"eta": 1.55, "sigma_deg": 5.72} as text: "eta 1.55, sigma_deg 5.73".
std::string words(const Json& object) {
  std::string text;
  if (!object.is_object()) return text;
  for (const auto& [name, value] : object.items()) {
    if (!text.empty()) text += ", ";
    if (name != "lobe") text += name + " ";
    text += value.is_number()   ? fmt::format("{:.4g}", value.get<double>())
            : value.is_string() ? value.get<std::string>()
                                : value.dump();
  }
  return text;
}

class Run {
 public:
  Run(std::string name, Json header) : name_(std::move(name)), header_(std::move(header)) {}

  void add(const Json& line) {
    const std::string type = text_of(line, "type");
    if (type == "pass") add_pass(line);
    if (type == "summary") summary_ = line;
    if (type == "row") rows_[field(line, "page").dump() + field(line, "node").dump()] = line;
  }

  Json to_json() const {
    return {{"name", name_},        {"header", header_}, {"passes", passes_}, {"summary", summary_},
            {"verdict", verdict()}, {"cost", cost()},    {"cache", cache()},  {"left", left()}};
  }

 private:
  void add_pass(const Json& line) {
    Json pass;
    for (const char* name :
         {"pass", "samples", "seconds", "cpu_seconds", "noise", "converged_query_share", "answered_query_share",
          "queries", "g_evaluations", "learning_cpu_seconds", "bytes", "bias_bound", "at_ceiling"})
      pass[name] = field(line, name);
    const Json rows = field(line, "rows"), objective = field(line, "objective");
    for (const char* name : {"touched", "coarse", "open", "converged", "reopened", "refused"})
      pass[name] = field(rows, name);
    for (const char* name : {"p50", "p90", "p99", "max"}) pass[name] = field(objective, name);
    passes_.push_back(std::move(pass));
  }

  Json verdict() const {
    if (passes_.empty()) return {{"good", false}, {"text", "no pass has ended"}};
    const Json& last = passes_.back();
    // Files of version 0.2 and before have only the converged share.
    const bool has_answered = field(last, "answered_query_share").is_number();
    const double share = number(last, has_answered ? "answered_query_share" : "converged_query_share");
    const bool any = std::ranges::any_of(passes_, [](const Json& pass) { return number(pass, "queries") > 0; });
    if (!any) return {{"good", true}, {"text", "no table was asked: nothing to converge"}};
    const bool good = share >= converged_share;
    std::string text = fmt::format(
        "{}: rows answered {:.4g} % of the queries of the last pass ({} % are called converged); {} rows have passed "
        "their test, {} are open, {} refused; their errors put the picture's brightness off by {:.2g} % at most",
        good ? "converged" : "not converged", 100 * share, 100 * converged_share, number(last, "converged"),
        number(last, "open"), number(last, "refused"), 100 * number(last, "bias_bound"));
    if (field(last, "at_ceiling") == true) text += "; a row had to wait for memory (--table-memory)";
    return {{"good", good}, {"text", text}};
  }

  Json cost() const {
    double g = 0, learning = 0, cpu = 0;
    for (const Json& pass : passes_) {
      g += number(pass, "g_evaluations");
      learning += number(pass, "learning_cpu_seconds");
      cpu += number(pass, "cpu_seconds");
    }
    return {{"g_evaluations", g},
            {"learning_cpu_seconds", learning},
            {"cpu_seconds", cpu},
            {"learning_share", cpu > 0 ? Json(learning / cpu) : Json(nullptr)}};
  }

  Json cache() const {
    const Json& source = summary_.is_object() && summary_.contains("warm_cache") ? summary_ : header_;
    const Json cache = field(source, "warm_cache");
    if (!cache.is_object()) return {{"loaded", "none"}};
    return {{"loaded", field(cache, "loaded")},
            {"rows_known", field(cache, "rows_known")},
            {"samples_known", field(cache, "samples_known")},
            {"cpu_seconds_spared", field(cache, "cpu_seconds_spared_estimate")}};
  }

  /// The rows that have not converged, by their last lines.
  Json left() const {
    if (rows_.empty())
      return {{"text", "the telemetry does not list single rows; a run with --telemetry-level rows does"},
              {"rows", Json::array()}};
    double light = 0, light_left = 0;
    std::multimap<double, const Json*, std::greater<>> left;  // by light; rows of equal light keep their order
    for (const auto& [place, row] : rows_) {
      light += number(row, "light");
      if (text_of(row, "state") == "converged") continue;
      light_left += number(row, "light");
      left.emplace(number(row, "light"), &row);
    }
    const auto share = [&](double part) { return light > 0 ? Json(part / light) : Json(nullptr); };
    Json rows = Json::array();
    for (const auto& [carried, row] : left) {
      if (rows.size() == most_rows_listed) break;
      rows.push_back({{"fiber", words(field(*row, "fiber"))},
                      {"angles", words(field(*row, "angles"))},
                      {"state", field(*row, "state")},
                      {"objective", field(*row, "objective")},
                      {"failed_tests", field(*row, "failed_tests")},
                      {"light", field(*row, "light")},
                      {"share", share(carried)},
                      {"command", field(*row, "command")}});
    }
    std::string text = fmt::format("{} of {} rows that were created or changed in this run", left.size(), rows_.size());
    if (light > 0) text += fmt::format("; they carry {:.3g} % of the light of all of these", 100 * light_left / light);
    if (left.size() > rows.size()) text += fmt::format("; the {} of most light are listed", rows.size());
    return {{"text", text}, {"rows", rows}};
  }

  std::string name_;
  Json header_, summary_;
  std::vector<Json> passes_;
  std::map<std::string, Json> rows_;  ///< the last line of each row, by slice and node
};

}  // namespace

Result<std::vector<Json>> report_data(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file))
    return Error{file.string(), "", "telemetry (JSON Lines)", "a file that cannot be read"};
  std::vector<Run> runs;
  std::string line;
  for (int place = 1; std::getline(stream, line); ++place) {
    const Json json = Json::parse(line, nullptr, false);
    const bool is_cut = json.is_discarded() && stream.eof();  // cut off by a kill
    if (is_cut || line.empty()) continue;
    const auto error = [&](const char* found) {
      return Error{file.string(), fmt::format("line {}", place), "an object of telemetry with a \"type\"", found};
    };
    if (json.is_discarded()) return error("no JSON");
    if (!json.is_object() || text_of(json, "type").empty()) return error("other JSON");
    if (text_of(json, "type") == "header") {
      const Json frame = field(json, "frame");
      const std::string name = file.filename().string();
      runs.emplace_back(frame.is_null() ? name : fmt::format("{} frame {}", name, frame.dump()), json);
    } else if (runs.empty()) {
      return error("a line before the header");
    } else {
      runs.back().add(json);
    }
  }
  if (runs.empty()) return Error{file.string(), "", "telemetry (JSON Lines)", "no header"};
  std::vector<Json> all;
  for (const Run& run : runs) all.push_back(run.to_json());
  return all;
}

}  // namespace tress::live
