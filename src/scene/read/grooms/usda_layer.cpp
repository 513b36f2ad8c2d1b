// Reads a layer of USD as text. Values are places in the text.
#include <fmt/format.h>

#include <utility>

#include "scene/read/grooms/text_cursor.h"
#include "scene/read/grooms/usd_layer.h"

namespace tress::scene {
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
