// SPDX-License-Identifier: Apache-2.0
#include "image_proc/component/rectify_component.hpp"

#include "nacelle/qos/presets.hpp"

namespace nacelle::image_proc {

RectifyComponent::RectifyComponent(const NodeOptions& options) : LifecycleNode("rectify", options) {
  interpolation_ = static_cast<Interpolation>(declare_parameter<std::int64_t>(
      "interpolation", 1,
      {.description = "0: nearest pixel. 1: linear.", .read_only = true, .integer_range = IntegerRange{0, 1, 0}}));
  image_rect_ = create_publisher<sensor_msgs::msg::Image>("image_rect", SensorDataQoS(QoS(2)));
  camera_info_ = create_subscription<sensor_msgs::msg::CameraInfo>(
      "camera_info", SensorDataQoS(QoS(1)), [this](const sensor_msgs::msg::CameraInfo& info) { on_info(info); });
  image_ = create_subscription<sensor_msgs::msg::Image>(
      "image", SensorDataQoS(QoS(1)), [this](const sensor_msgs::msg::Image& image) { on_image(image); });
}

CallbackReturn RectifyComponent::on_configure(const State&) {
  stats_ = {};
  maps_ = 0;
  return CallbackReturn::SUCCESS;
}

CallbackReturn RectifyComponent::on_cleanup(const State&) {
  info_.reset();
  map_.reset();
  return CallbackReturn::SUCCESS;
}

void RectifyComponent::on_info(const sensor_msgs::msg::CameraInfo& info) {
  if (info_ && same_lens(*info_, info)) return;
  info_ = info;
  map_.reset();
}

const SamplingMap* RectifyComponent::map_for(const Picture& picture) {
  if (picture.width != info_->width || picture.height != info_->height) {
    ++stats_.refused;
    get_logger().warn_throttle(10s, "{} is for {} x {} pixels, and the images of {} have {} x {}: they are left out",
                               camera_info_->get_topic_name(), info_->width, info_->height, image_->get_topic_name(),
                               picture.width, picture.height);
    return nullptr;
  }
  if (!map_) {
    map_ = rectification_map(*info_, interpolation_);
    ++maps_;
  }
  if (map_->has_value()) return &map_->value();
  ++stats_.refused;
  get_logger().warn_throttle(10s, "images of {} cannot be rectified with {}: {}", image_->get_topic_name(),
                             camera_info_->get_topic_name(), to_text(map_->error()));
  return nullptr;
}

void RectifyComponent::on_image(const sensor_msgs::msg::Image& image) {
  ++stats_.images;
  if (image_rect_->get_subscription_count() == 0) {
    ++stats_.unread;
    return;
  }
  const auto picture = picture_of(image, plain_encodings());
  if (!picture) {
    ++stats_.refused;
    get_logger().warn_throttle(10s, "images of {} are left out: {} ({} so far)", image_->get_topic_name(),
                               explain(picture.error(), image, plain_encodings()), stats_.refused);
    return;
  }
  if (!info_) {
    if (++stats_.waiting > 1) {  // the first image may be faster than its camera_info
      get_logger().warn_throttle(10s, "images of {} wait for {}, which has not come", image_->get_topic_name(),
                                 camera_info_->get_topic_name());
    }
    return;
  }
  const SamplingMap* const map = map_for(*picture);
  if (map == nullptr) return;
  auto message = image_rect_->borrow();
  if (!message) {
    ++stats_.no_message;
    return;
  }
  message->header = image.header;
  set_shape(*message, picture->width, picture->height, picture->encoding);
  map->apply(*picture, message->data.data());
  image_rect_->publish(std::move(message));
  ++stats_.made;
}

}  // namespace nacelle::image_proc
