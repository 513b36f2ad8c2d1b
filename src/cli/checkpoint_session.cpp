#include "cli/checkpoint_session.h"

#include <fmt/format.h>

#include <map>
#include <system_error>
#include <utility>

#include "base/section_file.h"
#include "cli/console.h"
#include "cli/telemetry_lines.h"

namespace tress::cli {

std::optional<Error> write_saved_render(const std::filesystem::path& file, const Identity& identity,
                                        const nlohmann::json& progress, const integrate::PassProgress& pass,
                                        const std::string* table) {
  nlohmann::json all = progress;
  all["passes"] = pass.pass + 1;
  all["paths"] = pass.paths_so_far;
  const std::string identity_bytes = identity_text(identity), progress_bytes = json_text(all);
  Sections sections{{"identity", identity_bytes}, {"progress", progress_bytes}};
  if (table != nullptr) sections.emplace_back("table", *table);
  for (auto& section : pass.sections()) sections.push_back(std::move(section));
  return write_sections(file, sections);
}

Result<SavedRender> read_saved_render(const std::filesystem::path& file, const Identity* own,
                                      const std::vector<std::string>& ignored) {
  auto sections = read_sections(file);
  if (!sections) return sections.error();
  const std::optional<Identity> identity = parse_identity((*sections)["identity"]);
  if (!identity) return Error{file.string(), "identity", "a JSON object of texts", "another section, or none"};
  if (const std::string text = own == nullptr ? "" : differences(*own, *identity, ignored); !text.empty())
    return Error{file.string(), "", "", "a file of another render: " + text};
  SavedRender saved;
  saved.identity = *identity;
  saved.progress = nlohmann::json::parse((*sections)["progress"], nullptr, false);
  const auto is_count = [&](const char* name, std::uint64_t most) {
    return saved.progress.contains(name) && saved.progress[name].is_number_unsigned() &&
           saved.progress[name].get<std::uint64_t>() <= most;
  };
  if (!saved.progress.is_object() || !is_count("passes", 1u << 30) || !is_count("paths", ~std::uint64_t{0}))
    return Error{file.string(), "progress", "passes and paths", "another section, or none"};
  saved.render.passes = saved.progress["passes"].get<int>();
  saved.render.paths = saved.progress["paths"].get<std::uint64_t>();
  if (const auto table = sections->find("table"); table != sections->end()) saved.table = std::move(table->second);
  saved.render.sections = std::move(*sections);
  return saved;
}

CheckpointSession::CheckpointSession(std::filesystem::path file, double interval_seconds, Identity identity)
    : file_(std::move(file)),
      interval_seconds_(interval_seconds),
      identity_(std::move(identity)),
      last_(Clock::now()) {}

Result<std::optional<SavedRender>> CheckpointSession::open() const {
  std::error_code error;
  if (std::filesystem::status(file_, error).type() == std::filesystem::file_type::not_found)
    return std::optional<SavedRender>();
  Result<SavedRender> saved = read_saved_render(file_, &identity_);
  if (!saved) return saved.error();
  return std::optional<SavedRender>(std::move(*saved));
}

bool CheckpointSession::is_due() const {
  const double since = std::chrono::duration<double>(Clock::now() - last_).count();
  return since >= interval_seconds_ && since >= share * spent_seconds_;
}

bool CheckpointSession::save(const integrate::PassProgress& pass, const adaptive::Service* service,
                             const nlohmann::json& progress) {
  last_ = Clock::now();
  std::optional<Error> error;
  if (service != nullptr) {
    const Result<std::string> table = service->state();
    error = table ? write_saved_render(file_, identity_, progress, pass, &*table) : std::optional(table.error());
  } else {
    error = write_saved_render(file_, identity_, progress, pass, nullptr);
  }
  if (error) {
    if (!fails_) {
      log_warning("checkpoint: not written, the one before stays, and the render goes on and tries again: " +
                  error->message());
    }
    fails_ = true;
    return false;
  }
  fails_ = false;
  return true;
}

void CheckpointSession::remove() const {
  std::error_code error;
  std::filesystem::remove(file_, error);
  if (error) log_warning(fmt::format("checkpoint {}: not removed: {}", file_.string(), error.message()));
}

}  // namespace tress::cli
