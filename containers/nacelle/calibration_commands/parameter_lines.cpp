// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/parameter_lines.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "ask/parameters.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/files.hpp"

namespace nacelle::cli {

Result<ParametersOf, Problem> parameters_of(ask::Nodes& nodes, const std::string& node) {
  auto listed = ask::list_parameters(nodes, node);
  if (!listed) return err(listed.error());
  ParametersOf parameters;
  for (const auto& row : listed.value()) parameters[row["name"].get<std::string>()] = row["value"];
  return parameters;
}

double number_in(const ParametersOf& parameters, const std::string& name, double otherwise) {
  const auto found = parameters.find(name);
  return found != parameters.end() && found->second.is_number() ? found->second.get<double>() : otherwise;
}

// With '#' a number keeps its point: without one YAML would read an integer.
std::string parameter_line(const std::string& name, double value) { return fmt::format("{}: {:#.9g}", name, value); }

std::string parameter_line(const std::string& name, std::span<const double> values) {
  return fmt::format("{}: [{:#.9g}]", name, fmt::join(values.begin(), values.end(), ", "));
}

std::string parameter_file(const std::string& node, const std::vector<std::string>& comments,
                           const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& comment : comments) text += "# " + comment + '\n';
  text += node + ":\n  ros__parameters:\n";
  for (const auto& line : lines) text += "    " + line + '\n';
  return text;
}

Result<void, Problem> check_output(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  const auto refused = [&](const char* what, const char* way_out) {
    return err(Problem{path, std::string{"the parameters cannot be written: "} + what, way_out});
  };
  if (fs::is_directory(path, unknown)) return refused("it is a folder", "name a file in it with --output");
  if (fs::exists(path, unknown)) {
    if (::access(path.c_str(), W_OK) != 0) return refused(std::strerror(errno), "give another --output");
    return {};
  }
  const std::string folder = fs::path{path}.has_parent_path() ? fs::path{path}.parent_path().string() : ".";
  if (::access(folder.c_str(), W_OK | X_OK) != 0) return refused(std::strerror(errno), "give another --output");
  return {};
}

int write_output(const std::string& path, const std::string& text) {
  if (auto written = write_whole_file(path, text); !written) return complain(written.error());
  std::error_code unknown;
  const auto absolute = std::filesystem::absolute(path, unknown);
  print_text(
      "%s is written; add it to the node's entry in the launch file, behind the files that are there:\n  param: "
      "[{from: %s}]\n",
      path.c_str(), unknown ? path.c_str() : absolute.lexically_normal().c_str());
  return kDone;
}

std::string beside(const std::string& node, const std::string& topic) {
  return topic.starts_with('/') ? topic : node.substr(0, node.rfind('/') + 1) + topic;
}

}  // namespace nacelle::cli
