// SPDX-License-Identifier: Apache-2.0
#include "image_proc/component/debayer_component.hpp"

#include <fmt/format.h>

#include <opencv2/core/utility.hpp>

#include "nacelle/qos/presets.hpp"

namespace nacelle::image_proc {

DebayerComponent::DebayerComponent(const NodeOptions& options) : LifecycleNode("debayer", options) {
  declare_parameter<std::int64_t>("debayer", 0,
                                  {.description = "0: bilinear. image_proc's 1, 2 and 3 are not made.",
                                   .read_only = true,
                                   .integer_range = IntegerRange{0, 0, 0}});
  declare_parameter<std::string>(
      "color_encoding", "bgr8",
      {.description = "Of image_color: bgr8, as image_proc makes it, or rgb8.", .read_only = true});
  if (const auto color = color_encoding(); !color) declare_problem(color.error());
  image_color_ = create_publisher<sensor_msgs::msg::Image>("image_color", SensorDataQoS(QoS(2)));
  image_mono_ = create_publisher<sensor_msgs::msg::Image>("image_mono", SensorDataQoS(QoS(2)));
  image_raw_ = create_subscription<sensor_msgs::msg::Image>(
      "image_raw", SensorDataQoS(QoS(1)), [this](const sensor_msgs::msg::Image& image) { on_image(image); });
}

Result<Encoding, Problem> DebayerComponent::color_encoding() const {
  const auto wanted = get<std::string>("color_encoding");
  for (const Encoding& one : plain_encodings()) {
    if (one.channels == 3 && one.name == wanted) return one;
  }
  return err(Problem{Place::of_parameter("color_encoding", get_fully_qualified_name()),
                     fmt::format("'{}' is not made of a mosaic", wanted), "give bgr8 or rgb8"});
}

CallbackReturn DebayerComponent::on_configure(const State&) {
  const auto color = color_encoding();
  if (!color) return refuse(color.error());
  color_ = *color;
  cv::setNumThreads(1);  // OpenCV would start a thread per core, and keep it waiting
  stats_ = {};
  return CallbackReturn::SUCCESS;
}

void DebayerComponent::on_image(const sensor_msgs::msg::Image& image) {
  ++stats_.images;
  const bool wants_color = image_color_->get_subscription_count() > 0;
  const bool wants_mono = image_mono_->get_subscription_count() > 0;
  if (!wants_color && !wants_mono) {
    ++stats_.unread;
    return;
  }
  const auto mosaic = picture_of(image, mosaic_encodings(), kLeastMosaicSide);
  if (!mosaic) {
    ++stats_.refused;
    get_logger().warn_throttle(10s, "images of {} are left out: {} ({} so far)", image_raw_->get_topic_name(),
                               explain(mosaic.error(), image, mosaic_encodings(), kLeastMosaicSide), stats_.refused);
    return;
  }
  const bool has_color = wants_color && publish(*image_color_, image, *mosaic, color_);
  const bool has_mono = wants_mono && publish(*image_mono_, image, *mosaic, plain_encodings().front());
  ++(has_color || has_mono ? stats_.made : stats_.no_message);
}

bool DebayerComponent::publish(Publisher<sensor_msgs::msg::Image>& to, const sensor_msgs::msg::Image& image,
                               const Picture& mosaic, const Encoding& encoding) const {
  auto message = to.borrow();
  if (!message) return false;
  message->header = image.header;
  set_shape(*message, mosaic.width, mosaic.height, encoding);
  debayer(mosaic, encoding, message->data.data());
  to.publish(std::move(message));
  return true;
}

}  // namespace nacelle::image_proc
