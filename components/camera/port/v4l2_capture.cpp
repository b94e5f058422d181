// SPDX-License-Identifier: Apache-2.0
#include "camera/port/v4l2_capture.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>

#include "camera/port/camera_fault.hpp"
#include "camera/port/v4l2_negotiation.hpp"
#include "nacelle/base/expect.hpp"

namespace nacelle::camera {

V4l2Capture::V4l2Capture(const Clock& clock, std::shared_ptr<V4l2Calls> calls)
    : clock_(clock), calls_(std::move(calls)), bell_(std::make_shared<Bell>()) {}

Result<CaptureFormat, Problem> V4l2Capture::open(const CaptureWish& wish) {
  close();
  path_ = wish.device;
  const int descriptor = calls_->open(path_.c_str());
  if (descriptor < 0) return err(describe_trouble(path_, "open", descriptor));
  auto device = std::make_shared<V4l2Device>(calls_, descriptor, bell_);
  auto agreed = negotiate(*device, wish);
  if (!agreed) return agreed;
  format_ = *agreed;
  wish_ = wish;
  device_ = std::move(device);
  *shared_device_.lock() = device_;
  return agreed;
}

Result<void, Problem> V4l2Capture::start() {
  NACELLE_EXPECT(device_ != nullptr && device_->buffer_count() == 0, "start() follows open(), once");
  const auto fault = device_->start(kBuffers, wish_);
  if (fault.step != nullptr) {
    const Problem problem = describe_start(wish_, fault.step, fault.os_code);
    close();
    return err(problem);
  }
  last_frame_ = clock_.now();
  has_sequence_ = false;
  count_ = 0;
  interrupted_ = false;
  static_cast<void>(bell_->silence());
  return {};
}

void V4l2Capture::close() {
  if (device_ == nullptr) return;
  shared_device_.lock()->reset();
  device_->shut();
  device_.reset();
}

void V4l2Capture::interrupt() noexcept {
  interrupted_.store(true, std::memory_order_release);
  bell_->ring();
}

std::vector<Control> V4l2Capture::controls() {
  return device_ == nullptr ? std::vector<Control>{} : list_controls(*device_);
}

Result<void, Problem> V4l2Capture::set_control(const Control& control, std::int64_t value) {
  const std::shared_ptr<V4l2Device> device = *shared_device_.lock();
  if (device == nullptr) return err(Problem{path_, "is not open", "", CameraFault::NotOpen});
  v4l2_control setting{};
  setting.id = control.id;
  setting.value = static_cast<std::int32_t>(value);
  const int answer = device->call(VIDIOC_S_CTRL, setting);
  if (answer == 0) return {};
  Problem problem = describe_trouble(path_, "set " + control.name, answer);
  problem.value = std::to_string(value);
  return err(std::move(problem));
}

CaptureFault V4l2Capture::fault_of(int os_code) const {
  return os_code == -ENODEV || os_code == -ENXIO ? CaptureFault::Gone : CaptureFault::Broken;
}

Result<Frame, CaptureFault> V4l2Capture::next(MonotonicTime deadline, ByteSpan) {
  NACELLE_EXPECT(device_ != nullptr, "next() follows start()");
  const Duration silence = std::max<Duration>(1s, format_.frame_period * kSilentPeriods);
  for (;;) {
    if (interrupted_.exchange(false, std::memory_order_acquire)) {
      static_cast<void>(bell_->silence());
      return err(CaptureFault::NoFrame);
    }
    if (const int failure = device_->hook_failure(); failure != 0) return err(fault_of(failure));
    const MonotonicTime now = clock_.now();
    const bool starving = device_->queued() == 0;
    if (starving) {
      last_frame_ = now;  // the device's silence is our doing
    } else if (now - last_frame_ > silence) {
      return err(CaptureFault::Broken);
    }
    const DeviceWait woke = device_->wait(std::max(deadline - now, Duration::zero()));
    if (woke.woken) static_cast<void>(bell_->silence());
    if (woke.ready || woke.in_error) {
      v4l2_buffer buffer{};
      buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      buffer.memory = device_->kind();
      const int answer = device_->dequeue(VIDIOC_DQBUF, buffer);
      // "Error" with nothing to dequeue: the stream has ended, and waiting again would spin.
      if (answer == -EAGAIN && woke.in_error && !woke.ready) return err(CaptureFault::Broken);
      if (answer != 0 && answer != -EAGAIN) return err(fault_of(answer));
      if (answer == 0) {
        last_frame_ = clock_.now();
        Frame frame;
        frame.lost = has_sequence_ ? static_cast<std::uint32_t>(buffer.sequence - next_sequence_) : 0;
        // A driver that restarts its count has not lost four thousand million frames.
        if (frame.lost > kMostLost) frame.lost = 0;
        has_sequence_ = true;
        next_sequence_ = buffer.sequence + 1;
        count_ += frame.lost;
        frame.sequence = count_++;
        stats_.lock()->lost += frame.lost;
        if (usable(buffer)) {
          frame.bytes = device_->memory(buffer.index).first(buffer.bytesused);
          stamp(buffer, frame);
          frame.spare_buffers = device_->queued();
          frame.dma_buf = device_->dma_buf(buffer.index);
          frame.give_back = device_->lend(buffer.index);
          auto stats = stats_.lock();
          ++stats->frames;
          if (frame.spare_buffers == 0) ++stats->starved;
          return frame;
        }
        if (const int requeued = device_->queue(buffer.index); requeued != 0) return err(fault_of(requeued));
      }
    }
    if (clock_.now() >= deadline) return err(CaptureFault::NoFrame);
  }
}

bool V4l2Capture::usable(const v4l2_buffer& buffer) {
  if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0) {
    ++stats_.lock()->damaged;
    return false;
  }
  const bool compressed = format_.bytes_per_line == 0;
  const std::size_t least = compressed ? 1 : format_.frame_bytes;
  if (buffer.bytesused < least || buffer.bytesused > device_->memory(buffer.index).size()) {
    ++stats_.lock()->torn;
    return false;
  }
  return true;
}

void V4l2Capture::stamp(const v4l2_buffer& buffer, Frame& frame) {
  // Sampled back to back for every frame, so that a step of the wall clock is followed at once.
  const MonotonicTime now = clock_.now();
  frame.received = clock_.wall_now();
  frame.captured = frame.received;
  if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return;
  const MonotonicTime taken{std::chrono::seconds{buffer.timestamp.tv_sec} +
                            std::chrono::microseconds{buffer.timestamp.tv_usec}};
  const Duration age = now - taken;
  // uvcvideo's module parameter `clock` changes the clock but not the flag.
  if (age < -kStampSlack || age > kOldestStamp) {
    ++stats_.lock()->doubtful_stamps;
    return;
  }
  frame.captured = frame.received - age;
}

}  // namespace nacelle::camera
