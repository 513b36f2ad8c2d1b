#include "scene/read/grooms/usd_layer.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <type_traits>
#include <utility>

#include "scene/read/grooms/text_cursor.h"

namespace tress::scene {
namespace {

/// Adds to numbers a share of the way to those after them; false if their counts differ.
bool meet(UsdValue after, float share, bool are_quaternions, UsdValue* value) {
  const auto add = [&](auto& numbers, const auto& later) {
    using Number = std::remove_cvref_t<decltype(numbers[0])>;
    constexpr bool is_double = std::is_same_v<Number, double>;
    for (std::size_t i = 0; i < numbers.size(); ++i)
      numbers[i] += static_cast<std::conditional_t<is_double, double, float>>(share) * (later[i] - numbers[i]);
  };
  if (value->numbers.size() != after.numbers.size() || value->precise.size() != after.precise.size() ||
      value->triples.size() != after.triples.size())
    return false;
  for (std::size_t q = 0; are_quaternions && q + 3 < after.precise.size(); q += 4) {  // both signs are one rotation
    double cosine = 0;
    for (std::size_t i = q; i < q + 4; ++i) cosine += after.precise[i] * value->precise[i];
    for (std::size_t i = q; i < q + 4 && cosine < 0; ++i) after.precise[i] = -after.precise[i];
  }
  add(value->numbers, after.numbers);
  add(value->precise, after.precise);
  add(value->triples, after.triples);
  return true;
}

}  // namespace

const UsdPrim* UsdPrim::child(std::string_view named) const {
  const auto found = std::ranges::find(children, named, &UsdPrim::name);
  return found == children.end() ? nullptr : &*found;
}

bool UsdStage::has(std::string_view key) {
  return key == "metersPerUnit" || key == "timeCodesPerSecond" || key == "upAxis";
}

std::optional<UsdStage::Fault> UsdStage::take(std::string_view key, const UsdValue& value) {
  const std::string text = value.texts.empty() ? "" : value.texts[0].substr(0, 32);
  const double number = value.precise.size() == 1 ? value.precise[0] : 0;
  const bool is_positive = number > 0 && number < 1e9;
  if (key == "upAxis") {
    if (text != "Y" && text != "Z") return Fault{"upAxis \"Y\" or \"Z\"", "\"" + printable(text) + "\""};
    y_up = text == "Y";
  } else if (key == "metersPerUnit") {
    if (!is_positive) return Fault{"metersPerUnit > 0", fmt::format("{:g}", number)};
    cm_per_unit = 100 * number;
  } else if (is_positive) {
    time_codes_per_second = number;
  }
  return std::nullopt;
}

UsdValue UsdLayer::value_of(const UsdAttribute& attribute, UsdNumbers kept_as, std::optional<double> frame,
                            bool is_held) {
  if (attribute.layer != nullptr && attribute.layer != this)
    return attribute.layer->value_of(attribute, kept_as, frame, is_held);
  const bool are_quaternions = kept_as == UsdNumbers::quaternions;
  if (are_quaternions) kept_as = UsdNumbers::doubles;
  UsdValue value;
  if (error() || (!attribute.samples && !attribute.value)) return value;
  if (!attribute.samples) {
    value = this->value(*attribute.value, kept_as);
  } else {
    const std::vector<UsdSample> all = samples(*attribute.samples);
    const UsdSample *from = nullptr, *to = nullptr;  // around the frame: the last that is not later, the first that is
    for (const UsdSample& sample : all) {
      const bool is_later = frame ? sample.time > *frame : from != nullptr;
      if (!is_later && (!from || sample.time >= from->time)) from = &sample;
      if (is_later && frame && (!to || sample.time < to->time)) to = &sample;
    }
    if (const UsdSample* only = from ? from : to) value = this->value(only->at, kept_as);
    const bool is_on_sample = from && frame && *frame == from->time;
    const bool is_met = is_on_sample || (from && to && !is_held &&
                                         meet(this->value(to->at, kept_as),
                                              static_cast<float>((*frame - from->time) / (to->time - from->time)),
                                              are_quaternions, &value));
    if (from && frame && !is_met) value.held_since = from->time;
    value.is_animated = all.size() > 1;
  }
  value.scope = attribute.scope;
  return value;
}

std::optional<AttributeScope> usd_scope(std::string_view interpolation) {
  if (interpolation == "constant") return AttributeScope::constant;
  if (interpolation == "uniform") return AttributeScope::uniform;
  if (interpolation == "varying") return AttributeScope::varying;
  if (interpolation == "vertex") return AttributeScope::vertex;
  return std::nullopt;
}

bool is_usd_arc(std::string_view key) {
  static constexpr std::string_view keys[] = {"references", "payload", "inherits", "inheritPaths", "specializes"};
  return std::ranges::find(keys, key) != std::end(keys);
}

bool is_taken_space(std::string_view color_space) {
  static constexpr std::string_view spaces[] = {"", "lin_rec709_scene", "lin_rec709", "lin_srgb", "raw", "data"};
  return std::ranges::find(spaces, color_space) != std::end(spaces);
}

bool is_usd_clip(std::string_view key) { return key == "clips" || key == "clipAssetPaths"; }

// Reads a layer of USD as text. Values are places in the text.
namespace {

bool composes_otherwise(std::string_view key) {
  return key == "subLayers" || key == "variantSets" || key == "relocates";
}

void keep(double x, UsdNumbers kept_as, UsdValue* value) {
  if (kept_as == UsdNumbers::doubles) return value->precise.push_back(x);
  std::vector<float>& numbers = value->numbers;
  numbers.push_back(to_float(x));
  if (kept_as == UsdNumbers::floats || numbers.size() < 3) return;
  value->triples.emplace_back(numbers[0], numbers[1], numbers[2]);
  numbers.clear();
}

/// Reads numbers and texts of a value with all its brackets. For a long one, memory for as many triples as its commas
/// allow is allocated once, because a growing vector copies itself. Text that is counted is read next, so that none is
/// counted twice.
void read_items(TextCursor* text, UsdNumbers kept_as, UsdValue* value) {
  if (kept_as == UsdNumbers::triples && text->peek() == '[')
    value->triples.reserve((text->commas_before(']') + 1) / 3 + 1);
  int depth = 0;
  do {
    const char c = text->peek();
    if (c == '[' || c == '(') {
      text->take(c);
      if (++depth > 8) return text->fail("at most 8 brackets in one another", "more");
    } else if (c == ']' || c == ')') {
      if (depth == 0) return text->fail_here("a value");
      text->take(c);
      --depth;
    } else if (c == ',') {
      if (depth == 0) return text->fail_here("a value");
      text->take(c);
    } else if (c == '"' || c == '\'') {
      value->texts.emplace_back(text->quoted());
    } else if (c == '@' || c == '<' || c == '{') {
      text->skip_value();
    } else if (depth == 0 && text->peek_word() == "None") {
      text->word();
      value->is_blocked = true;
    } else if (c == 'N' || c == 't' || c == 'f' || c == 'T' || c == 'F') {  // None, true, false
      value->texts.emplace_back(text->word());
    } else {
      keep(text->number(), kept_as, value);
    }
  } while (depth > 0 && !text->error());
}

/// Builds the tree of a layer from its text.
class UsdaLayer final : public UsdLayer {
 public:
  explicit UsdaLayer(const GroomInput& input) : text_(input.bytes, input.name, input.done_with) {}

  UsdPrim read() override {
    UsdPrim root;
    read_stage_metadata();
    while (!text_.error() && !text_.at_end()) read_prim_statement(&root, 0);
    return root;
  }

  std::vector<UsdSample> samples(std::uint64_t at) override {
    std::vector<UsdSample> all;
    text_.go_to(at);
    text_.expect('{', "before time samples");
    while (!text_.error() && !text_.take('}')) {
      const double time = text_.number();
      text_.expect(':', "behind the time of a sample");
      all.push_back({time, text_.at()});
      text_.skip_value();
      text_.take(',');
      if (text_.at_end()) text_.fail_here("\"}\" behind time samples");
    }
    if (text_.error()) all.clear();
    return all;
  }

  UsdValue value(std::uint64_t at, UsdNumbers kept_as) override {
    UsdValue value;
    text_.go_to(at);
    if (!text_.error()) read_items(&text_, kept_as, &value);
    return value;
  }

  const std::optional<Error>& error() const override { return text_.error(); }

 private:
  void read_stage_metadata() {
    read_metadata("a key of the stage, or \")\"", [&](const std::string& key) {
      if (key == "subLayers") return read_sub_layers();
      if (key == "defaultPrim") {
        default_prim = text_.quoted();
        return;
      }
      if (!UsdStage::has(key)) return text_.skip_value();
      UsdValue value;
      read_items(&text_, UsdNumbers::doubles, &value);
      if (auto fault = stage.take(key, value); fault && !text_.error())
        text_.fail(std::move(fault->expected), std::move(fault->found));
    });
  }

  /// Reads [ @file@, @file@ (offset = 1) ].
  void read_sub_layers() {
    if (!text_.expect('[', "before sublayers")) return;
    while (!text_.error() && !text_.take(']')) {
      if (!text_.expect('@', "before a file")) return;
      sub_layers.emplace_back(text_.until('@'));
      read_offset(sub_layers.back());
      text_.take(',');
    }
  }

  /// Names the offset of a layer, if there is one.
  void read_offset(const std::string& name) {
    read_metadata("offset or scale", [&](const std::string& word) {
      if (word == "offset" || word == "scale")
        ignored.push_back({printable(name.substr(0, 128)) + ": " + word, why_no_offset});
      text_.skip_value();
    });
  }

  /// Reads ( "comment" key = value ... ), if it is there. read: takes a key, and reads its value from the text.
  template <class Read>
  void read_metadata(const char* expected, const Read& read) {
    if (!text_.take('(')) return;
    while (!text_.error() && !text_.take(')')) {
      if (text_.peek() == '"' || text_.peek() == '\'') {
        text_.quoted();
        continue;
      }
      if (text_.take(';') || text_.take(',')) continue;
      const std::string key(text_.word());
      if (key.empty()) return text_.fail_here(expected);
      if (composes_otherwise(key) && !(follows && key == "subLayers")) return text_.fail(flat_stage, key);
      if (text_.take('=')) read(key);
    }
  }

  /// Reads def, over or class with its body, or another statement of the level.
  void read_prim_statement(UsdPrim* parent, int depth) {
    const std::string keyword(text_.word());
    if (keyword == "reorder") {
      text_.word();
      text_.expect('=', "behind reorder");
      return text_.skip_value();
    }
    if (keyword != "def" && keyword != "over" && keyword != "class") return text_.fail_here("def, over or class");
    UsdPrim prim{.name = {}, .type = std::string(text_.word())};
    prim.name = printable(std::string(text_.quoted().substr(0, 256)));
    if (depth >= deepest_prim) return text_.fail(fmt::format("at most {} prims in one another", deepest_prim), "more");
    prim.is_defined = keyword == "def";
    read_metadata("a key of a prim, or \")\"", [&](const std::string& key) {
      if (key == "active") {
        prim.is_active = text_.peek_word() != "false" && text_.peek_word() != "0";
        text_.word();
      } else if (is_usd_arc(key)) {
        read_arcs(key, prim.name, &prim.arcs);
      } else {
        if (key == "inactiveIds") prim.attributes[key] = {.layer = this, .value = text_.at()};
        if (is_usd_clip(key)) ignored.push_back({prim.name + ": " + key, why_no_clips});
        text_.skip_value();
      }
    });
    read_body(&prim, depth);
    if (!text_.error()) parent->children.push_back(std::move(prim));
    ++prims;
  }

  /// Reads </Path>, [</Path>, @file@</Path>] or None.
  void read_arcs(const std::string& key, const std::string& prim, std::vector<std::string>* arcs) {
    const bool is_list = text_.take('[');
    while (!text_.error() && !(is_list && text_.take(']'))) {
      if (text_.peek() == '@' && !follows) return text_.fail(flat_stage, key + " of another file");
      std::string file;
      if (text_.take('@')) file = fmt::format("@{}@", text_.until('@'));
      if (const bool has_path = text_.take('<'); has_path || !file.empty()) {
        arcs->push_back(file + std::string(has_path ? text_.until('>') : ""));
        read_offset(prim);
      } else {
        text_.skip_value();
      }
      if (!is_list) return;
      text_.take(',');
    }
  }

  void read_body(UsdPrim* prim, int depth) {
    if (!text_.expect('{', "before the body of a prim")) return;
    while (!text_.error() && !text_.take('}')) {
      const std::string_view word = text_.peek_word();
      if (word == "def" || word == "over" || word == "class")
        read_prim_statement(prim, depth + 1);
      else if (word == "variantSet")
        text_.fail(flat_stage, "variantSet");
      else if (!text_.take(';'))
        read_property(prim);
    }
  }

  /// Reads an attribute or a relationship, with any words before it.
  void read_property(UsdPrim* prim) {
    std::string_view word = text_.word();
    if (word.empty()) return text_.fail_here("an attribute, a prim or \"}\"");
    if (word == "reorder") {
      text_.word();
      text_.expect('=', "behind reorder");
      return text_.skip_value();
    }
    while (word == "custom" || word == "uniform" || word == "varying" || word == "config" || word == "prepend" ||
           word == "append" || word == "add" || word == "delete")
      word = text_.word();
    const bool is_relation = word == "rel", is_triple = word.find('3') != std::string_view::npos;
    if (!is_relation && text_.take('[')) text_.expect(']', "of an array's type");
    std::string name(text_.word());
    if (name.empty()) return text_.fail_here("the name of an attribute");
    const bool samples = name.ends_with(".timeSamples"), is_connection = name.ends_with(".connect");
    if (name.ends_with(".spline")) {
      name.resize(name.size() - 7);
      ignored.push_back({prim->name + "." + name.substr(0, 128), why_no_splines});
      if (text_.take('=')) text_.skip_value();
      return;
    }
    if (samples) name.resize(name.size() - 12);
    const bool has_value = text_.take('=');
    if (is_relation && name == "prototypes" && has_value) return read_arcs(name, prim->name, &prim->prototypes);
    const std::size_t at = text_.at();
    if (has_value) text_.skip_value();
    std::string color_space;
    const std::optional<AttributeScope> scope = read_scope(&color_space);
    if (name.starts_with("primvars:") && !is_taken_space(color_space))
      ignored.push_back(
          {prim->name + "." + name.substr(0, 128) + ": colorSpace " + printable(color_space), why_one_space});
    if (is_connection || text_.error()) return;
    UsdAttribute& attribute = prim->attributes[name];
    if (scope) attribute.scope = scope;
    attribute.layer = this;
    attribute.is_triple = is_triple;
    if (has_value) (samples ? attribute.samples : attribute.value) = at;
  }

  /// Reads the metadata in parentheses after an attribute, if there is any, for its interpolation.
  std::optional<AttributeScope> read_scope(std::string* color_space) {
    std::optional<AttributeScope> scope;
    if (!text_.take('(')) return scope;
    while (!text_.error() && !text_.take(')')) {
      if (text_.at_end()) {
        text_.fail_here("\")\" behind metadata");
      } else if (text_.peek() == '"' || text_.peek() == '\'') {
        text_.quoted();  // skips a comment
      } else if (!text_.take(';') && !text_.take(',')) {
        const std::string key(text_.word());
        if (key.empty()) text_.fail_here("a key of metadata");
        if (!text_.take('=')) continue;  // "append" comes before its key
        if (key == "interpolation")
          scope = usd_scope(text_.quoted());
        else if (key == "colorSpace")
          *color_space = text_.quoted().substr(0, 64);
        else
          text_.skip_value();
      }
    }
    return scope;
  }

  TextCursor text_;
};

}  // namespace

std::unique_ptr<UsdLayer> usda_layer(const GroomInput& input) { return std::make_unique<UsdaLayer>(input); }

}  // namespace tress::scene
