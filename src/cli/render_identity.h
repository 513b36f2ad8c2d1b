// The identity of a picture: its scene, files and options, each by its name, so that two identities can be compared
// name by name.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::cli {

/// Values by name, such as "/materials/0/eta" of a scene file, "--epsilon" or "frame"; for a file, the hash of its
/// content.
using Identity = std::map<std::string, std::string>;

/// The identity of a scene file has every value under its JSON path. A text that is the name of a file gets the hash of
/// its content; with ####, the hashes of the frames around the shutter. The identity of a bare groom has the hash of
/// the file. options: options of the command that change the picture, by name. settings: texts for scene::set_keys(),
/// whose values stand under their paths as if the file had them.
Identity identity_of(const std::filesystem::path& scene, const std::map<std::string, std::string>& options,
                     std::span<const std::string> settings = {});

/// Converts to JSON and back; parsing returns empty if the text is not a JSON object of strings.
std::string identity_text(const Identity& identity);
std::optional<Identity> parse_identity(const std::string& text);

/// The differences, "--epsilon: expected 0.01, found 0.02": at most eight, and the number of the rest; empty if there
/// are none. ignored: names that may differ.
std::string differences(const Identity& expected, const Identity& found, const std::vector<std::string>& ignored = {});

}  // namespace tress::cli
