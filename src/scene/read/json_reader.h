// Checked reading of a JSON document: the first error is kept with its path, and everything after it reads as defaults.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scene/model/parameters.h"
#include "tress/base/error.h"

namespace tress::scene {

/// The name among `known` with the smallest edit distance to `word`.
std::string nearest_name(const std::string& word, const std::vector<std::string>& known);

/// The keys that were requested, by the path of their object.
using KnownKeys = std::map<std::string, std::vector<std::string>>;

/// One value of the document; elements of an array have the keys "0", "1", ... Readers return nothing if the key is
/// absent or wrong; a wrong one sets the error of the document, unless there is one already.
class JsonReader {
 public:
  /// `keys`, if given, gets those that every object() of the document accepts.
  JsonReader(const nlohmann::json& value, std::string path, std::string file, std::optional<Error>* error,
             KnownKeys* keys = nullptr)
      : value_(value), path_(std::move(path)), file_(std::move(file)), error_(error), keys_(keys) {}

  /// The value must be an object with no other keys than those that the parameter table has at its place.
  bool object() const { return object(keys_at(path_)); }
  /// The value must be an object with no other keys than these.
  bool object(const std::vector<std::string>& known) const;
  bool has(const std::string& key) const { return find(key) != nullptr; }
  bool is_text(const std::string& key) const { return has(key) && find(key)->is_string(); }
  bool is_object(const std::string& key) const { return has(key) && find(key)->is_object(); }
  std::size_t size() const { return value_.is_array() ? value_.size() : 0; }  ///< of an array; 0 for other values
  JsonReader child(const std::string& key) const;
  std::vector<JsonReader> items(const std::string& key, std::size_t most) const;

  /// Reads a number, which must be in the range of the parameter table for its place; the same holds for triple().
  std::optional<double> number(const std::string& key) const;
  std::optional<std::int64_t> integer(const std::string& key) const;
  std::optional<bool> boolean(const std::string& key) const;
  std::optional<std::string> text(const std::string& key) const;
  std::optional<std::string> choice(const std::string& key, const std::vector<std::string>& known) const;
  /// One of the choices that the parameter table has for the place.
  std::optional<std::string> choice(const std::string& key) const;
  /// The number of that choice in the table, from 0; enumerators are in this order.
  std::optional<std::size_t> choice_number(const std::string& key) const;
  std::optional<glm::vec3> triple(const std::string& key) const;

  /// At most one of the keys may exist; false and an error otherwise.
  bool at_most_one(const std::vector<std::string>& keys) const;
  /// Exactly one of the keys must exist; false and an error otherwise.
  bool exactly_one(const std::vector<std::string>& keys) const;
  /// All of the keys must exist; otherwise false, and an error that names the first missing one.
  bool need(const std::vector<std::string>& keys) const;

  /// The parameter of a key; null if it has no row.
  const Parameter* parameter_of(const std::string& key) const;
  void fail(const std::string& key, std::string expected, std::string found) const;
  bool failed() const { return error_->has_value(); }
  const std::string& file() const { return file_; }

 private:
  const nlohmann::json* find(const std::string& key) const;
  std::optional<double> number_at(const nlohmann::json& value, const std::string& key,
                                  const Parameter& parameter) const;

  const nlohmann::json& value_;
  std::string path_, file_;
  std::optional<Error>* error_;
  KnownKeys* keys_;
};

}  // namespace tress::scene
