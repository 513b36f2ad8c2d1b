// Reads the comma-separated oracle tables of tests/reference, and the whole ones beside the checkout where they are.
#pragma once

#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace tress::test {

using ReferenceRows = std::vector<std::vector<std::string>>;

/// Rows of fields of a table, those that are not `known` yet; comments left out. Empty if it cannot be read.
inline void append_rows(const std::string& file_name, std::set<std::string>* known, ReferenceRows* rows) {
  std::ifstream file(file_name);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#' || !known->insert(line).second) continue;
    std::vector<std::string> fields;
    std::stringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    rows->push_back(std::move(fields));
  }
}

inline ReferenceRows rows_of_file(const std::string& file_name) {
  std::set<std::string> known;
  ReferenceRows rows;
  append_rows(file_name, &known, &rows);
  return rows;
}

#ifdef TRESS_SOURCE_DIR
/// Rows of tests/reference/NAME and, where it is there, of ../shared/reference/NAME, each once. Never empty unless the
/// checkout is broken.
inline ReferenceRows reference_rows(const std::string& name) {
  std::set<std::string> known;
  ReferenceRows rows;
  append_rows(TRESS_SOURCE_DIR "/tests/reference/" + name, &known, &rows);
  append_rows(TRESS_SOURCE_DIR "/../shared/reference/" + name, &known, &rows);
  return rows;
}
#endif

constexpr double degree = 0.017453292519943295;

}  // namespace tress::test
