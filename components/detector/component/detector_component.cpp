// SPDX-License-Identifier: Apache-2.0
#include "detector/component/detector_component.hpp"

#include <opencv2/core/utility.hpp>

#include "nacelle/qos/presets.hpp"

namespace nacelle::detector {
namespace {

ParameterDescriptor whole(const char* description, std::int64_t from, std::int64_t to) {
  return {description, "", true, false, IntegerRange{from, to, 0}, std::nullopt};
}
ParameterDescriptor real(const char* description, double from, double to) {
  return {description, "", true, false, std::nullopt, FloatingPointRange{from, to, 0}};
}

}  // namespace

DetectorComponent::DetectorComponent(const NodeOptions& options) : LifecycleNode("detector", options) {
  const auto integer = [this](const char* name, int value, const char* what, std::int64_t from, std::int64_t to) {
    return static_cast<int>(declare_parameter<std::int64_t>(name, value, whole(what, from, to)));
  };
  DiscSettings& s = settings_;
  s.hue_min =
      integer("hue_min", s.hue_min, "Least hue in degrees / 2; larger than hue_max for a range through red.", 0, 179);
  s.hue_max = integer("hue_max", s.hue_max, "Greatest hue in degrees / 2.", 0, 179);
  s.saturation_min = integer("saturation_min", s.saturation_min, "Least saturation.", 0, 255);
  s.value_min = integer("value_min", s.value_min, "Least brightness.", 0, 255);
  s.value_max = integer("value_max", s.value_max, "Greatest brightness.", 0, 255);
  s.decimation = integer("decimation", s.decimation, "Every n-th row and column is looked at.", 1, 8);
  s.most = static_cast<std::size_t>(
      integer("max_detections", static_cast<int>(s.most), "Discs of one image, the largest first.", 1, 1000));
  s.min_area_px =
      declare_parameter<double>("min_area", s.min_area_px, real("Least area in pixels of the image.", 1.0, 1e9));
  s.min_roundness = declare_parameter<double>("min_roundness", s.min_roundness, real("1 is a perfect disc.", 0.0, 1.0));
  disc_diameter_m_ =
      declare_parameter<double>("disc_diameter_m", 0.20, real("Diameter of the disc in metres.", 0.001, 100.0));
  assumed_view_rad_ = declare_parameter<double>(
      "assumed_fov", 1.0471975511965976,
      real("Horizontal angle of view in radians of a camera without a calibration.", 0.05, 3.0));

  if (const auto checked = check_settings(); !checked) declare_problem(checked.error());

  detections_ = create_publisher<geometry_msgs::msg::PoseArray>("detections", QoS(10));
  infos_ = create_subscription<sensor_msgs::msg::CameraInfo>(
      "camera/camera_info", SensorDataQoS(QoS(1)),
      [this](const sensor_msgs::msg::CameraInfo& info) { on_camera_info(info); });
  images_ = create_subscription<sensor_msgs::msg::Image>(
      "camera/image_raw", SensorDataQoS(QoS(1)), [this](const sensor_msgs::msg::Image& image) { on_image(image); });
}

Result<void, Problem> DetectorComponent::check_settings() const {
  if (settings_.value_min <= settings_.value_max) return {};
  return err(Problem{"node " + get_fully_qualified_name() + ", parameter value_min",
                     std::to_string(settings_.value_min) + " is above value_max " + std::to_string(settings_.value_max),
                     "swap them"});
}

CallbackReturn DetectorComponent::on_configure(const State&) {
  if (const auto checked = check_settings(); !checked) return refuse(checked.error());
  // OpenCV would start a thread per core for pictures this small, and keep it waiting.
  cv::setNumThreads(1);
  detector_ = std::make_unique<DiscDetector>(settings_);
  return CallbackReturn::SUCCESS;
}

CallbackReturn DetectorComponent::on_cleanup(const State&) {
  detector_.reset();
  lens_.reset();
  refused_encoding_.clear();
  return CallbackReturn::SUCCESS;
}

void DetectorComponent::on_camera_info(const sensor_msgs::msg::CameraInfo& info) {
  lens_ = Lens::from(info);
  lens_width_ = info.width;
  lens_height_ = info.height;
}

Lens DetectorComponent::lens_for(const sensor_msgs::msg::Image& image) const {
  // A calibration of another size is of another picture.
  if (lens_ && lens_width_ == image.width && lens_height_ == image.height) return *lens_;
  return Lens::assumed(image.width, image.height, assumed_view_rad_);
}

void DetectorComponent::on_image(const sensor_msgs::msg::Image& image) {
  ++stats_.images;
  const auto view = view_of(image);
  if (!view) {
    ++stats_.refused;
    if (refused_encoding_ != image.encoding) {
      refused_encoding_ = image.encoding;
      get_logger().warn("images of {} ({}) are not looked at: {}; set the camera's output_encoding",
                        images_->get_topic_name(), image.encoding, to_text(view.error()));
    }
    return;
  }
  ++stats_.looked_at;
  const auto& discs = detector_->find(view.value());
  stats_.discs += discs.size();
  auto message = detections_->borrow();
  if (!message) return;
  message->header = image.header;
  message->poses.resize(discs.size());
  const Lens lens = lens_for(image);
  for (std::size_t i = 0; i < discs.size(); ++i) {
    const Disc& disc = discs[i];
    const Direction direction = lens.direction_of(disc.u_px, disc.v_px);
    const double distance_m = lens.focal_px() * 0.5 * disc_diameter_m_ / disc.radius_px;
    auto& pose = message->poses[i];
    pose.position.x = direction.x * distance_m;
    pose.position.y = direction.y * distance_m;
    pose.position.z = distance_m;
    pose.orientation = {};
    pose.orientation.w = 1.0;
  }
  detections_->publish(std::move(message));
}

}  // namespace nacelle::detector
