// SPDX-License-Identifier: Apache-2.0
#include "nacelle/qos/yaml_tree.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <exception>
#include <optional>
#include <sstream>
#include <utility>

namespace nacelle {
namespace {

int line_of(const YAML::Mark& mark) { return mark.line < 0 ? 1 : mark.line + 1; }

// Stops the parser from inside an event; the parser's own recursion is bounded by this too.
struct Stop {
  int line;
  std::string what;
  std::string way_out;
  bool may_be_syntax = false;
};

Stop too_deep(const YAML::Mark& mark) {
  return {line_of(mark), "more than " + std::to_string(kMaxYamlDepth) + " levels of nesting", ""};
}

std::string tag_of(const std::string& tag) {
  constexpr std::string_view kStandard = "tag:yaml.org,2002:";
  if (tag == "?" || tag == "!" || tag.empty()) return {};
  return tag.starts_with(kStandard) ? tag.substr(kStandard.size()) : tag;
}

// Builds the tree from events rather than from YAML::Node, which expands aliases and forgets which text was quoted.
class TreeBuilder final : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark& /*mark*/) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_anchor(mark, anchor);
    add({.kind = YamlNode::Kind::Null, .line = line_of(mark)});
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override { refuse_anchor(mark, 1); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    refuse_anchor(mark, anchor);
    add({.kind = YamlNode::Kind::Scalar,
         .line = line_of(mark),
         .quoted = tag == "!",
         .tag = tag_of(tag),
         .text = value});
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    open(mark, tag, anchor, YamlNode::Kind::Sequence);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    open(mark, tag, anchor, YamlNode::Kind::Map);
  }
  void OnMapEnd() override { close(); }

  YamlNode root;

 private:
  struct Level {
    YamlNode node;
    bool has_key = false;
    std::string key;
    int key_line = 0;
  };

  static void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (anchor != 0)
      throw Stop{line_of(mark), "anchors and aliases are not supported", "write the value where it is used"};
  }
  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, YamlNode::Kind kind) {
    refuse_anchor(mark, anchor);
    if (levels_.size() >= static_cast<std::size_t>(kMaxYamlDepth)) throw too_deep(mark);
    if (in_key()) throw Stop{line_of(mark), "a key must be text, not a list or a map", "", true};
    Level level;
    level.node.kind = kind;
    level.node.line = line_of(mark);
    level.node.tag = tag_of(tag);
    levels_.push_back(std::move(level));
  }
  void close() {
    YamlNode node = std::move(levels_.back().node);
    levels_.pop_back();
    add(std::move(node));
  }
  [[nodiscard]] bool in_key() const {
    return !levels_.empty() && levels_.back().node.is_map() && !levels_.back().has_key;
  }
  void add(YamlNode node) {
    if (++nodes_ > kMaxYamlNodes) throw Stop{node.line, "more than " + std::to_string(kMaxYamlNodes) + " values", ""};
    if (levels_.empty()) {
      root = std::move(node);
      return;
    }
    Level& level = levels_.back();
    if (in_key()) {
      if (!node.is_scalar()) throw Stop{node.line, "a key must be text", ""};
      level.has_key = true;
      level.key = std::move(node.text);
      level.key_line = node.line;
      return;
    }
    if (level.has_key) {
      node.key = std::move(level.key);
      node.key_line = level.key_line;
      level.has_key = false;
    }
    level.node.items.push_back(std::move(node));
  }

  std::vector<Level> levels_;
  std::size_t nodes_ = 0;
};

/// Reads on, to see whether the rest is YAML.
class Passer final : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark& /*mark*/) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnAlias(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnScalar(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                const std::string& /*value*/) override {}
  void OnSequenceStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                       YAML::EmitterStyle::value /*style*/) override {
    open(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {
    open(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void open(const YAML::Mark& mark) {
    if (++depth_ > kMaxYamlDepth) throw too_deep(mark);
  }

  int depth_ = 0;
};

Problem problem_at(const std::string& file, int line, std::string what, std::string way_out) {
  return {{file, line}, std::move(what), std::move(way_out)};
}

/// The column, from 1, of a tab that indents a line (from 1); 0 for none.
std::size_t tab_that_indents(std::string_view text, int line) {
  for (int number = 1; number < line; ++number) {
    const auto end = text.find('\n');
    if (end == std::string_view::npos) return 0;
    text.remove_prefix(end + 1);
  }
  const auto tab = text.find_first_not_of(' ');
  return tab != std::string_view::npos && text[tab] == '\t' ? tab + 1 : 0;
}

Problem syntax_problem(std::string_view text, const std::string& file, const YAML::Exception& fault) {
  // The parser's words are about what the tab hides ("end of map not found"). Within [] and {} tabs are allowed.
  const bool in_flow = fault.msg.find("flow") != std::string::npos;
  if (const auto tab = tab_that_indents(text, line_of(fault.mark)); tab != 0 && !in_flow) {
    return problem_at(file, line_of(fault.mark),
                      "this is not YAML: a tab indents the line (column " + std::to_string(tab) + ")",
                      "indent with spaces");
  }
  const std::string column = fault.mark.column < 0 ? "" : " (column " + std::to_string(fault.mark.column + 1) + ")";
  return problem_at(file, line_of(fault.mark), "this is not YAML: " + fault.msg + column, "");
}

/// yaml-cpp takes a list or a map that is never closed for a key at first: then that is what is wrong.
std::optional<Problem> unclosed(std::string_view text, const std::string& file) {
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    Passer passer;
    parser.HandleNextDocument(passer);
  } catch (const YAML::Exception& fault) { return syntax_problem(text, file, fault); } catch (const Stop& stop) {
    return problem_at(file, stop.line, stop.what, stop.way_out);
  }
  return std::nullopt;
}

}  // namespace

const YamlNode* YamlNode::find(std::string_view name) const {
  if (!is_map()) return nullptr;
  for (auto item = items.rbegin(); item != items.rend(); ++item) {
    if (item->key == name) return &*item;
  }
  return nullptr;
}

const char* YamlNode::kind_text() const {
  switch (kind) {
    case Kind::Null: return "nothing";
    case Kind::Scalar: return "text";
    case Kind::Sequence: return "a list";
    case Kind::Map: return "a map";
  }
  return "nothing";
}

Result<YamlNode, Problem> parse_yaml(std::string_view text, const std::string& file_name) {
  if (text.size() > kMaxYamlBytes) {
    return err(Problem{Place(file_name, 0),
                       "the file has " + std::to_string(text.size()) + " bytes; at most " +
                           std::to_string(kMaxYamlBytes) + " are read",
                       ""});
  }
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    TreeBuilder builder;
    if (!parser.HandleNextDocument(builder)) return YamlNode{.line = 1};
    TreeBuilder second;
    if (parser.HandleNextDocument(second)) {
      return err(
          problem_at(file_name, second.root.line, "a second document starts here", "keep one document per file"));
    }
    return std::move(builder.root);
  } catch (const Stop& stop) {
    if (stop.may_be_syntax) {
      if (auto syntax = unclosed(text, file_name)) return err(std::move(*syntax));
    }
    return err(problem_at(file_name, stop.line, stop.what, stop.way_out));
  } catch (const YAML::Exception& fault) {
    return err(syntax_problem(text, file_name, fault));
  } catch (const std::exception& fault) {
    return err(Problem{Place(file_name, 0), std::string("this is not YAML: ") + fault.what(), ""});
  }
}

}  // namespace nacelle
