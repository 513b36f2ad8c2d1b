// The grooms that make_fixtures.py writes.
#pragma once

#include <filesystem>
#include <string>

namespace tress::scene {

inline std::filesystem::path fixture(const std::string& name) {
  return std::filesystem::path(TRESS_SOURCE_DIR) / "tests" / "scene" / "grooms" / name;
}

}  // namespace tress::scene
