// Reads values that may vary: a plain one, or an object that describes its source.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "scene/model/scene.h"
#include "scene/read/json_reader.h"
#include "tress/base/error.h"

namespace tress::scene {

/// Reads a plain value of a key; empty after an error.
using ReadValue = std::function<std::optional<glm::vec3>(const JsonReader&, const std::string& key)>;

/// Reads plain values: three numbers, or one number, which is multiplied by `unit`.
ReadValue read_triple();
ReadValue read_number(const glm::vec3& unit);

/// Reads the source at a key, which must exist; a constant if it does not vary, and after an error. unit: the value for
/// which 1 of an attribute stands.
Source read_source(const JsonReader& json, const std::string& key, const ReadValue& read,
                   const glm::vec3& unit = glm::vec3(1.0f));

/// A number that stands for a source of numbers: the mean of the values from which it is made, 0.5 for an attribute or
/// a texture.
float middle_of(const Source& source);

/// Reads the key "color": three numbers, a source of them, or "file" for the color of the file.
Source read_color_source(const JsonReader& json);

/// Parses JSON such as the key "color" of a material has, for --color. No textures and attributes: they come with
/// files.
Result<Source> parse_color(const std::string& json);

/// Makes the source the absorption of the material if it varies. If it is a constant, returns that instead.
std::optional<glm::vec3> take_pigment(Source source, Absorption sigma_a, Material* material);

/// The same for a pigment that may have a dye; if neither varies, returns their absorption in a fiber.
std::optional<glm::vec3> take_dyed(Pigment pigment, const fiber::FiberParameters& fiber, Material* material);

}  // namespace tress::scene
