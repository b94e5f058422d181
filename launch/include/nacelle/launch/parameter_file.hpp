// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/launch/parameter_value.hpp"

namespace nacelle::launch {

/// A parameter's value and where it comes from.
struct Parameter {
  std::string name;
  ParameterValue value;
  Place where;
  friend bool operator==(const Parameter&, const Parameter&) = default;
};

/// Sets a parameter in a list that holds each name once: an earlier value is replaced, with its origin.
/// A value that is not set takes the name out again.
void assign(std::vector<Parameter>& parameters, Parameter parameter);

/// The parameters that a file gives to the nodes of one pattern.
struct ParameterSection {
  std::string pattern;  ///< "/lidar", "/**", "/arm/*"
  Place where;          ///< Where the pattern first stands.
  std::vector<Parameter> parameters;
};

/// A ROS 2 parameter file.
///
/// `<node>: {ros__parameters: {<name>: <value>}}`; the node as "/ns/node", as nested maps, or with the wildcards * (one
/// part) and ** (any parts). Dotted and nested names are the same name. Sections of one pattern are one;
/// they apply in the order in which their patterns first stand in the file, and the later value wins.
/// Source: rcl_yaml_param_parser/src/parse.c, rclcpp/parameter_map.cpp (jazzy).
class ParameterFile {
 public:
  ParameterFile() = default;
  explicit ParameterFile(std::vector<ParameterSection> sections) : sections_(std::move(sections)) {}

  [[nodiscard]] const std::vector<ParameterSection>& sections() const { return sections_; }
  /// What the file gives to a node; each name once.
  [[nodiscard]] std::vector<Parameter> parameters_for(std::string_view node_full_name) const;

 private:
  std::vector<ParameterSection> sections_;
};

/// Errors: every problem of the file, each with "<file_name>:<line>". Never throws.
[[nodiscard]] Result<ParameterFile, std::vector<Problem>> parse_parameter_file(std::string_view text,
                                                                               const std::string& file_name);
/// The same from a document whose scalars were changed (substitutions).
[[nodiscard]] Result<ParameterFile, std::vector<Problem>> read_parameter_tree(const YamlNode& root,
                                                                              const std::string& file_name);

/// Whether a section's pattern means that node.
[[nodiscard]] bool matches_node(std::string_view pattern, std::string_view node_full_name);

}  // namespace nacelle::launch
