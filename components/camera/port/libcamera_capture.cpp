// SPDX-License-Identifier: Apache-2.0
#include "camera/port/libcamera_capture.hpp"

#include <libcamera/control_ids.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>

#include "camera/model/sensor_time.hpp"
#include "camera/port/camera_fault.hpp"
#include "camera/port/libcamera_agreement.hpp"
#include "camera/port/libcamera_controls.hpp"
#include "camera/port/libcamera_stream.hpp"
#include "nacelle/base/expect.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::camera {

namespace {

std::int64_t nanoseconds_of(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

/// What the clock of stamps is ahead of the clock that stands still while the computer is suspended.
std::int64_t suspended_ns() {
  return std::max<std::int64_t>(0, nanoseconds_of(CLOCK_BOOTTIME) - nanoseconds_of(CLOCK_MONOTONIC));
}

CaptureFault fault_of(int os_code) {
  return os_code == -ENODEV || os_code == -ENXIO ? CaptureFault::Gone : CaptureFault::Broken;
}

}  // namespace

LibcameraCapture::LibcameraCapture(const Clock& clock) : clock_(clock), bell_(std::make_shared<Bell>()) {}

LibcameraCapture::~LibcameraCapture() { close(); }

Result<CaptureFormat, Problem> LibcameraCapture::open(const CaptureWish& wish) {
  close();
  name_ = wish.device;
  if (wish.memory != FrameMemory::Mapped)
    return err(
        Problem{name_, "frames are in libcamera's own memory only", "use io_method mmap", CameraFault::MemoryRefused});
  auto found = find_camera(name_);
  if (!found) return err(found.error());
  if (const int answer = found->camera->acquire(); answer != 0)
    return err(describe_libcamera_trouble(name_, "acquire", answer));
  auto& device = *found->camera;
  auto agreed = agree(device, wish, kBuffers);
  if (!agreed) {
    device.release();
    return err(agreed.error());
  }
  controls_ = list_controls(device.controls());
  format_ = agreed->format;
  configuration_ = std::move(agreed->configuration);
  stream_ = std::make_shared<LibcameraStream>(std::move(*found), bell_);
  if (agreed->frame_time_us) {
    const std::array<std::int64_t, 2> limits{*agreed->frame_time_us, *agreed->frame_time_us};
    static_cast<void>(stream_->set(::libcamera::controls::FRAME_DURATION_LIMITS,
                                   ::libcamera::ControlValue{::libcamera::Span<const std::int64_t, 2>{limits}}));
  }
  *shared_stream_.lock() = stream_;
  return format_;
}

Result<void, Problem> LibcameraCapture::start() {
  NACELLE_EXPECT(stream_ != nullptr && configuration_ != nullptr, "start() follows open(), once");
  const auto fault = stream_->start(*configuration_, format_.frame_bytes);
  configuration_.reset();
  if (fault.step != nullptr) {
    const Problem problem = describe_libcamera_trouble(name_, fault.step, fault.os_code);
    close();
    return err(problem);
  }
  last_frame_ = clock_.now();
  has_sequence_ = false;
  count_ = 0;
  interrupted_ = false;
  return {};
}

void LibcameraCapture::close() {
  if (stream_ == nullptr) return;
  shared_stream_.lock()->reset();
  configuration_.reset();  // some pipelines' hold the camera
  stream_->shut();
  stream_.reset();
  controls_.clear();
}

void LibcameraCapture::interrupt() noexcept {
  interrupted_.store(true, std::memory_order_release);
  bell_->ring();
}

Result<void, Problem> LibcameraCapture::set_control(const Control& control, std::int64_t value) {
  const std::shared_ptr<LibcameraStream> stream = *shared_stream_.lock();
  if (stream == nullptr) return err(Problem{name_, "is not open", "", CameraFault::NotOpen});
  const int answer = stream->set_number(control.id, value);
  if (answer == 0) return {};
  Problem problem = describe_libcamera_trouble(name_, "set a control", answer);
  problem.value = std::to_string(value);
  return err(std::move(problem));
}

Result<Frame, CaptureFault> LibcameraCapture::next(MonotonicTime deadline, ByteSpan) {
  NACELLE_EXPECT(stream_ != nullptr, "next() follows start()");
  const Duration silence = std::max<Duration>(1s, format_.frame_period * kSilentPeriods);
  for (;;) {
    if (interrupted_.exchange(false, std::memory_order_acquire)) return err(CaptureFault::NoFrame);
    if (stream_->gone()) return err(CaptureFault::Gone);
    if (const int failure = stream_->hook_failure(); failure != 0) return err(fault_of(failure));
    const auto done = stream_->completed();
    if (!done) {
      const MonotonicTime now = clock_.now();
      if (stream_->queued() == 0) last_frame_ = now;  // the camera's silence is our doing
      if (now - last_frame_ > silence) return err(CaptureFault::Broken);
      if (now >= deadline) return err(CaptureFault::NoFrame);
      static_cast<void>(io::wait_readable(-1, *bell_, clock_, deadline));
      continue;
    }
    last_frame_ = clock_.now();
    Frame frame;
    if (done->bytes != 0) {
      frame.lost = has_sequence_ ? static_cast<std::uint32_t>(done->sequence - next_sequence_) : 0;
      if (frame.lost > kMostLost) frame.lost = 0;  // a count that began anew
      has_sequence_ = true;
      next_sequence_ = done->sequence + 1;
    }
    count_ += frame.lost;
    frame.sequence = count_++;
    stats_.lock()->lost += frame.lost;
    const bool compressed = format_.bytes_per_line == 0;
    const ByteSpan memory = stream_->memory(done->index);
    const std::size_t bytes = compressed ? done->bytes : format_.frame_bytes;
    const bool torn = bytes == 0 || bytes > memory.size() || (done->bytes != 0 && done->bytes < bytes);
    if (done->damaged || torn) {
      ++(done->damaged ? stats_.lock()->damaged : stats_.lock()->torn);
      if (const int queued = stream_->queue(done->index); queued != 0) return err(fault_of(queued));
      continue;
    }
    frame.bytes = memory.first(bytes);
    stamp(done->stamp_ns, frame);
    frame.spare_buffers = stream_->queued();
    frame.dma_buf = stream_->dma_buf(done->index);
    frame.give_back = stream_->lend(done->index);
    auto stats = stats_.lock();
    ++stats->frames;
    if (frame.spare_buffers == 0) ++stats->starved;
    return frame;
  }
}

void LibcameraCapture::stamp(std::int64_t stamp_ns, Frame& frame) {
  // Sampled back to back for every frame, so that a step of the wall clock is followed at once.
  const MonotonicTime now = clock_.now();
  frame.received = clock_.wall_now();
  frame.captured = frame.received;
  const auto age = age_of(stamp_ns, std::chrono::nanoseconds{now.since_origin}.count(), suspended_ns());
  if (!age) {
    ++stats_.lock()->doubtful_stamps;
    return;
  }
  frame.captured = frame.received - *age;
}

}  // namespace nacelle::camera
