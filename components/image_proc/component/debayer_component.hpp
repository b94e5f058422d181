// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "image_proc/component/image_proc_stats.hpp"
#include "image_proc/model/debayer.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "sensor_msgs/msg/image.hpp"

namespace nacelle::image_proc {

/// Makes image_color and image_mono of the Bayer mosaics of image_raw (node name "debayer"), each only while it has a reader.
///
/// Stamp and frame are the mosaic's. Topics and the parameter `debayer` have the names of ROS 2's image_proc.
/// Threads: the component's executor. Allocates: nothing per image.
class DebayerComponent final : public LifecycleNode {
 public:
  explicit DebayerComponent(const NodeOptions& options);

  [[nodiscard]] const ImageProcStats& stats() const { return stats_; }

 protected:
  CallbackReturn on_configure(const State&) override;

 private:
  /// Errors: a colour encoding that is not made.
  [[nodiscard]] Result<Encoding, Problem> color_encoding() const;
  void on_image(const sensor_msgs::msg::Image& image);
  [[nodiscard]] bool publish(Publisher<sensor_msgs::msg::Image>& to, const sensor_msgs::msg::Image& image,
                             const Picture& mosaic, const Encoding& encoding) const;

  Encoding color_{};
  ImageProcStats stats_;
  std::shared_ptr<Publisher<sensor_msgs::msg::Image>> image_color_, image_mono_;
  std::shared_ptr<Subscription<sensor_msgs::msg::Image>> image_raw_;
};

}  // namespace nacelle::image_proc
