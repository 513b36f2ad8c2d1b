// Values that may vary: a plain one, or an object that says where it comes from.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "scene/model/scene.h"
#include "scene/read/json_reader.h"

namespace tress::scene {

/// Reads a plain value of a key; nothing after an error.
using ReadValue = std::function<std::optional<glm::vec3>(const JsonReader&, const std::string& key)>;

/// Plain values: three numbers; one number, which becomes so many times `unit`.
ReadValue read_triple();
ReadValue read_number(const glm::vec3& unit);

/// The source at a key, which must be there; a constant where it does not vary, and after an error. unit: what 1 of an
/// attribute stands for.
Source read_source(const JsonReader& json, const std::string& key, const ReadValue& read,
                   const glm::vec3& unit = glm::vec3(1.0f));

/// What stands for a number that varies, where one is needed: the mean of the values that it is made of, half of an
/// attribute or a texture. Of values that are numbers.
float middle_of(const Source& source);

/// That of the key "color": three numbers, a source of them, or "file" for the color of the file.
Source read_color_source(const JsonReader& json);

/// Gives the material an absorption that varies, or none where the source is a constant: the value that it then is.
std::optional<glm::vec3> take_pigment(Source source, decltype(Pigment::sigma_a) sigma_a, Material* material);

}  // namespace tress::scene
