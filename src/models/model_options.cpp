#include "models/model_options.h"

#include <algorithm>

#include "models/catalog.h"

namespace tress::inline v0_2::fiber {
namespace {

const char* words(Asks what) {
  switch (what) {
    case Asks::rows:
      return "a model with rows";
    case Asks::samples:
      return "a model with rows that can trace its fibers from where a ray meets them";
    case Asks::mixtures:
      return "a model whose rows a learner fits";
    case Asks::corrected:
      return "a model whose scattering can be evaluated, so that what a fit leaves out can be mended";
    case Asks::points:
      return "a model that integrates at every vertex";
  }
  return "";
}

}  // namespace

bool has(const ModelInfo& model, Asks what) {
  switch (what) {
    case Asks::rows:
      return model.has_rows();
    case Asks::samples:
      return model.learns_samples();
    case Asks::mixtures:
      return model.has_rows() && !model.learns_samples();
    case Asks::corrected:
      return model.has_corrected;
    case Asks::points:
      return model.has_quadrature;
  }
  return false;
}

std::optional<RefusedOption> refused(std::span<const AskedOption> asked, const ModelInfo& model) {
  const auto found = std::ranges::find_if(asked, [&](const AskedOption& option) { return !has(model, option.what); });
  if (found == asked.end()) return std::nullopt;
  std::string names, first;
  for (const ModelInfo& info : models()) {
    if (!has(info, found->what)) continue;
    if (first.empty()) first = info.name;
    names += (names.empty() ? "" : ", ") + std::string(info.name);
  }
  return RefusedOption{found->name, std::string(words(found->what)) + " (" + names + ")", first};
}

}  // namespace tress::inline v0_2::fiber
