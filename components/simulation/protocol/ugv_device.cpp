// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/ugv_device.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "nacelle/base/json_text.hpp"

namespace nacelle::simulation {
namespace {

std::optional<double> number(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  const double value = found->get<double>();
  return std::isfinite(value) ? std::optional{value} : std::nullopt;
}

void put(std::string& line, std::string_view key, double value, int decimals) {
  std::string digits = fmt::format("{:.{}f}", value, decimals);
  if (decimals > 0) {
    while (digits.back() == '0') digits.pop_back();
    if (digits.back() == '.') digits.pop_back();
  }
  if (digits == "-0") digits = "0";
  line += fmt::format(",\"{}\":{}", key, digits);
}

}  // namespace

std::optional<UgvCommand> UgvLineReader::parse(std::string_view line) {
  const auto object = parse_json_or_discard(line);
  if (!object.is_object()) return std::nullopt;
  const auto type = number(object, "T");
  if (!type || std::abs(*type) > 10000.0) return std::nullopt;
  UgvCommand command;
  command.type = static_cast<int>(*type);
  command.left = number(object, "L");
  command.right = number(object, "R");
  command.x = number(object, "X");
  command.z = number(object, "Z");
  command.cmd = number(object, "cmd");
  return command;
}

std::string print_feedback(const UgvFeedback& f) {
  std::string line = "{\"T\":1001";
  put(line, "L", f.left_mps, 4);
  put(line, "R", f.right_mps, 4);
  put(line, "r", f.roll_deg, 2);
  put(line, "p", f.pitch_deg, 2);
  put(line, "y", f.yaw_deg, 2);
  put(line, "q0", f.q0, 4);
  put(line, "q1", f.q1, 4);
  put(line, "q2", f.q2, 4);
  put(line, "q3", f.q3, 4);
  put(line, "ax", f.ax, 0);
  put(line, "ay", f.ay, 0);
  put(line, "az", f.az, 0);
  put(line, "gx", f.gx, 1);
  put(line, "gy", f.gy, 1);
  put(line, "gz", f.gz, 1);
  put(line, "odl", f.odometry_left_m, 6);
  put(line, "odr", f.odometry_right_m, 6);
  put(line, "v", f.volts, 2);
  line += "}\r\n";
  return line;
}

}  // namespace nacelle::simulation
