// SPDX-License-Identifier: Apache-2.0
#include "image_proc/component/compress_component.hpp"

#include "nacelle/qos/presets.hpp"

namespace nacelle::image_proc {

CompressComponent::CompressComponent(const NodeOptions& options) : LifecycleNode("compress", options) {
  quality_ =
      static_cast<int>(declare_parameter<std::int64_t>("jpeg_quality", 95,
                                                       {.description = "Of libjpeg: 100 is the best, and the largest.",
                                                        .read_only = true,
                                                        .integer_range = IntegerRange{1, 100, 0}}));
  image_raw_ = create_subscription<sensor_msgs::msg::Image>(
      "image_raw", SensorDataQoS(QoS(1)), [this](const sensor_msgs::msg::Image& image) { on_image(image); });
  compressed_ = create_publisher<sensor_msgs::msg::CompressedImage>(image_raw_->get_topic_name() + "/compressed",
                                                                    SensorDataQoS(QoS(2)));
}

CallbackReturn CompressComponent::on_configure(const State&) {
  encoder_ = std::make_unique<JpegEncoder>();
  stats_ = {};
  return CallbackReturn::SUCCESS;
}

CallbackReturn CompressComponent::on_cleanup(const State&) {
  encoder_.reset();
  return CallbackReturn::SUCCESS;
}

void CompressComponent::on_image(const sensor_msgs::msg::Image& image) {
  ++stats_.images;
  if (compressed_->get_subscription_count() == 0) {
    ++stats_.unread;
    return;
  }
  const auto picture = picture_of(image, plain_encodings());
  if (!picture) {
    ++stats_.refused;
    get_logger().warn_throttle(10s, "images of {} are left out: {} ({} so far)", image_raw_->get_topic_name(),
                               explain(picture.error(), image, plain_encodings()), stats_.refused);
    return;
  }
  auto message = compressed_->borrow();
  if (!message) {
    ++stats_.no_message;
    return;
  }
  if (const auto encoded = encoder_->encode(*picture, quality_, message->data); !encoded) {
    ++stats_.refused;
    get_logger().warn_throttle(10s, "an image of {} is left out: {}", image_raw_->get_topic_name(),
                               to_text(encoded.error()));
    return;
  }
  message->header = image.header;
  message->format.assign(picture->encoding.name);
  message->format.append("; jpeg compressed ").append(picture->encoding.channels == 1 ? "mono8" : "bgr8");
  compressed_->publish(std::move(message));
  ++stats_.made;
}

}  // namespace nacelle::image_proc
