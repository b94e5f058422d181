// SPDX-License-Identifier: Apache-2.0
#include "camera/port/pattern_source.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <ctime>

#include "camera/port/camera_fault.hpp"
#include "nacelle/base/expect.hpp"

namespace nacelle::camera {

Result<CaptureFormat, Problem> PatternSource::open(const CaptureWish& wish) {
  if (!PatternScene::can_draw(wish.pixel_format)) {
    return err(Problem{"pattern source", fmt::format("cannot draw pixel format {}", to_text(wish.pixel_format)),
                       "use output_encoding rgb8, bgr8, yuyv, uyvy or mono8", CameraFault::CannotDraw,
                       to_text(wish.pixel_format)});
  }
  if (wish.width < 16 || wish.width > 4096 || wish.height < 16 || wish.height > 4096 || wish.width % 2 != 0) {
    return err(Problem{"pattern source", fmt::format("image_size [{}, {}] cannot be drawn", wish.width, wish.height),
                       "use sides from 16 to 4096, the width even", CameraFault::CannotDraw,
                       fmt::format("[{}, {}]", wish.width, wish.height)});
  }
  const double period_s = wish.period_num == 0 || wish.period_den == 0
                              ? 1.0 / PatternScene::kFramesPerSecond
                              : static_cast<double>(wish.period_num) / wish.period_den;
  period_ = std::clamp(from_seconds(period_s), Duration{1ms}, Duration{10s});
  scene_.emplace(wish.width, wish.height, wish.pixel_format);
  CaptureFormat format;
  format.pixel_format = wish.pixel_format;
  format.width = wish.width;
  format.height = wish.height;
  format.bytes_per_line = scene_->bytes_per_line();
  format.frame_bytes = scene_->frame_bytes();
  format.frame_period = period_;
  format.fills_offered_memory = true;
  format.lens = scene_->pinhole();
  format.camera_name = "pattern";
  return format;
}

Result<void, Problem> PatternSource::start() {
  NACELLE_EXPECT(scene_.has_value(), "start() follows open()");
  started_ = clock_.now();
  next_frame_ = 0;
  static_cast<void>(bell_.silence());
  return {};
}

Result<void, Problem> PatternSource::set_control(const Control& control, std::int64_t) {
  return err(Problem{"pattern source", "has no control " + control.name, "", CameraFault::NoControl, control.name});
}

Result<Frame, CaptureFault> PatternSource::next(MonotonicTime deadline, ByteSpan offered) {
  NACELLE_EXPECT(scene_.has_value() && offered.size() >= scene_->frame_bytes(),
                 "next() follows open(), and needs memory for a frame");
  MonotonicTime due = started_ + period_ * static_cast<std::int64_t>(next_frame_);
  if (const Duration wait = std::min(due, deadline) - clock_.now(); wait > Duration::zero()) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(wait);
    timespec left{};
    left.tv_sec = static_cast<time_t>(seconds.count());
    left.tv_nsec = static_cast<long>((wait - seconds).count());
    pollfd bell{bell_.descriptor(), POLLIN, 0};
    static_cast<void>(::ppoll(&bell, 1, &left, nullptr));
  }
  if (bell_.silence()) return err(CaptureFault::NoFrame);
  const MonotonicTime now = clock_.now();
  if (now < due) return err(CaptureFault::NoFrame);

  Frame frame;
  frame.lost = static_cast<std::uint64_t>((now - due) / period_);
  next_frame_ += frame.lost;
  due += period_ * static_cast<std::int64_t>(frame.lost);
  frame.sequence = next_frame_++;
  // The picture's time is when it was due, not when this thread ran.
  frame.received = clock_.wall_now();
  frame.captured = frame.received - (now - due);
  scene_->render(frame.sequence, offered);
  frame.bytes = offered.first(scene_->frame_bytes());
  frame.spare_buffers = 1;
  {
    auto stats = stats_.lock();
    ++stats->frames;
    stats->lost += frame.lost;
  }
  return frame;
}

}  // namespace nacelle::camera
