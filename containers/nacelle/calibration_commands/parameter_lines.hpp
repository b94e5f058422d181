// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ask/nodes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::cli {

/// A node's parameters and their values as JSON.
using ParametersOf = std::map<std::string, nlohmann::json>;
/// Errors: as ask::list_parameters().
[[nodiscard]] Result<ParametersOf, Problem> parameters_of(ask::Nodes& nodes, const std::string& node);

/// Returns a parameter, or what stands for it: there is none, or it is of another type.
[[nodiscard]] double number_in(const ParametersOf& parameters, const std::string& name, double otherwise);
template <std::size_t N>
[[nodiscard]] std::array<double, N> list_in(const ParametersOf& parameters, const std::string& name,
                                            std::array<double, N> otherwise) {
  const auto found = parameters.find(name);
  if (found == parameters.end() || !found->second.is_array() || found->second.size() != N) return otherwise;
  for (std::size_t i = 0; i < N; ++i) {
    if (!found->second[i].is_number()) return otherwise;
  }
  return found->second.get<std::array<double, N>>();
}

/// One parameter of a file: YAML that reads back as a double, or as a list of them.
[[nodiscard]] std::string parameter_line(const std::string& name, double value);
[[nodiscard]] std::string parameter_line(const std::string& name, std::span<const double> values);
/// Returns a parameter file of one node, for `param: [{from: FILE}]` of a launch file. `comment`: without '#'.
[[nodiscard]] std::string parameter_file(const std::string& node, const std::vector<std::string>& comments,
                                         const std::vector<std::string>& lines);
/// Checks before a calibration that its file can be written. Errors: it is a folder, its folder does not exist, or no permission.
[[nodiscard]] Result<void, Problem> check_output(const std::string& path);
/// Writes the file, and prints how a launch file takes it. Returns the exit code.
int write_output(const std::string& path, const std::string& text);
/// Returns "imu/data_raw" in the namespace of a node, "/imu/data_raw"; an absolute name as it is.
[[nodiscard]] std::string beside(const std::string& node, const std::string& topic);

}  // namespace nacelle::cli
