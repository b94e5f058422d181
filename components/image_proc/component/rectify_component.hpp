// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "image_proc/component/image_proc_stats.hpp"
#include "image_proc/model/rectification.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "sensor_msgs/msg/camera_info.hpp"
#include "sensor_msgs/msg/image.hpp"

namespace nacelle::image_proc {

/// Makes image_rect of image and camera_info (node name "rectify") while image_rect has a reader.
///
/// The map is computed at the first image after a camera_info with another lens. Stamp and frame are the image's. Topics and
/// parameters have the names of ROS 2's image_proc.
/// Threads: the component's executor. Allocates: nothing per image.
class RectifyComponent final : public LifecycleNode {
 public:
  explicit RectifyComponent(const NodeOptions& options);

  [[nodiscard]] const ImageProcStats& stats() const { return stats_; }
  /// How many maps were computed, or could not be.
  [[nodiscard]] std::uint64_t maps() const { return maps_; }

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_cleanup(const State&) override;

 private:
  void on_info(const sensor_msgs::msg::CameraInfo& info);
  void on_image(const sensor_msgs::msg::Image& image);
  /// The map for a picture of that size; null, with a warning, if there is none.
  [[nodiscard]] const SamplingMap* map_for(const Picture& picture);

  Interpolation interpolation_ = Interpolation::Linear;
  std::optional<sensor_msgs::msg::CameraInfo> info_;
  std::optional<Result<SamplingMap, CalibrationFault>> map_;  ///< Of info_; empty until an image needs it.
  std::uint64_t maps_ = 0;
  ImageProcStats stats_;
  std::shared_ptr<Publisher<sensor_msgs::msg::Image>> image_rect_;
  std::shared_ptr<Subscription<sensor_msgs::msg::CameraInfo>> camera_info_;
  std::shared_ptr<Subscription<sensor_msgs::msg::Image>> image_;
};

}  // namespace nacelle::image_proc
