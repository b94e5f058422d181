// SPDX-License-Identifier: Apache-2.0
// Which driver a section of a parameter file is for, and lists that ROS 2 would refuse.
#include "ros_import/identify.hpp"

#include <algorithm>
#include <array>
#include <cctype>

namespace nacelle::ros_import {
namespace {

/// Keys that many drivers have. They are translated like any other, and prove nothing.
constexpr std::array<std::string_view, 49> kGeneric{"frequency",
                                                    "delay",
                                                    "sensor_timeout",
                                                    "transform_timeout",
                                                    "map_frame",
                                                    "odom_frame",
                                                    "world_frame",
                                                    "base_link_frame",
                                                    "publish_tf",
                                                    "debug",
                                                    "frame",
                                                    "frame_id",
                                                    "odom_frame_id",
                                                    "base_frame_id",
                                                    "tf_prefix",
                                                    "update_rate",
                                                    "type",
                                                    "publish_rate",
                                                    "cmd_vel_timeout",
                                                    "open_loop",
                                                    "dev",
                                                    "device_id",
                                                    "device_name",
                                                    "topic_name",
                                                    "port_name",
                                                    "port_baudrate",
                                                    "serial_port",
                                                    "serial_baudrate",
                                                    "lidar_frame",
                                                    "range_min",
                                                    "range_max",
                                                    "server_ip",
                                                    "server_port",
                                                    "bins",
                                                    "video_device",
                                                    "pixel_format",
                                                    "framerate",
                                                    "image_width",
                                                    "image_height",
                                                    "camera_name",
                                                    "camera_info_url",
                                                    "brightness",
                                                    "contrast",
                                                    "saturation",
                                                    "hue",
                                                    "gain",
                                                    "sharpness",
                                                    "transform_time_offset",
                                                    "initial_state"};

/// Parameters whose type is double[].
constexpr std::array<std::string_view, 10> kDoubleLists{
    "process_noise_covariance", "initial_estimate_covariance", "initial_state",      "acceleration_limits",
    "acceleration_gains",       "deceleration_limits",         "deceleration_gains", "datum",
    "pose_covariance_diagonal", "twist_covariance_diagonal"};

template <std::size_t Count>
bool holds(const std::array<std::string_view, Count>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

std::string lower_case(std::string_view text) {
  std::string out{text};
  std::ranges::transform(out, out.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

bool has_a_word_of(std::string_view name, std::string_view words) {
  for (std::size_t at = 0; at < words.size();) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    if (end > at && name.find(words.substr(at, end - at)) != std::string_view::npos) return true;
    at = end + 1;
  }
  return false;
}

/// How much of a section a driver would read.
struct Fit {
  std::size_t known = 0, telling = 0, unknown = 0;
};

Fit fit_of(const Driver& driver, const launch::ParameterSection& section) {
  Fit fit;
  for (const auto& parameter : section.parameters) {
    const Key* const key = find_key(driver, parameter.name);
    if (key == nullptr) {
      if (find_common_key(parameter.name) == nullptr) ++fit.unknown;
    } else if (key->name.front() != '*') {  // a row for anything proves nothing
      ++fit.known;
      if (!holds(kGeneric, parameter.name)) ++fit.telling;
    }
  }
  return fit;
}

/// Int and double texts of a list, and whether there is nothing else in it.
struct Numbers {
  std::size_t whole = 0, broken = 0;
  bool only = true;
};

Numbers numbers_of(const YamlNode& list) {
  Numbers numbers;
  for (const YamlNode& item : list.items) {
    if (!item.is_scalar() || item.quoted || !item.tag.empty()) return {0, 0, false};
    const auto value = launch::value_of_scalar(item.text);
    if (std::holds_alternative<std::int64_t>(value)) {
      ++numbers.whole;
    } else if (std::holds_alternative<double>(value)) {
      ++numbers.broken;
    } else {
      return {0, 0, false};
    }
  }
  return numbers;
}

}  // namespace

const Driver* driver_of(const launch::ParameterSection& section, std::string_view node_name) {
  const std::string name = lower_case(node_name);
  const Driver* best = nullptr;
  std::size_t best_score = 0;
  for (const Driver& driver : drivers()) {
    const Fit fit = fit_of(driver, section);
    const bool is_named = has_a_word_of(name, driver.full_names);
    const bool is_hinted = is_named || has_a_word_of(name, driver.node_words);
    const bool most = fit.known >= fit.unknown;
    if (!is_named && !(most && (is_hinted ? fit.known > 0 : fit.telling > 1))) continue;
    const std::size_t score = 2 * fit.known + (is_named ? 1000 : 0) + (is_hinted ? 5 : 0) + 1;
    if (score <= best_score) continue;
    best = &driver;
    best_score = score;
  }
  return best;
}

bool is_of_every_node(const launch::ParameterSection& section) {
  return std::ranges::all_of(section.parameters,
                             [](const auto& parameter) { return find_common_key(parameter.name) != nullptr; });
}

std::string last_part_of(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  return std::string{dot == std::string_view::npos ? name : name.substr(dot + 1)};
}

void widen_lists(YamlNode& node, std::set<ListPlace>& changed) {
  for (YamlNode& item : node.items) {
    if (item.is_map()) widen_lists(item, changed);  // as deep as the document, which parse_yaml() bounds
    if (!item.is_sequence() || !holds(kDoubleLists, last_part_of(item.key))) continue;
    const Numbers numbers = numbers_of(item);
    if (!numbers.only || numbers.whole == 0) continue;
    for (YamlNode& number : item.items) {
      const auto value = launch::value_of_scalar(number.text);
      if (const auto* const whole = std::get_if<std::int64_t>(&value))
        number.text = launch::to_text(ParameterValue{static_cast<double>(*whole)});
    }
    changed.emplace(item.key_line, last_part_of(item.key));
  }
}

}  // namespace nacelle::ros_import
