// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "image_proc/component/image_proc_stats.hpp"
#include "image_proc/model/resizer.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "sensor_msgs/msg/camera_info.hpp"
#include "sensor_msgs/msg/image.hpp"

namespace nacelle::image_proc {

/// Makes resize/image_raw and resize/camera_info of image/image_raw and image/camera_info (node name "resize"), each only while
/// it has a reader.
///
/// A camera_info is published for each image, before it and with its header, once the camera's is known and has the images'
/// size. Topics and parameters have the names of ROS 2's image_proc.
/// Threads: the component's executor. Allocates: nothing per image with interpolation 0 and 1; OpenCV does with the others.
class ResizeComponent final : public LifecycleNode {
 public:
  explicit ResizeComponent(const NodeOptions& options);

  [[nodiscard]] const ImageProcStats& stats() const { return stats_; }

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_cleanup(const State&) override;

 private:
  struct Wish {
    bool use_scale = true;
    double scale_width = 1, scale_height = 1;
    std::int64_t width = -1, height = -1;  ///< -1: the picture's own.
  };
  [[nodiscard]] Result<void, Problem> check_wish() const;
  void on_image(const sensor_msgs::msg::Image& image);
  /// The size of what is made of a picture; nothing if there can be no such picture.
  [[nodiscard]] std::optional<SamplingMap::Size> made_of(const Picture& picture) const;
  void publish_info(const sensor_msgs::msg::Image& image, SamplingMap::Size made);

  Wish wish_;
  Interpolation interpolation_ = Interpolation::Linear;
  std::unique_ptr<Resizer> resizer_;
  std::optional<sensor_msgs::msg::CameraInfo> info_;
  ImageProcStats stats_;
  std::shared_ptr<Publisher<sensor_msgs::msg::Image>> resized_;
  std::shared_ptr<Publisher<sensor_msgs::msg::CameraInfo>> resized_info_;
  std::shared_ptr<Subscription<sensor_msgs::msg::CameraInfo>> camera_info_;
  std::shared_ptr<Subscription<sensor_msgs::msg::Image>> image_;
};

}  // namespace nacelle::image_proc
