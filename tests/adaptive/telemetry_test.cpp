// Every line that is written satisfies the published schema, and no field of the host can break one.
#include "tress/adaptive/telemetry.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

namespace tress::inline v0_2::adaptive {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// The part of JSON Schema that schema.json uses. Returns the first fault, or "".
class SchemaCheck {
 public:
  explicit SchemaCheck(json schema) : root_(std::move(schema)) {}
  std::string line(const json& value) const { return check(root_, value, ""); }

 private:
  static bool is(const std::string& type, const json& value) {
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "boolean") return value.is_boolean();
    if (type == "null") return value.is_null();
    if (type == "integer") return value.is_number_integer();
    return type == "number" && value.is_number();
  }

  std::string check(const json& schema, const json& value, const std::string& at) const {
    if (schema.contains("$ref")) {
      const auto pointer = json::json_pointer(schema["$ref"].get<std::string>().substr(1));
      if (auto fault = check(root_.at(pointer), value, at); !fault.empty()) return fault;
    }
    if (schema.contains("type")) {
      const json types = schema["type"].is_array() ? schema["type"] : json::array({schema["type"]});
      if (std::none_of(types.begin(), types.end(), [&](const json& type) { return is(type, value); })) {
        return at + ": not of type " + types.dump();
      }
    }
    if (schema.contains("const") && schema["const"] != value) return at + ": not " + schema["const"].dump();
    if (schema.contains("enum") &&
        std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end()) {
      return at + ": not one of " + schema["enum"].dump();
    }
    if (value.is_number() && schema.contains("minimum") && value < schema["minimum"]) return at + ": too small";
    if (value.is_number() && schema.contains("maximum") && value > schema["maximum"]) return at + ": too large";
    if (value.is_array() && schema.contains("minItems") && value.size() < schema["minItems"]) return at + ": too short";
    if (value.is_array() && schema.contains("maxItems") && value.size() > schema["maxItems"]) return at + ": too long";
    if (schema.contains("required")) {
      for (const std::string name : schema["required"]) {
        if (!value.contains(name)) return at + "/" + name + ": missing";
      }
    }
    if (schema.contains("properties") && value.is_object()) {
      for (const auto& [name, part] : schema["properties"].items()) {
        if (!value.contains(name)) continue;
        if (auto fault = check(part, value[name], at + "/" + name); !fault.empty()) return fault;
      }
    }
    if (schema.contains("items") && value.is_array()) {
      for (const json& item : value) {
        if (auto fault = check(schema["items"], item, at + "[]"); !fault.empty()) return fault;
      }
    }
    if (schema.contains("oneOf")) {
      int matches = 0;
      std::string faults;
      for (const json& choice : schema["oneOf"]) {
        const std::string fault = check(choice, value, at);
        if (fault.empty()) ++matches;
        faults += " " + fault;
      }
      if (matches != 1) return at + ": matches " + std::to_string(matches) + " choices:" + faults;
    }
    return "";
  }

  json root_;
};

class Telemetry : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "tress_telemetry_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    file_ = folder_ / "run.jsonl";
    auto created = TelemetryWriter::create(file_);
    ASSERT_TRUE(created);
    writer_ = std::move(*created);
  }
  void TearDown() override {
    writer_.reset();
    fs::remove_all(folder_);
  }

  /// What another process would read now.
  std::vector<json> lines() const {
    std::vector<json> result;
    std::ifstream in(file_);
    for (std::string line; std::getline(in, line);) result.push_back(json::parse(line));
    return result;
  }

  static SchemaCheck schema() {
    std::ifstream in(fs::path(TRESS_SOURCE_DIR) / "adaptive/telemetry/schema.json");
    return SchemaCheck(json::parse(in));
  }

  fs::path folder_, file_;
  std::unique_ptr<TelemetryWriter> writer_;
  const TelemetryWriter::Extra of_pass_{{"pass", "3"}, {"pixels", "4096"}, {"samples", "8192"}, {"seconds", "0.25"}};
};

TEST_F(Telemetry, APassAsTextIsTheLineThatIsWritten) {
  PassReport report;
  report.queries = 12;
  report.bytes = 345;
  ASSERT_FALSE(writer_->pass(report, {}));
  std::string line;
  std::getline(std::ifstream(file_) >> std::ws, line);
  EXPECT_EQ(to_json(report), line);
}

TEST_F(Telemetry, LinesSatisfyTheSchemaAndAreThereAtOnce) {
  PassReport report;
  report.queries = 200;
  report.converged_queries = 150;
  report.rows_open = 7;
  report.objective_p99 = 0.02;
  report.absorbed_objective = {6, 0.01, 0.04, 0.3};
  report.components[8] = 5;
  report.ribbons = 9;
  report.unusable = 1;
  RowReport row;
  row.slice = {2, {1.55f, 0.85f, 0.2f}};
  row.objective = -1;
  ASSERT_FALSE(writer_->header({{"scene", "\"a.json\""}, {"epsilon", "0.01"}}));
  EXPECT_EQ(lines().size(), 1u);
  ASSERT_FALSE(writer_->pass(report, of_pass_));
  EXPECT_EQ(lines().size(), 2u);
  ASSERT_FALSE(writer_->row(row, {}));
  row.state = RowState::converged;
  row.objective = 0.004;
  ASSERT_FALSE(writer_->row(row, {{"pass", "3"}}));
  row.slice.parameters[7] = 2;
  row.ribbons = 4;
  ASSERT_FALSE(writer_->row(row, {}));
  ASSERT_FALSE(writer_->summary({{"status", "\"done\""}}));

  const std::vector<json> written = lines();
  ASSERT_EQ(written.size(), 6u);
  const SchemaCheck check = schema();
  for (const json& line : written) EXPECT_EQ(check.line(line), "") << line;
  EXPECT_EQ(written[1]["converged_query_share"], 0.75);
  EXPECT_EQ(written[1]["rows"]["open"], 7);
  EXPECT_EQ(written[1]["objective"]["p99"], 0.02);
  EXPECT_EQ(written[1]["objective_absorbed"], json({{"rows", 6}, {"p50", 0.01}, {"p90", 0.04}, {"max", 0.3}}));
  EXPECT_EQ(written[1]["components"], json({0, 0, 0, 0, 0, 0, 0, 0, 5}));
  EXPECT_EQ(written[1]["knots"], json({0, 0, 0}));
  EXPECT_EQ(written[1]["seconds"], 0.25);
  EXPECT_TRUE(written[2]["objective"].is_null());
  EXPECT_EQ(written[3]["state"], "converged");
  EXPECT_EQ(written[3]["page"]["lobe"], 2);
  EXPECT_EQ(written[3]["page"]["parameters"].size(), 3u);
  EXPECT_EQ(written[4]["page"]["parameters"].size(), 8u) << "as a slice of samples may have";
  EXPECT_EQ(written[4]["ribbons"], 4);
  EXPECT_EQ(written[1]["ribbons"], 9);
  EXPECT_EQ(written[1]["unusable"], 1);
}

// The checker can fail: each required field of a pass, taken away or of another type, is missed.
TEST_F(Telemetry, SchemaMissesWhatIsTakenAway) {
  ASSERT_FALSE(writer_->pass({}, of_pass_));
  const json line = lines().at(0);
  const SchemaCheck check = schema();
  ASSERT_EQ(check.line(line), "");
  for (const auto& [name, value] : line.items()) {
    json without = line, other = line;
    without.erase(name);
    other[name] = "text";
    EXPECT_NE(check.line(without), "") << name;
    EXPECT_NE(check.line(other), "") << name;
  }
}

TEST_F(Telemetry, NumbersThatAreNotFiniteBecomeNull) {
  PassReport report;
  report.objective_max = std::numeric_limits<double>::quiet_NaN();
  report.effective_sample_size = std::numeric_limits<double>::infinity();
  ASSERT_FALSE(writer_->pass(report, of_pass_));
  const json line = lines().at(0);
  EXPECT_TRUE(line["objective"]["max"].is_null());
  EXPECT_EQ(schema().line(line), "");
}

TEST_F(Telemetry, RefusesFieldsThatWouldBreakALine) {
  for (const std::string text : {"", "3,\"a\":4", "text", "\"open", "nan", "1e999", "{}\n{}", "\"\xff\""}) {
    const std::optional<Error> error = writer_->header({{"field", text}});
    ASSERT_TRUE(error) << text;
    EXPECT_EQ(error->place, "/field");
    EXPECT_EQ(error->file, file_.string());
  }
  EXPECT_TRUE(writer_->header({{"field", std::string(100000, '[') + std::string(100000, ']')}}));
  EXPECT_TRUE(writer_->header({{"type", "\"pass\""}}));
  EXPECT_TRUE(writer_->pass({}, {{"queries", "3"}}));
  EXPECT_TRUE(lines().empty());
  // Line feeds between tokens, and names that are not UTF-8, stay within the line.
  ASSERT_FALSE(writer_->header({{"field", "{\n\"a\":\n1}"}, {"\xff\n\"", "1"}}));
  EXPECT_EQ(lines().size(), 1u);
}

TEST_F(Telemetry, ReportsThatTheDiskIsFull) {
  ASSERT_TRUE(fs::exists("/dev/full")) << "Linux has this device";
  auto full = TelemetryWriter::create("/dev/full");
  ASSERT_TRUE(full);
  ASSERT_TRUE((*full)->header({}));
  const std::optional<Error> again = (*full)->summary({});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->file, "/dev/full");
  EXPECT_FALSE(TelemetryWriter::create(folder_ / "missing" / "run.jsonl").has_value());
}

// By a limit on file sizes in a child of its own, at every size from nothing to two lines.
TEST_F(Telemetry, LeavesNoPartOfALineThatFoundNoRoom) {
  ASSERT_FALSE(writer_->header({}));
  const std::uintmax_t line = fs::file_size(file_);
  for (std::uintmax_t room = 0; room < 2 * line; room += 3) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{room, room};
      if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) ::_exit(2);
      auto writer = TelemetryWriter::create(file_);
      if (!writer) ::_exit(3);
      bool failed = false;
      for (int i = 0; i < 2; ++i) failed = (*writer)->header({}).has_value() || failed;
      ::_exit(failed ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0) << room;
    EXPECT_EQ(fs::file_size(file_), room / line * line);
  }
}

TEST_F(Telemetry, APipeWhoseReaderHasGoneIsAnError) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  const auto former = std::signal(SIGPIPE, SIG_IGN);
  auto writer = TelemetryWriter::create(pipe);
  ASSERT_TRUE(writer);
  EXPECT_FALSE((*writer)->header({}));
  ::close(reader);
  const std::optional<Error> error = (*writer)->summary({});
  std::signal(SIGPIPE, former);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->file, pipe.string());
  EXPECT_FALSE(error->found.empty());
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
