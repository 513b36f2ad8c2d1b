// The container .usdz: a zip archive whose entries are stored as they are.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "scene/read/grooms/groom_file.h"
#include "tress/base/error.h"

namespace tress::scene {

/// Whether these are the bytes of a zip archive whose first entry is named as a layer of USD.
bool is_usdz(std::span<const unsigned char> bytes);

struct UsdzFile {
  struct Entry {
    std::string name;
    std::span<const unsigned char> bytes = {};  ///< among those of the file
  };
  std::vector<Entry> layers;        ///< that are stored as they are; the first is the root layer
  std::vector<std::string> others;  ///< names of all other entries
};

/// Finds the entries. `name` is the file named in errors, which give the byte.
Result<UsdzFile> read_usdz_file(std::span<const unsigned char> bytes, const std::string& name);

}  // namespace tress::scene
