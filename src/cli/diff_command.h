// tress diff: how far one picture is from another.
#pragma once

#include <filesystem>

namespace tress::cli {

struct DiffSettings {
  std::filesystem::path a, b;
  bool json = false;
};

/// Prints relMSE, MAE, bias (mean of B - A by channel), the largest difference and whether all channels are identical.
/// Parts of one image (--crop) are held against each other and the whole where both have pixels. Exit status 0 whatever
/// the difference; 1 if a picture cannot be read, or they are of images of different size or have no pixel in common.
int run_diff(const DiffSettings& settings);

}  // namespace tress::cli
