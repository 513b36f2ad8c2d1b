// Reads the comma-separated oracle tables beside the checkout.
#pragma once

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace tress::test {

/// Rows of fields of ../shared/reference/NAME; comments left out. Empty if the file is absent: tests then skip.
inline std::vector<std::vector<std::string>> reference_rows(const std::string& name) {
  std::ifstream file(std::string(TRESS_SOURCE_DIR) + "/../shared/reference/" + name);
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> fields;
    std::stringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    rows.push_back(std::move(fields));
  }
  return rows;
}

constexpr double degree = 0.017453292519943295;

}  // namespace tress::test

#define TRESS_SKIP_WITHOUT(rows, name) \
  if ((rows).empty()) GTEST_SKIP() << "../shared/reference/" name " is not there: nothing to compare with"
