// SPDX-License-Identifier: Apache-2.0
#include "camera/protocol/camera_info_yaml.hpp"

#include <charconv>
#include <cmath>
#include <span>
#include <vector>

#include "camera/protocol/calibration_fault.hpp"
#include "camera/protocol/distortion_model.hpp"
#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle::camera {
namespace {

// Each reader below sets `problem_` once and returns false; the first problem is reported.
class Reader {
 public:
  explicit Reader(std::string file_name) : file_(std::move(file_name)) {}

  [[nodiscard]] const Problem& problem() const { return problem_; }

  bool fail(CalibrationFault fault, int line, std::string value, std::string what,
            std::string way_out = "see camera_calibration's file format") {
    problem_ = {Place(file_, line), std::move(what), std::move(way_out), fault, std::move(value)};
    return false;
  }

  bool number(const YamlNode& node, const std::string& name, double& to) {
    std::string_view text = node.text;
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (!node.is_scalar() || error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
      return fail(CalibrationFault::NotANumber, node.line, node.text,
                  name + " is not a finite number" + (node.is_scalar() ? ": '" + node.text + "'" : ""));
    }
    to = value;
    return true;
  }

  bool natural(const YamlNode& node, const std::string& name, std::uint32_t& to, std::uint32_t most) {
    double value = 0;
    if (!number(node, name, value)) return false;
    if (value < 0 || value > most || value != std::floor(value)) {
      return fail(CalibrationFault::OutOfRange, node.line, node.text,
                  name + " is " + node.text + ", not a whole number from 0 to " + std::to_string(most));
    }
    to = static_cast<std::uint32_t>(value);
    return true;
  }

  const YamlNode* required(const YamlNode& map, const char* name) {
    const YamlNode* const found = map.find(name);
    if (found == nullptr)
      fail(CalibrationFault::MissingKey, map.line == 0 ? 1 : map.line, name, std::string("no key '") + name + "'");
    return found;
  }

  bool numbers(const YamlNode& data, const std::string& name, std::span<double> to) {
    if (!data.is_sequence() || data.items.size() != to.size()) {
      return fail(CalibrationFault::WrongShape, data.line, std::to_string(data.items.size()),
                  name + " has " + std::to_string(data.items.size()) + " numbers, not " + std::to_string(to.size()));
    }
    for (std::size_t i = 0; i < to.size(); ++i) {
      if (!number(data.items[i], name, to[i])) return false;
    }
    return true;
  }

  bool matrix(const YamlNode& root, const char* name, std::uint32_t rows, std::uint32_t columns, std::span<double> to) {
    const YamlNode* const map = required(root, name);
    if (map == nullptr) return false;
    for (const auto& [key, wanted] : {std::pair{"rows", rows}, std::pair{"cols", columns}}) {
      const YamlNode* const count = required(*map, key);
      std::uint32_t value = 0;
      if (count == nullptr || !natural(*count, std::string(name) + "." + key, value, 1000)) return false;
      if (value != wanted)
        return fail(CalibrationFault::WrongShape, count->line, count->text,
                    std::string(name) + "." + key + " is " + count->text + ", not " + std::to_string(wanted));
    }
    const YamlNode* const data = required(*map, "data");
    return data != nullptr && numbers(*data, std::string(name) + ".data", to);
  }

  bool distortion(const YamlNode& root, sensor_msgs::msg::CameraInfo& info) {
    const YamlNode* const model = root.find("distortion_model");
    info.distortion_model = model == nullptr ? "plumb_bob" : model->text;
    const std::size_t wanted = coefficients_of(info.distortion_model);
    if (wanted == 0) {
      return fail(CalibrationFault::UnknownModel, model != nullptr ? model->line : 0, info.distortion_model,
                  "distortion_model '" + info.distortion_model + "' is not known",
                  suggestion(info.distortion_model, distortion_model_names()));
    }
    const YamlNode* const map = required(root, "distortion_coefficients");
    if (map == nullptr) return false;
    const YamlNode* const data = required(*map, "data");
    if (data == nullptr) return false;
    std::vector<double> values(wanted);
    if (!numbers(*data, "distortion_coefficients.data (" + info.distortion_model + ")", values)) return false;
    info.d.assign(values.begin(), values.end());
    return true;
  }

  bool region(const YamlNode& root, sensor_msgs::msg::CameraInfo& info) {
    for (const auto& [name, to] : {std::pair{"binning_x", &info.binning_x}, std::pair{"binning_y", &info.binning_y}}) {
      const YamlNode* const node = root.find(name);
      if (node != nullptr && !natural(*node, name, *to, kMostBinning)) return false;
    }
    const YamlNode* const roi = root.find("roi");
    if (roi == nullptr || roi->is_null()) return true;
    for (const auto& [name, to] : {std::pair{"x_offset", &info.roi.x_offset}, std::pair{"y_offset", &info.roi.y_offset},
                                   std::pair{"height", &info.roi.height}, std::pair{"width", &info.roi.width}}) {
      const YamlNode* const node = required(*roi, name);
      if (node == nullptr || !natural(*node, std::string("roi.") + name, *to, kMostCalibratedPixels)) return false;
    }
    const YamlNode* const rectify = required(*roi, "do_rectify");
    if (rectify == nullptr) return false;
    // OpenCV writes 0 and 1, people write words.
    info.roi.do_rectify = rectify->text == "true" || rectify->text == "True" || rectify->text == "1";
    return true;
  }

  bool read(const YamlNode& root, Calibration& to) {
    if (!root.is_map())
      return fail(CalibrationFault::Malformed, 1, "",
                  "not a calibration: " + std::string(root.kind_text()) + " instead of a map");
    for (const auto& [name, side] :
         {std::pair{"image_width", &to.info.width}, std::pair{"image_height", &to.info.height}}) {
      const YamlNode* const node = required(root, name);
      if (node == nullptr || !natural(*node, name, *side, kMostCalibratedPixels)) return false;
    }
    const YamlNode* const name = root.find("camera_name");
    to.camera_name = name == nullptr ? "unknown" : name->text;
    return matrix(root, "camera_matrix", 3, 3, to.info.k) && distortion(root, to.info) &&
           matrix(root, "rectification_matrix", 3, 3, to.info.r) &&
           matrix(root, "projection_matrix", 3, 4, to.info.p) && region(root, to.info);
  }

 private:
  std::string file_;
  Problem problem_;
};

}  // namespace

Result<Calibration, Problem> parse_camera_info(std::string_view yaml, const std::string& file_name) {
  auto root = parse_yaml(yaml, file_name);
  if (!root) {
    Problem problem = root.error();
    problem.code = CalibrationFault::Malformed;
    return err(std::move(problem));
  }
  Reader reader{file_name};
  Calibration calibration;
  if (!reader.read(*root, calibration)) return err(reader.problem());
  return calibration;
}

}  // namespace nacelle::camera
