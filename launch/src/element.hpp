// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::launch {

/// A text of the file as written, before substitution.
struct RawText {
  std::string text;
  bool literal = false;  ///< In quotes or tagged as text, in YAML: not to be taken for a number.
  int line = 0;
};

/// `name="value"` in XML, `name: value` in YAML; YAML may give a list of values.
struct Attribute {
  std::string name;
  int line = 0;
  bool is_list = false;
  std::vector<RawText> values;  ///< Exactly one unless is_list.
};

/// What both front ends make of a file: an action of the launch file or a part of one.
struct Element {
  std::string name;
  int line = 0;
  std::vector<Attribute> attributes;
  std::vector<Element> children;

  [[nodiscard]] const Attribute* find(std::string_view attribute) const {
    for (const auto& a : attributes) {
      if (a.name == attribute) return &a;
    }
    return nullptr;
  }
};

/// Reads a file's text into its root element, `launch`.
/// Errors: all problems of the syntax, with "file:line". Never throws; nesting and size are bounded.
[[nodiscard]] Result<Element, std::vector<Problem>> read_yaml(std::string_view text, const std::string& file);
[[nodiscard]] Result<Element, std::vector<Problem>> read_xml(std::string_view text, const std::string& file);
/// One of the two, by the file's name.
[[nodiscard]] Result<Element, std::vector<Problem>> read_launch_file(std::string_view text, const std::string& file);

/// Checks names, required attributes and repeated ones against the words of ROS 2's launch and Nacelle's (schema.cpp).
void check_schema(const Element& root, const std::string& file, std::vector<Problem>& problems);

}  // namespace nacelle::launch
