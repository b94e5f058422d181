// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "image_proc/component/image_proc_stats.hpp"
#include "image_proc/model/jpeg_encoder.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "sensor_msgs/msg/compressed_image.hpp"
#include "sensor_msgs/msg/image.hpp"

namespace nacelle::image_proc {

/// Makes JPEGs of image_raw (node name "compress") while its topic's .../compressed has a reader.
///
/// The topic is that of the images with /compressed behind it, after remapping. Stamp and frame are the image's; `format` is
/// what ROS 2's compressed_image_transport writes, "rgb8; jpeg compressed bgr8", so that its readers restore the encoding.
/// Threads: the component's executor. Allocates: nothing per image, unless a JPEG is larger than all before it.
class CompressComponent final : public LifecycleNode {
 public:
  explicit CompressComponent(const NodeOptions& options);

  [[nodiscard]] const ImageProcStats& stats() const { return stats_; }

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_cleanup(const State&) override;

 private:
  void on_image(const sensor_msgs::msg::Image& image);

  int quality_ = 95;
  std::unique_ptr<JpegEncoder> encoder_;
  ImageProcStats stats_;
  std::shared_ptr<Subscription<sensor_msgs::msg::Image>> image_raw_;
  std::shared_ptr<Publisher<sensor_msgs::msg::CompressedImage>> compressed_;
};

}  // namespace nacelle::image_proc
