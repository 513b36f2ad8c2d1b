// tress diff: measures the difference of two pictures.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/console.h"
#include "image/picture.h"

namespace tress::cli {
namespace {

struct DiffSettings {
  std::filesystem::path a, b;
  bool json = false;
};

/// Returns the number farthest from 0.
double largest_of(const std::array<double, 3>& x) {
  return *std::ranges::max_element(x, {}, [](double value) { return std::abs(value); });
}

/// Prints relMSE, MAE, bias (mean of B - A by channel), the largest difference and whether all channels are identical.
/// Parts of one image (--crop) are compared with each other, and with the whole, where both have pixels. Exit status 0
/// whatever the difference; 1 if a picture cannot be read, or if the pictures have images of different size or no pixel
/// in common.
int run_diff(const DiffSettings& settings) {
  const Result<image::Picture> a = image::read_exr(settings.a);
  if (!a) {
    log_error(a.error().message());
    return 1;
  }
  const Result<image::Picture> b = image::read_exr(settings.b);
  if (!b) {
    log_error(b.error().message());
    return 1;
  }
  const Result<image::Difference> difference = image::compare(*a, *b, settings.a.string(), settings.b.string());
  if (!difference) {
    log_error(difference.error().message());
    return 1;
  }
  const image::Difference& d = *difference;
  if (settings.json) {
    const nlohmann::ordered_json json = {
        {"relMSE", d.rel_mse}, {"MAE", d.mae}, {"bias", d.bias}, {"largest", d.largest}, {"identical", d.identical}};
    fmt::print("{}\n", json.dump());
  } else {
    fmt::print(
        "relMSE     {:<9.3g} mean of (B - A)^2 / A^2: B is off by {:.2g} % of the brightness of A, root mean square\n"
        "MAE        {:<9.3g} mean of |B - A|, linear color values as in the files\n"
        "bias       {:<9.2g} mean of B - A, the largest of R {:+.2g}, G {:+.2g}, B {:+.2g}: near 0 beside MAE where "
        "only\n"
        "                     noise differs, which falls on both sides; else B is brighter (+) or darker (-)\n"
        "largest    {:<9.3g} |B - A| of the channel and pixel where it is largest\n"
        "identical  {:<9} {}\n"
        "0 is best everywhere: the pictures are the same.\n",
        d.rel_mse, 100 * std::sqrt(d.rel_mse), d.mae, largest_of(d.bias), d.bias[0], d.bias[1], d.bias[2], d.largest,
        d.identical ? "yes" : "no",
        d.identical ? "every channel of every pixel, to the bit" : "at least one value of one channel differs");
  }
  return 0;
}

}  // namespace

Command add_diff(CLI::App& tress) {
  const auto settings = std::make_shared<DiffSettings>();
  CLI::App* diff = tress.add_subcommand("diff", "Compare two pictures");
  diff->add_option("A", settings->a, "picture")->required()->type_name("A.exr");
  diff->add_option("B", settings->b, "picture held against A")->required()->type_name("B.exr");
  diff->add_flag("--json", settings->json, "print JSON");
  return {diff, [settings] { return run_diff(*settings); }};
}

}  // namespace tress::cli
