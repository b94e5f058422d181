// SPDX-License-Identifier: Apache-2.0
#include "image_proc/component/resize_component.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <opencv2/core/utility.hpp>

#include "nacelle/qos/presets.hpp"

namespace nacelle::image_proc {

ResizeComponent::ResizeComponent(const NodeOptions& options) : LifecycleNode("resize", options) {
  const auto ratio = [this](const char* name, const char* description) {
    return declare_parameter<double>(
        name, 1.0,
        {.description = description, .read_only = true, .floating_point_range = FloatingPointRange{0.001, 100.0, 0}});
  };
  const auto side = [this](const char* name, const char* description) {
    return declare_parameter<std::int64_t>(
        name, -1, {.description = description, .read_only = true, .integer_range = IntegerRange{-1, kMostSide, 0}});
  };
  wish_.use_scale = declare_parameter<bool>(
      "use_scale", true,
      {.description = "true: scale_width and scale_height count; false: width and height.", .read_only = true});
  wish_.scale_width = ratio("scale_width", "Ratio of the new width to the image's.");
  wish_.scale_height = ratio("scale_height", "Ratio of the new height to the image's.");
  wish_.width = side("width", "New width in pixels; -1: the image's.");
  wish_.height = side("height", "New height in pixels; -1: the image's.");
  interpolation_ = static_cast<Interpolation>(declare_parameter<std::int64_t>(
      "interpolation", 1,
      {.description =
           "0: nearest pixel. 1: linear. 2: cubic. 3: mean of the area, for much smaller images. 4: Lanczos.",
       .read_only = true,
       .integer_range = IntegerRange{0, 4, 0}}));
  if (const auto checked = check_wish(); !checked) declare_problem(checked.error());
  resized_ = create_publisher<sensor_msgs::msg::Image>("resize/image_raw", SensorDataQoS(QoS(2)));
  resized_info_ = create_publisher<sensor_msgs::msg::CameraInfo>("resize/camera_info", SensorDataQoS(QoS(2)));
  camera_info_ = create_subscription<sensor_msgs::msg::CameraInfo>(
      "image/camera_info", SensorDataQoS(QoS(1)), [this](const sensor_msgs::msg::CameraInfo& info) { info_ = info; });
  image_ = create_subscription<sensor_msgs::msg::Image>(
      "image/image_raw", SensorDataQoS(QoS(1)), [this](const sensor_msgs::msg::Image& image) { on_image(image); });
}

Result<void, Problem> ResizeComponent::check_wish() const {
  for (const auto& [name, value] : {std::pair{"width", wish_.width}, {"height", wish_.height}}) {
    if (value == 0) {
      return err(Problem{Place::of_parameter(name, get_fully_qualified_name()), "an image cannot have 0 pixels",
                         "give the pixels, or -1 for the image's own"});
    }
  }
  return {};
}

CallbackReturn ResizeComponent::on_configure(const State&) {
  if (const auto checked = check_wish(); !checked) return refuse(checked.error());
  cv::setNumThreads(1);  // OpenCV would start a thread per core, and keep it waiting
  resizer_ = std::make_unique<Resizer>(interpolation_);
  stats_ = {};
  return CallbackReturn::SUCCESS;
}

CallbackReturn ResizeComponent::on_cleanup(const State&) {
  resizer_.reset();
  info_.reset();
  return CallbackReturn::SUCCESS;
}

std::optional<SamplingMap::Size> ResizeComponent::made_of(const Picture& picture) const {
  const auto side = [this](std::uint32_t own, double ratio, std::int64_t given) {
    if (wish_.use_scale) return std::max(std::round(own * ratio), 1.0);
    return static_cast<double>(given < 0 ? own : given);
  };
  const double width = side(picture.width, wish_.scale_width, wish_.width);
  const double height = side(picture.height, wish_.scale_height, wish_.height);
  if (width > kMostSide || height > kMostSide || width * height > kMostPixels) return std::nullopt;
  return SamplingMap::Size{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
}

void ResizeComponent::on_image(const sensor_msgs::msg::Image& image) {
  ++stats_.images;
  const bool wants_image = resized_->get_subscription_count() > 0;
  if (!wants_image && resized_info_->get_subscription_count() == 0) {
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
  const auto made = made_of(*picture);
  if (!made) {
    ++stats_.refused;
    get_logger().warn_throttle(10s,
                               "images of {} are left out: of {} x {} pixels the parameters make sides above {} or "
                               "more than {} pixels",
                               image_->get_topic_name(), picture->width, picture->height, kMostSide, kMostPixels);
    return;
  }
  auto message = wants_image ? resized_->borrow() : Loan<sensor_msgs::msg::Image>{};
  if (wants_image && !message) {
    ++stats_.no_message;
    return;
  }
  publish_info(image, *made);
  if (message) {
    message->header = image.header;
    set_shape(*message, made->width, made->height, picture->encoding);
    resizer_->resize(*picture, *made, message->data.data());
    resized_->publish(std::move(message));
  }
  ++stats_.made;
}

void ResizeComponent::publish_info(const sensor_msgs::msg::Image& image, SamplingMap::Size made) {
  if (resized_info_->get_subscription_count() == 0) return;
  if (!info_ || info_->width != image.width || info_->height != image.height) {
    get_logger().warn_throttle(
        10s, "images of {} are {} x {} pixels, and {} {}: it is not published for the resized ones",
        image_->get_topic_name(), image.width, image.height, camera_info_->get_topic_name(),
        info_ ? fmt::format("is for {} x {}", info_->width, info_->height) : std::string("has not come"));
    return;
  }
  auto message = resized_info_->borrow();
  if (!message) return;
  *message = *info_;
  message->header = image.header;
  scale(*message, {image.width, image.height}, made);
  resized_info_->publish(std::move(message));
}

}  // namespace nacelle::image_proc
