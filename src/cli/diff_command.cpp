#include "cli/diff_command.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/console.h"
#include "image/picture.h"

namespace tress::cli {

int run_diff(const DiffSettings& settings) {
  const Result<image::Picture> a = image::read_exr(settings.a);
  if (!a) {
    fail(a.error().message());
    return 1;
  }
  const Result<image::Picture> b = image::read_exr(settings.b);
  if (!b) {
    fail(b.error().message());
    return 1;
  }
  const Result<image::Difference> difference = image::compare(*a, *b, settings.a.string(), settings.b.string());
  if (!difference) {
    fail(difference.error().message());
    return 1;
  }
  const image::Difference& d = *difference;
  if (settings.json) {
    const nlohmann::ordered_json json = {
        {"relMSE", d.rel_mse}, {"MAE", d.mae}, {"bias", d.bias}, {"largest", d.largest}, {"identical", d.identical}};
    fmt::print("{}\n", json.dump());
  } else {
    fmt::print(
        "relMSE     {:.6g}\nMAE        {:.6g}\nbias       {:.6g} {:.6g} {:.6g}\nlargest    {:.6g}\nidentical  {}\n",
        d.rel_mse, d.mae, d.bias[0], d.bias[1], d.bias[2], d.largest, d.identical ? "yes" : "no");
  }
  return 0;
}

}  // namespace tress::cli
