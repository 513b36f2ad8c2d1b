#include "tress/adaptive/options.h"

#include <cmath>
#include <limits>
#include <type_traits>

#include "base/number_text.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {

std::vector<Error> make_usable(Options& options) {
  const Options defaults;
  std::vector<Error> unusable;
  const auto hold = [&](const char* name, auto Options::* option, double least, double most) {
    auto& value = options.*option;
    const auto given = static_cast<double>(value);
    if (given >= least && given <= most) return;
    unusable.push_back(
        {"", name, "a number from " + number_text(least) + " to " + number_text(most), number_text(given)});
    value = std::isnan(given) ? defaults.*option
                              : static_cast<std::remove_reference_t<decltype(value)>>(given < least ? least : most);
  };
  constexpr double least_epsilon = std::numeric_limits<float>::min(), most_epsilon = std::numeric_limits<float>::max();
  hold("epsilon", &Options::epsilon, least_epsilon, most_epsilon);
  hold("sampled_epsilon", &Options::sampled_epsilon, least_epsilon, most_epsilon);
  hold("picture_error", &Options::picture_error, 0, most_epsilon);
  hold("heard_share", &Options::heard_share, 0, 1);
  hold("uniform_share_converged", &Options::uniform_share_converged, 0, 1);
  hold("uniform_share_open", &Options::uniform_share_open, 0, 1);
  hold("tests_before_refusal", &Options::tests_before_refusal, 1, std::numeric_limits<std::uint32_t>::max());
  hold("max_components", &Options::max_components, 1, double{Mixture::max_components});
  if (options.learner == nullptr) {
    unusable.push_back({"", "learner", "a learner", "null"});
    options.learner = defaults.learner;
  }
  return unusable;
}

}  // namespace tress::inline v0_2::adaptive
