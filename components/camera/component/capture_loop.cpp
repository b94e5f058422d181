// SPDX-License-Identifier: Apache-2.0
#include "camera/component/capture_loop.hpp"

#include <algorithm>
#include <cstring>

#include "camera/component/calibration.hpp"
#include "camera/protocol/calibration_fault.hpp"

namespace nacelle::camera {

Result<void, Problem> CaptureLoop::open() {
  auto format = around_.port.open(settings_.wish);
  if (!format) return err(format.error());
  auto maker = ImageMaker::make(*format, *settings_.output);
  const LockGuard lock{calibration_};
  auto info = stream_info(settings_.camera_info_url, *format);
  if (!maker || !info) {
    around_.port.close();
    return err(!maker ? maker.error() : info.error());
  }
  for (const std::string& remark : format->remarks) around_.logger.warn("{}: {}", settings_.wish.device, remark);
  if (!info->remark.empty()) around_.logger.warn("{}", info->remark);
  format_ = std::move(*format);
  if (around_.watch != nullptr) around_.watch->expect_every(format_.frame_period);
  maker_ = std::make_unique<ImageMaker>(std::move(*maker));
  calibrated_ = format_;
  info->info.header.frame_id = settings_.frame_id;
  *info_.lock() = std::move(info->info);
  away_ = false;
  open_.store(true, std::memory_order_release);
  return {};
}

Result<std::string, Problem> CaptureLoop::set_calibration(const sensor_msgs::msg::CameraInfo& info) {
  const LockGuard lock{calibration_};
  if (calibrated_.width == 0) {
    return err(Problem{settings_.wish.device, "was not opened yet, so the size of its images is not known",
                       "call again when there are images", CalibrationFault::NoStream});
  }
  auto path = store_calibration(settings_.camera_info_url, calibrated_, info);
  if (!path) return path;
  auto shown = info_.lock();
  *shown = info;
  shown->header = {};
  shown->header.frame_id = settings_.frame_id;
  return path;
}

Result<void, Problem> CaptureLoop::start() {
  backoff_.reset();
  return around_.port.start();
}

void CaptureLoop::await_device(const Problem& why) {
  if (around_.watch != nullptr) around_.watch->lose(why.what);
  away_ = true;
  said_why_ = true;
  resume_at_ = around_.clock.now() + backoff_.next();
}

void CaptureLoop::close() {
  open_.store(false, std::memory_order_release);
  away_ = false;
  backoff_.reset();
  image_.reset();
  maker_.reset();
  around_.port.close();
}

CaptureLoop::Turn CaptureLoop::turn(MonotonicTime deadline) {
  if (away_ && !bring_back()) {
    look_for_silence();
    return Turn::Outage;
  }
  if (!image_) image_ = around_.images.borrow();
  ByteSpan room;
  if (image_) room = maker_->room_in(*image_);
  if (format_.fills_offered_memory && !image_) {
    // A port that draws has nowhere to draw to. The readers hold all messages: try again when the next frame is due.
    ++stats_.lock()->no_message;
    resume_at_ = around_.clock.now() + std::max<Duration>(format_.frame_period, 1ms);
    return Turn::Outage;
  }
  const auto frame = around_.port.next(deadline, room);
  if (!frame) {
    if (frame.error() == CaptureFault::NoFrame) {
      look_for_silence();
      return Turn::Nothing;
    }
    lose(frame.error());
    return Turn::Outage;
  }
  if (around_.watch != nullptr) around_.watch->heard(around_.clock.now());
  publish(frame.value());
  return Turn::Frame;
}

void CaptureLoop::look_for_silence() {
  if (around_.watch == nullptr) return;
  around_.watch->look(around_.clock.now(),
                      [this] { return std::to_string(stats().published + stats().not_decoded) + " frames so far"; });
}

void CaptureLoop::publish(const Frame& frame) {
  const bool came_as_jpeg = is_jpeg(format_.pixel_format);
  const bool wants_jpeg =
      came_as_jpeg && around_.compressed != nullptr && around_.compressed->get_subscription_count() > 0;
  const bool wants_image = !came_as_jpeg || around_.images.get_subscription_count() > 0;
  auto info = around_.infos.borrow();
  if (!info || (wants_image && !image_)) {
    frame.return_memory();
    ++stats_.lock()->no_message;
    return;
  }
  *info = *info_.lock();
  info->header.stamp = (settings_.use_capture_time ? frame.captured : frame.received) + settings_.stamp_offset;
  const auto stamp = info->header.stamp;
  auto outcome = ImageMaker::Outcome::Undecodable;
  if (wants_image) {
    Frame shown = frame;
    if (wants_jpeg) shown.give_back = {};  // the JPEG's message gives it back
    outcome = maker_->fill(shown, *image_);
  }
  const bool has_image = outcome != ImageMaker::Outcome::Undecodable;
  // camera_info first, so that a reader of the image already has its calibration.
  if (has_image || wants_jpeg || !wants_image) around_.infos.publish(std::move(info));
  if (wants_jpeg) {
    publish_jpeg(frame, stamp);
  } else if (!wants_image) {
    frame.return_memory();
  }
  if (has_image) {
    image_->header.stamp = stamp;
    image_->header.frame_id.assign(settings_.frame_id);
    around_.images.publish(std::move(image_));
  }  // otherwise the image serves for the next frame
  auto stats = stats_.lock();
  if (!wants_image) ++stats->not_decoded;
  if (wants_image && !has_image) ++stats->undecodable;
  if (has_image) ++stats->published;
  if (outcome == ImageMaker::Outcome::Adopted) ++stats->adopted;
  if (outcome == ImageMaker::Outcome::Copied) ++stats->copied;
}

void CaptureLoop::publish_jpeg(const Frame& frame, const builtin_interfaces::msg::Time& stamp) {
  auto jpeg = around_.compressed->borrow();
  if (!jpeg) {
    frame.return_memory();
    return;
  }
  jpeg->header.stamp = stamp;
  jpeg->header.frame_id.assign(settings_.frame_id);
  jpeg->format.assign("jpeg");
  if (frame.spare_buffers > kAlwaysQueued) {
    jpeg->data.adopt(frame.bytes.data(), frame.bytes.size(), frame.bytes.size(), frame.give_back);
  } else {
    jpeg->data.resize_uninitialized(frame.bytes.size());
    std::memcpy(jpeg->data.data(), frame.bytes.data(), frame.bytes.size());
    frame.return_memory();
  }
  around_.compressed->publish(std::move(jpeg));
  ++stats_.lock()->compressed;
}

void CaptureLoop::lose(CaptureFault fault) {
  if (around_.watch != nullptr) around_.watch->lose(to_text(fault));
  open_.store(false, std::memory_order_release);
  around_.port.close();
  ++stats_.lock()->outages;
  away_ = true;
  said_why_ = false;
  backoff_.reset();
  resume_at_ = around_.clock.now() + backoff_.next();
}

bool CaptureLoop::bring_back() {
  const MonotonicTime now = around_.clock.now();
  if (now < resume_at_) return false;
  image_.reset();
  auto opened = open();
  if (opened) {
    if (around_.on_reopened) around_.on_reopened();
    opened = around_.port.start();
  }
  if (!opened) {
    // Once per outage: while the device is absent, every attempt fails.
    if (!said_why_) around_.logger.info("{}", opened.error().text());
    said_why_ = true;
    if (around_.watch != nullptr) around_.watch->lose(opened.error().what);
    open_.store(false, std::memory_order_release);
    around_.port.close();
    away_ = true;
    resume_at_ = now + backoff_.next();
    return false;
  }
  away_ = false;
  ++stats_.lock()->returns;
  around_.logger.info("{}: frames come again", settings_.wish.device);
  return true;
}

}  // namespace nacelle::camera
