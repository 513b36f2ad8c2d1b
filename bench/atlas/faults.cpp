// Programs for study 6: one that saves and saves, to be killed, and one that damages a cache at every byte.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tress/adaptive/cache.h"

namespace {

using tress::Error;
using tress::Result;
using namespace tress::adaptive;

/// The first `rows` rows of `image`, slices in turn.
TableSnapshot first_rows(const TableSnapshot& image, std::size_t rows) {
  TableSnapshot part{image.model, {}};
  for (const CachedSlice& slice : image.slices) part.slices.push_back({slice.description, {}});
  std::size_t left = rows;
  for (std::size_t i = 0; left > 0; ++i) {
    bool any = false;
    for (std::size_t p = 0; p < image.slices.size() && left > 0; ++p) {
      if (i >= image.slices[p].rows.size()) continue;
      part.slices[p].rows.push_back(image.slices[p].rows[i]);
      any = true;
      --left;
    }
    if (!any) break;
  }
  return part;
}

std::size_t row_count(const TableSnapshot& image) {
  std::size_t rows = 0;
  for (const CachedSlice& slice : image.slices) rows += slice.rows.size();
  return rows;
}

/// Merges one row more with every save and prints on standard output how many are saved. Ends only where it fails.
int save_for_ever(const TableSnapshot& image, const std::string& output) {
  const std::size_t all = row_count(image);
  for (std::size_t rows = 1;; rows = std::min(rows + 1, all)) {
    const Result<CacheUpdate> update = merge_into_cache(output, first_rows(image, rows));
    if (!update || update->refusal) {
      std::fprintf(stderr, "%s\n", (update ? *update->refusal : update.error()).message().c_str());
      return 1;
    }
    const std::string line = std::to_string(rows) + "\n";
    if (::write(STDOUT_FILENO, line.data(), line.size()) < 0) return 1;
  }
}

/// A reason without its numbers.
std::string kind_of(const Error& error) {
  if (error.expected.starts_with("checksum ")) return "checksum";
  if (error.expected.starts_with("model ")) return "model";
  std::string kind = error.expected;
  kind.erase(std::remove_if(kind.begin(), kind.end(), [](unsigned char c) { return std::isdigit(c) != 0; }),
             kind.end());
  return kind.substr(0, std::min(kind.find(" ("), kind.size()));
}

struct Damage {
  std::uint64_t tries = 0, refused = 0, unnamed = 0;
  std::map<std::string, std::uint64_t> reasons;

  void decode(const std::string& bytes, const std::string& model) {
    ++tries;
    const Result<TableSnapshot> image = decode_cache(bytes, model, "damaged.cache");
    if (image) return;
    const Error& error = image.error();
    ++refused;
    unnamed += error.file.empty() || error.place.empty() || error.expected.empty() || error.found.empty();
    ++reasons[kind_of(error)];
  }
  nlohmann::ordered_json json() const {
    return {{"tries", tries}, {"refused", refused}, {"unnamed", unnamed}, {"reasons", reasons}};
  }
};

/// Every other value of every byte, every length, and a few tails; with the model asked for and with any.
int damage(const TableSnapshot& image) {
  const std::string bytes = encode_cache(image);
  Damage flips, truncations, tails;
  std::string damaged = bytes;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (int mask = 1; mask < 256; ++mask) {
      damaged[i] = static_cast<char>(bytes[i] ^ mask);
      flips.decode(damaged, mask % 2 == 0 ? image.model : "");
    }
    damaged[i] = bytes[i];
    truncations.decode(bytes.substr(0, i), image.model);
  }
  for (int byte = 0; byte < 256; ++byte) tails.decode(bytes + static_cast<char>(byte), image.model);
  tails.decode(bytes + bytes, image.model);
  const nlohmann::ordered_json json = {{"bytes", bytes.size()},
                                       {"rows", row_count(image)},
                                       {"flips", flips.json()},
                                       {"truncations", truncations.json()},
                                       {"tails", tails.json()}};
  std::printf("%s\n", json.dump().c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Faults: saving for ever, and damage at every byte");
  app.require_subcommand(1);
  std::string from, output;
  std::size_t rows = 6;
  CLI::App* save = app.add_subcommand("save", "merge the rows of FROM into OUT, one more each time, until killed");
  CLI::App* bytes = app.add_subcommand("bytes", "decode FROM, cut to a few rows, with every byte changed or missing");
  for (CLI::App* command : {save, bytes}) command->add_option("FROM", from, "warm cache")->required();
  save->add_option("-o,--output", output, "warm cache to save to")->required();
  bytes->add_option("--rows", rows, "rows to keep");
  bytes->add_option("-o,--output", output, "where to save what was damaged");
  CLI11_PARSE(app, argc, argv);
  const Result<TableSnapshot> image = load_cache(from, "");
  if (!image) {
    std::fprintf(stderr, "%s\n", image.error().message().c_str());
    return 1;
  }
  if (save->parsed()) return save_for_ever(*image, output);
  const TableSnapshot small = first_rows(*image, rows);
  if (!output.empty() && save_cache(output, small)) return 1;
  return damage(small);
}
