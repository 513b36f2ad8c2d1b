// Checked reading of a JSON document: the first mistake is kept with its path, what follows reads as defaults.
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

/// The keys that were asked for, by the path of their object.
using KnownKeys = std::map<std::string, std::vector<std::string>>;

/// One value of the document; those of an array have "0", "1" ... for keys. Readers return nothing where the key is
/// absent or wrong; a wrong one sets the error of the document, which only the first mistake does.
class JsonReader {
 public:
  /// `keys`, where given, gets those that every object() of the document knew.
  JsonReader(const nlohmann::json& value, std::string path, std::string file, std::optional<Error>* error,
             KnownKeys* keys = nullptr)
      : value_(value), path_(std::move(path)), file_(std::move(file)), error_(error), keys_(keys) {}

  /// The value must be an object with no other keys than these.
  bool object(const std::vector<std::string>& known) const;
  bool has(const std::string& key) const { return find(key) != nullptr; }
  bool is_text(const std::string& key) const { return has(key) && find(key)->is_string(); }
  bool is_object(const std::string& key) const { return has(key) && find(key)->is_object(); }
  std::size_t size() const { return value_.is_array() ? value_.size() : 0; }  ///< of an array
  JsonReader child(const std::string& key) const;
  std::vector<JsonReader> items(const std::string& key, std::size_t most) const;

  /// In the range that the parameter table has for the place; so are those of triple().
  std::optional<double> number(const std::string& key) const;
  std::optional<std::int64_t> integer(const std::string& key) const;
  std::optional<bool> boolean(const std::string& key) const;
  std::optional<std::string> text(const std::string& key) const;
  std::optional<std::string> choice(const std::string& key, const std::vector<std::string>& known) const;
  std::optional<glm::vec3> triple(const std::string& key) const;

  /// At most one of the keys may be there; false and an error otherwise.
  bool at_most_one(const std::vector<std::string>& keys) const;
  /// Exactly one of them must be there; false and an error otherwise.
  bool exactly_one(const std::vector<std::string>& keys) const;
  /// All of them must be there; false and an error that names the first that is missing otherwise.
  bool need(const std::vector<std::string>& keys) const;

  void fail(const std::string& key, std::string expected, std::string found) const;
  bool failed() const { return error_->has_value(); }
  const std::string& file() const { return file_; }

 private:
  const nlohmann::json* find(const std::string& key) const;
  std::optional<double> number_at(const nlohmann::json& value, const std::string& key,
                                  const Parameter& parameter) const;
  const Parameter* parameter_of(const std::string& key) const;

  const nlohmann::json& value_;
  std::string path_, file_;
  std::optional<Error>* error_;
  KnownKeys* keys_;
};

}  // namespace tress::scene
