// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "detector/model/disc_detector.hpp"
#include "detector/model/lens.hpp"
#include "geometry_msgs/msg/pose_array.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "sensor_msgs/msg/camera_info.hpp"
#include "sensor_msgs/msg/image.hpp"

namespace nacelle::detector {

/// images == looked_at + refused
struct DetectorStats {
  std::uint64_t images{};
  std::uint64_t looked_at{};
  std::uint64_t refused{};  ///< Encodings that cannot be read, and images shorter than they say.
  std::uint64_t discs{};
};

/// Finds discs of known size and colour in camera/image_raw, and publishes where they are on detections.
///
/// One PoseArray per image, empty when there is no disc; z axis forward, orientation none. Distances come from the lens
/// of camera/camera_info; without a calibration from the parameter assumed_fov.
/// Frame:     the image's, an optical one. Threads: the component's executor. Allocates: OpenCV does.
class DetectorComponent final : public LifecycleNode {
 public:
  explicit DetectorComponent(const NodeOptions& options);

  [[nodiscard]] const DetectorStats& stats() const { return stats_; }

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_cleanup(const State&) override;

 private:
  /// Errors: limits that leave nothing between them.
  [[nodiscard]] Result<void, Problem> check_settings() const;
  void on_image(const sensor_msgs::msg::Image& image);
  void on_camera_info(const sensor_msgs::msg::CameraInfo& info);
  [[nodiscard]] Lens lens_for(const sensor_msgs::msg::Image& image) const;

  DiscSettings settings_;
  double disc_diameter_m_ = 0;
  double assumed_view_rad_ = 0;
  std::unique_ptr<DiscDetector> detector_;
  std::optional<Lens> lens_;
  std::uint32_t lens_width_ = 0, lens_height_ = 0;
  std::string refused_encoding_;  ///< Said once each time it changes.
  DetectorStats stats_;
  std::shared_ptr<Publisher<geometry_msgs::msg::PoseArray>> detections_;
  std::shared_ptr<Subscription<sensor_msgs::msg::CameraInfo>> infos_;
  std::shared_ptr<Subscription<sensor_msgs::msg::Image>> images_;
};

}  // namespace nacelle::detector
