// What a picture is a picture of: the scene, the files that it is made of and the options, each by its name, so that
// two can be compared and told apart by name.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::cli {

/// "/materials/0/eta" of a scene file, "--epsilon", "frame", ...: its value, or the hash of a file's content.
using Identity = std::map<std::string, std::string>;

/// Of a scene file: every value under its JSON path; a text that is the name of a file there comes with the hash of its
/// content; with ####, of those of the frames around the shutter. Of a bare groom: the hash of the file. options: those
/// of the command that change the picture, by name.
Identity identity_of(const std::filesystem::path& scene, const std::map<std::string, std::string>& options);

/// As JSON, and back; unset if it is no object of texts.
std::string identity_text(const Identity& identity);
std::optional<Identity> parse_identity(const std::string& text);

/// What the two tell differently, "--epsilon: expected 0.01, found 0.02", at most eight of them and how many more;
/// empty if nothing. ignored: names that may differ.
std::string differences(const Identity& expected, const Identity& found, const std::vector<std::string>& ignored = {});

}  // namespace tress::cli
