// Runs the built command as a user would, and keeps what it said.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace tress::test {

namespace fs = std::filesystem;

inline std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

inline void write_text(const fs::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
}

struct Outcome {
  int status = -1;  ///< exit status; 128 + signal if killed
  std::string out, err;
};

/// A started tress, or another program; standard output and error go to files in `folder`.
class Process {
 public:
  Process(const fs::path& folder, std::vector<std::string> arguments, const char* program = TRESS_BINARY)
      : folder_(folder) {
    arguments.insert(arguments.begin(), program);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    const std::string out = (folder / "stdout").string(), err = (folder / "stderr").string();
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&actions, 2, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawnattr_t attributes;  // signals as from a terminal, whatever runs the tests
    posix_spawnattr_init(&attributes);
    sigset_t standard;
    sigemptyset(&standard);
    for (const int signal : {SIGHUP, SIGINT, SIGTERM}) sigaddset(&standard, signal);
    posix_spawnattr_setsigdefault(&attributes, &standard);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
    if (posix_spawn(&id_, program, &actions, &attributes, argv.data(), environ) != 0) id_ = -1;
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
  }

  void send(int signal) const {
    if (id_ > 0) ::kill(id_, signal);
  }

  Outcome wait() const {
    Outcome outcome;
    int status = 0;
    if (id_ > 0 && waitpid(id_, &status, 0) == id_) {
      outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    outcome.out = read_text(folder_ / "stdout");
    outcome.err = read_text(folder_ / "stderr");
    return outcome;
  }

 private:
  fs::path folder_;
  pid_t id_ = -1;
};

/// A folder of its own for each test.
class CommandTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) /
              ("tress_" + std::string(info->test_suite_name()) + "_" + info->name() + "_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  Outcome run(const std::vector<std::string>& arguments) const { return Process(folder_, arguments).wait(); }
  /// What it prints as JSON; an empty object, and a failure, where it ends otherwise.
  nlohmann::json run_json(const std::vector<std::string>& arguments) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    nlohmann::json json = nlohmann::json::parse(outcome.out, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << outcome.out;
    return json.is_discarded() ? nlohmann::json::object() : json;
  }

  fs::path folder_;
};

/// The lines of a telemetry file of one type, without a last one that has no end: a render may be writing it.
inline std::vector<nlohmann::json> telemetry_lines(const fs::path& file, const std::string& type) {
  std::vector<nlohmann::json> lines;
  std::string written = read_text(file);
  written.erase(written.rfind('\n') + 1);
  std::istringstream text(written);
  for (std::string line; std::getline(text, line);) {
    nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << line;
    if (!json.is_discarded() && json.value("type", "") == type) lines.push_back(std::move(json));
  }
  return lines;
}

}  // namespace tress::test
