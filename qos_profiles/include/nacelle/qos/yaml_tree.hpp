// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/nesting.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle {

/// One value of a YAML document, with its line and with its text as written, before it has a type.
struct YamlNode {
  enum class Kind : std::uint8_t { Null, Scalar, Sequence, Map };

  Kind kind = Kind::Null;
  int line = 0;         ///< From 1.
  bool quoted = false;  ///< A scalar in quotes or as a block: it is text, whatever it looks like.
  std::string tag;      ///< "str" for !!str, "!x" for a private one, empty for none.
  std::string text;     ///< Of a scalar.
  std::string key;      ///< Of a value in a map.
  int key_line = 0;
  std::vector<YamlNode> items;  ///< Of a sequence or a map, in the file's order.

  [[nodiscard]] bool is_null() const { return kind == Kind::Null; }
  [[nodiscard]] bool is_scalar() const { return kind == Kind::Scalar; }
  [[nodiscard]] bool is_sequence() const { return kind == Kind::Sequence; }
  [[nodiscard]] bool is_map() const { return kind == Kind::Map; }
  /// The last value under that key of a map; null without one.
  [[nodiscard]] const YamlNode* find(std::string_view name) const;
  /// "a map", "a list", "text", "nothing": for messages.
  [[nodiscard]] const char* kind_text() const;
};

/// Limits that keep a hostile document harmless.
inline constexpr std::size_t kMaxYamlBytes = 1U << 20U;
inline constexpr std::size_t kMaxYamlNodes = 100'000;
inline constexpr int kMaxYamlDepth = kMostNesting;

/// Reads one document. Repeated keys are kept: whether they are allowed is the reader's rule.
///
/// Errors: bad syntax, more than one document, anchors and aliases (they multiply), keys that are not text, and the
/// limits above; `where` is "<file_name>:<line>". Never throws. An empty document is a null node.
[[nodiscard]] Result<YamlNode, Problem> parse_yaml(std::string_view text, const std::string& file_name);

}  // namespace nacelle
