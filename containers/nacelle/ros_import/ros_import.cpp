// SPDX-License-Identifier: Apache-2.0
#include "ros_import/ros_import.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "nacelle/base/names.hpp"
#include "ros_import/drivers.hpp"
#include "ros_import/identify.hpp"

namespace nacelle::ros_import {
namespace {

using launch::Parameter;
using launch::ParameterSection;

// Recursion of patterns and distances of names cost more for longer ones; no parameter has such a name.
constexpr std::size_t kLongestName = 200;

std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    if (end > at) words.emplace_back(text.substr(at, end - at));
    at = end + 1;
  }
  return words;
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// "/robot1/ekf_filter_node" is "/robot1/" and "ekf_filter_node".
std::pair<std::string, std::string> split_name(const std::string& pattern) {
  const std::size_t slash = pattern.rfind('/');
  if (slash == std::string::npos) return {"", pattern};
  std::string prefix = pattern.substr(0, slash + 1);
  // A wildcard, or what no namespace may be called, is no place to put a node.
  if (prefix == "/" || !validate_namespace(prefix.substr(0, slash))) prefix.clear();
  return {prefix, pattern.substr(slash + 1)};
}

class Translator {
 public:
  Translator(const Driver& driver, const ParameterSection& section, Imported& into)
      : driver_(driver), section_(section), into_(into), prefix_(split_name(section.pattern).first) {
    // The base is made of several sections; of filters, cameras and LiDARs each one is a node.
    source_ = driver.nacelle_node == "diff_drive" ? "base" : section.where.text();
    own_node_ = free_name();
  }

  void run() {
    for (const Parameter& parameter : section_.parameters) translate(parameter);
    write_image_size();
    for (const Default& standard : driver_.defaults) add_default(standard);
  }

 private:
  void note(Fate fate, const Parameter& parameter, std::string text) {
    into_.notes.push_back({fate, parameter.where.text(), section_.pattern, parameter.name, std::move(text)});
  }
  [[nodiscard]] bool is_free(const std::string& name) const {
    return std::ranges::none_of(
        into_.nodes, [&](const NodeSection& known) { return known.name == prefix_ + name && known.source != source_; });
  }
  /// Nacelle's name for the first such node; its own for a second one, which needs a component of that name.
  [[nodiscard]] std::string free_name() const {
    std::string name{driver_.nacelle_node};
    if (name.empty() || is_free(name)) return name;
    std::string own = split_name(section_.pattern).second;
    if (validate_node_name(own) && is_free(own)) return own;
    for (int number = 2;; ++number) {
      if (is_free(name + "_" + std::to_string(number))) return name + "_" + std::to_string(number);
    }
  }
  NodeSection& node(const std::string& name) {
    const std::string full = prefix_ + name;
    for (auto& known : into_.nodes) {
      if (known.name == full) return known;
    }
    return into_.nodes.emplace_back(NodeSection{full, source_, {}});
  }
  void put(const std::string& to_node, Line line) {
    auto& lines = node(to_node).lines;
    const auto known =
        std::ranges::find_if(lines, [&](const Line& other) { return other.name == line.name && other.doubt.empty(); });
    if (known != lines.end() && line.doubt.empty()) {
      *known = std::move(line);  // as in ROS: the later one wins
    } else {
      lines.push_back(std::move(line));
    }
  }
  [[nodiscard]] std::vector<std::string> nodes_of(const Key& key) const {
    return words_of(key.nodes.empty() ? std::string_view{own_node_} : key.nodes);
  }

  void translate(const Parameter& parameter) {
    const Key* key = find_key(driver_, parameter.name);
    if (key == nullptr) key = find_common_key(parameter.name);
    if (key == nullptr && is_control(parameter)) {
      put(own_node_, {parameter.name, parameter.value, ""});
      return note(
          Fate::Kept, parameter,
          own_name(parameter.name) + ": " + launch::to_text(parameter.value) + " (" + std::string{kControlText} + ")");
    }
    if (key == nullptr) return unknown(parameter);
    if (const std::string input = input_not_given(parameter.name); !input.empty())
      return note(Fate::Dropped, parameter, fmt::format("belongs to {}, which the file does not give", input));
    if (key->fate == Fate::Dropped) return note(Fate::Dropped, parameter, std::string{key->text});
    const bool is_kept = key->fate == Fate::Kept || key->fate == Fate::Translated || !key->nodes.empty();
    if (!is_kept) return doubt(*key, parameter);
    if (driver_.name == "robot_localization" && key->fate == Fate::Kept && key->text.starts_with("Nacelle's filter") &&
        parameter.value == ParameterValue{true}) {
      return note(Fate::Doubted, parameter, std::string{key->text} + ": left out");
    }
    if (std::holds_alternative<std::monostate>(parameter.value)) return note(Fate::Dropped, parameter, "has no value");
    Line line{name_in_nacelle(*key, parameter.name), parameter.value, ""};
    if (!change_form(*key, parameter, line)) return;
    std::vector<std::string> targets = nodes_of(*key);
    if (targets.empty()) return note(Fate::Dropped, parameter, "the node that it is for has no counterpart");
    std::string said;
    for (const auto& target : targets) {
      put(target, line);
      said += (said.empty() ? "" : " and ") + prefix_ + target + "." + line.name;
    }
    said += ": " + launch::to_text(line.value);
    if (!key->text.empty()) said += fmt::format(" ({})", key->text);
    const Fate fate = key->fate == Fate::Doubted ? Fate::Doubted
                      : key->fate == Fate::Kept && line.name == parameter.name && line.value == parameter.value
                          ? Fate::Kept
                          : Fate::Translated;
    note(fate, parameter, std::move(said));
  }

  /// v4l2_camera makes a parameter of each control of the camera.
  [[nodiscard]] bool is_control(const Parameter& parameter) const {
    if (driver_.name != "v4l2_camera" || parameter.name.size() > kLongestName) return false;
    const bool is_number =
        std::get_if<std::int64_t>(&parameter.value) != nullptr || std::get_if<bool>(&parameter.value) != nullptr;
    return is_number && nearest_name(parameter.name, names_near(parameter.name)).empty();
  }

  /// robot_localization reads imu0_config where imu0 is given only: "imu0"; empty for any other key.
  [[nodiscard]] std::string input_not_given(const std::string& name) const {
    if (driver_.name != "robot_localization") return {};
    for (const std::string_view stem : {"odom", "pose", "twist", "imu"}) {
      if (!name.starts_with(stem)) continue;
      const std::size_t end = std::min(name.find_first_not_of("0123456789", stem.size()), name.size());
      if (end == stem.size() || end == name.size() || name[end] != '_') continue;
      std::string input = name.substr(0, end);
      const bool given =
          std::ranges::any_of(section_.parameters, [&](const auto& other) { return other.name == input; });
      return given ? std::string{} : input;
    }
    return {};
  }

  [[nodiscard]] std::string own_name(const std::string& parameter) const {
    return prefix_ + own_node_ + "." + parameter;
  }

  /// Keys that are harmless at their usual value and matter at the other one.
  void doubt(const Key& key, const Parameter& parameter) {
    const bool usual =
        (key.name == "open_loop" && parameter.value == ParameterValue{false}) ||
        (key.name == "position_feedback" && parameter.value == ParameterValue{true}) ||
        (key.name == "disabled_at_startup" && parameter.value == ParameterValue{false}) ||
        (std::get_if<std::string>(&parameter.value) != nullptr && std::get<std::string>(parameter.value).empty());
    note(usual ? Fate::Dropped : Fate::Doubted, parameter,
         usual ? "at its default, which is what Nacelle does" : std::string{key.text});
  }

  /// The driver's keys as they would be written here: odom# with the number of the misspelt key.
  [[nodiscard]] std::vector<std::string> names_near(const std::string& misspelt) const {
    std::vector<std::string> names;
    for (const Key& key : driver_.keys) {
      if (key.name.find('*') != std::string_view::npos || key.fate == Fate::Dropped) continue;
      std::string name{key.name};
      const std::size_t digit = misspelt.find_first_of("0123456789");
      if (const std::size_t hash = name.find('#'); hash != std::string::npos)
        name.replace(hash, 1, 1, digit == std::string::npos ? '0' : misspelt[digit]);
      names.push_back(std::move(name));
    }
    return names;
  }

  void unknown(const Parameter& parameter) {
    const std::string near =
        parameter.name.size() > kLongestName ? std::string{} : nearest_name(parameter.name, names_near(parameter.name));
    if (near.empty())
      return note(Fate::Doubted, parameter,
                  fmt::format("Nacelle knows no such key of {}: not translated", driver_.name));
    note(Fate::Doubted, parameter,
         fmt::format("{} has no such key and ignores it; did you mean '{}'?", driver_.name, near));
    const Key* const key = find_key(driver_, near);
    if (key == nullptr || (key->fate == Fate::Doubted && key->nodes.empty())) return;
    for (const auto& target : nodes_of(*key))
      put(target, {name_in_nacelle(*key, near), parameter.value, fmt::format("'{}' in the file", parameter.name)});
  }

  static std::string name_in_nacelle(const Key& key, const std::string& name) {
    if (key.to.empty()) return name;
    std::string to{key.to};
    const std::size_t digit = name.find_first_of("0123456789");
    if (const std::size_t hash = to.find('#'); hash != std::string::npos && digit != std::string::npos) {
      const std::size_t end = std::min(name.find_first_not_of("0123456789", digit), name.size());
      to.replace(hash, 1, name.substr(digit, end - digit));
    }
    return to;
  }

  /// False: told, and there is nothing to write.
  bool change_form(const Key& key, const Parameter& parameter, Line& line) {
    if (key.to == "left_wheel_names" || key.to == "right_wheel_names") {
      if (const auto* const one = std::get_if<std::string>(&line.value)) line.value = std::vector<std::string>{*one};
    }
    if (driver_.name == "usb_cam") return change_usb_cam(key, parameter, line);
    if (key.name == "lidar.model") return change_model(parameter, line);
    if (key.name == "lidar.rot_verse") {
      const auto* const word = std::get_if<std::string>(&line.value);
      if (word == nullptr || (lower(*word) != "cw" && lower(*word) != "ccw")) {
        note(Fate::Doubted, parameter, "is neither CW nor CCW; laser_scan_dir: true is counter-clockwise");
        return false;
      }
      line.value = lower(*word) == "ccw";
    }
    if (key.name == "cmd_vel_timeout") {
      const auto* const whole = std::get_if<std::int64_t>(&line.value);
      const double seconds = whole != nullptr                              ? static_cast<double>(*whole)
                             : std::get_if<double>(&line.value) != nullptr ? std::get<double>(line.value)
                                                                           : 0.0;
      if (seconds > 60.0)
        note(Fate::Doubted, parameter, fmt::format("{:g} s are no timeout: are these milliseconds?", seconds));
    }
    return true;
  }

  bool change_model(const Parameter& parameter, Line& line) {
    const auto* const model = std::get_if<std::string>(&line.value);
    if (model != nullptr && (*model == "LDLiDAR_LD06" || *model == "LDLiDAR_LD19")) return true;
    note(Fate::Doubted, parameter, "Nacelle reads LDLiDAR_LD06 and LDLiDAR_LD19");
    return false;
  }

  bool change_usb_cam(const Key& key, const Parameter& parameter, Line& line) {
    const auto* const whole = std::get_if<std::int64_t>(&line.value);
    if (key.name == "image_width" || key.name == "image_height") {
      auto& side = key.name == "image_width" ? width_ : height_;
      if (whole == nullptr) {
        note(Fate::Doubted, parameter, "is no whole number of pixels");
      } else {
        side = *whole;
        note(Fate::Translated, parameter, "one side of camera.image_size");
      }
      return false;
    }
    if (key.name == "framerate") return change_framerate(parameter, line);
    if (key.name == "pixel_format") return change_pixel_format(parameter, line);
    const bool is_control = key.text == kControlText;
    if (is_control && whole != nullptr && *whole == -1) {
      note(Fate::Dropped, parameter, "-1: the camera's own value stays");
      return false;
    }
    return true;
  }

  bool change_framerate(const Parameter& parameter, Line& line) {
    double hz = 0;
    if (const auto* const number = std::get_if<double>(&line.value)) hz = *number;
    if (const auto* const number = std::get_if<std::int64_t>(&line.value)) hz = static_cast<double>(*number);
    if (!(hz >= 0.1 && hz <= 1000.0)) {
      note(Fate::Doubted, parameter, "is no rate in Hz");
      return false;
    }
    // 29.97 is 1000/29970 s.
    const bool is_whole = std::abs(hz - std::round(hz)) < 1e-6;
    line.value = is_whole ? std::vector<std::int64_t>{1, std::llround(hz)}
                          : std::vector<std::int64_t>{1000, std::llround(hz * 1000)};
    return true;
  }

  /// usb_cam names what it reads and what it makes of it in one word.
  bool change_pixel_format(const Parameter& parameter, Line& line) {
    static const std::map<std::string, std::pair<const char*, const char*>> kFormats{
        {"yuyv", {"YUYV", "yuyv"}},     {"yuyv2rgb", {"YUYV", "rgb8"}},  {"uyvy", {"UYVY", "uyvy"}},
        {"uyvy2rgb", {"UYVY", "rgb8"}}, {"mjpeg2rgb", {"MJPG", "rgb8"}}, {"mjpeg", {"MJPG", "rgb8"}},
        {"rgb8", {"RGB3", "rgb8"}},     {"bgr8", {"BGR3", "bgr8"}},      {"mono8", {"GREY", "mono8"}}};
    const auto* const word = std::get_if<std::string>(&line.value);
    const auto found = word == nullptr ? kFormats.end() : kFormats.find(*word);
    if (found == kFormats.end()) {
      note(Fate::Doubted, parameter, "this form of picture is not served; the camera's default is YUYV to rgb8");
      return false;
    }
    line.value = std::string{found->second.first};
    put(own_node_, {"output_encoding", std::string{found->second.second}, ""});
    return true;
  }

  void write_image_size() {
    if (!width_ && !height_) return;
    // usb_cam's defaults stand in for the side that is not given.
    put(own_node_, {"image_size", std::vector<std::int64_t>{width_.value_or(640), height_.value_or(480)}, ""});
  }

  void add_default(const Default& standard) {
    const std::string target{standard.node.empty() ? std::string_view{own_node_} : standard.node};
    auto& lines = node(target).lines;
    if (std::ranges::any_of(lines, [&](const Line& line) { return line.name == standard.name && line.doubt.empty(); }))
      return;
    lines.push_back({std::string{standard.name}, launch::value_of_scalar(standard.value), ""});
    into_.notes.push_back(
        {Fate::Added, section_.where.text(), section_.pattern, std::string{standard.name},
         fmt::format("{}{}.{}: {} ({})", prefix_, target, standard.name, standard.value, standard.text)});
  }

  static constexpr std::string_view kControlText = "a control of the camera, if it has one of that name";
  const Driver& driver_;
  const ParameterSection& section_;
  Imported& into_;
  const std::string prefix_;
  std::string source_, own_node_;
  std::optional<std::int64_t> width_, height_;
};

void note_widened(const ParameterSection& section, const std::set<ListPlace>& changed, Imported& into) {
  for (const Parameter& parameter : section.parameters) {
    if (changed.count({parameter.where.line, last_part_of(parameter.name)}) == 0) continue;
    into.notes.push_back({Fate::Doubted, parameter.where.text(), section.pattern, parameter.name,
                          "holds whole numbers, which are written as 1.0 here: ROS 2 refuses the list as it is"});
  }
}

std::string names_of_drivers() {
  std::vector<std::string> names;
  for (const Driver& driver : drivers()) names.emplace_back(driver.name);
  return join(names);
}

}  // namespace

const char* to_text(Fate fate) {
  switch (fate) {
    case Fate::Kept: return "kept";
    case Fate::Translated: return "translated";
    case Fate::Dropped: return "dropped";
    case Fate::Doubted: return "doubted";
    case Fate::Added: return "added";
  }
  return "";
}

std::string Note::line() const { return fmt::format("{}: {}: {}.{}: {}", to_text(fate), where, node, key, text); }

std::string Imported::yaml() const {
  std::string out;
  for (const auto& node : nodes) {
    if (node.lines.empty()) continue;
    out += fmt::format("{}{}:\n  ros__parameters:\n", out.empty() ? "" : "\n", node.name);
    const bool has_value = std::ranges::any_of(node.lines, [](const Line& line) { return line.doubt.empty(); });
    if (!has_value) out += "    {}\n";
    for (const auto& line : node.lines) {
      out += line.doubt.empty()
                 ? fmt::format("    {}: {}\n", line.name, launch::to_text(line.value))
                 : fmt::format("    # {}: {}  # {}\n", line.name, launch::to_text(line.value), line.doubt);
    }
  }
  return out;
}

Result<void, std::vector<Problem>> import_file(std::string_view text, const std::string& file_name, Imported& into) {
  auto root = parse_yaml(text, file_name);
  if (!root) return err(std::vector<Problem>{root.error()});
  std::set<ListPlace> widened;
  widen_lists(*root, widened);
  const auto file = launch::read_parameter_tree(*root, file_name);
  if (!file) return err(file.error());
  std::vector<const ParameterSection*> unknown;
  std::size_t translated = 0;
  for (const ParameterSection& section : file.value().sections()) {
    if (const Driver* const driver = driver_of(section, split_name(section.pattern).second)) {
      Translator{*driver, section, into}.run();
      note_widened(section, widened, into);
      ++translated;
    } else if (!is_of_every_node(section)) {
      unknown.push_back(&section);
    }
  }
  if (translated == 0 && !unknown.empty()) {
    std::vector<Problem> problems;
    for (const ParameterSection* const section : unknown)
      problems.push_back(
          {section->where, "the driver of '" + section->pattern + "' is unknown: it is none of " + names_of_drivers(),
           "write the parameters of the Nacelle component yourself; `nacelle params --explain` lists them"});
    return err(std::move(problems));
  }
  for (const ParameterSection* const section : unknown) {
    for (const Parameter& parameter : section->parameters) {
      into.notes.push_back({Fate::Doubted, parameter.where.text(), section->pattern, parameter.name,
                            "the node's driver is unknown: not translated"});
    }
  }
  return {};
}

Result<void, Problem> may_write(const std::string& output, const std::vector<std::string>& inputs) {
  for (const auto& input : inputs) {
    std::error_code none;
    if (input == output || std::filesystem::equivalent(input, output, none))
      return err(Problem{output, "would be written over " + input + ", of which it is made", "give another -o FILE"});
  }
  return {};
}

}  // namespace nacelle::ros_import
