// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "camera/port/capture_port.hpp"
#include "camera/port/v4l2_device.hpp"
#include "nacelle/base/guarded.hpp"

struct v4l2_buffer;

namespace nacelle::camera {

/// A camera of the kernel: single-planar streaming. USB cameras and any other device with that interface.
///
/// A frame is the buffer that the driver filled, mapped, of this process, or another device's (CaptureWish::memory); nothing is
/// copied. Three system calls a frame: poll, DQBUF, and the hook's QBUF.
/// Threads: as CapturePort. The clock outlives this object.
/// Source:  kernel, Documentation/userspace-api/media/v4l (mmap.rst, vidioc-qbuf.rst, buffer.rst).
class V4l2Capture final : public CapturePort {
 public:
  /// kAlwaysQueued, one that is being copied while those stay queued, and three for readers.
  static constexpr unsigned kBuffers = kAlwaysQueued + 4;
  /// Nothing for this many frame times, and for a second: the stream is Broken. A USB reset or suspend stalls it
  /// silently.
  static constexpr int kSilentPeriods = 10;

  explicit V4l2Capture(const Clock& clock, std::shared_ptr<V4l2Calls> calls = kernel_calls());
  ~V4l2Capture() override { close(); }

  [[nodiscard]] Result<CaptureFormat, Problem> open(const CaptureWish& wish) override;
  [[nodiscard]] Result<void, Problem> start() override;
  [[nodiscard]] Result<Frame, CaptureFault> next(MonotonicTime deadline, ByteSpan offered) override;
  void interrupt() noexcept override;
  void close() override;
  [[nodiscard]] std::vector<Control> controls() override;
  [[nodiscard]] Result<void, Problem> set_control(const Control& control, std::int64_t value) override;
  [[nodiscard]] CaptureStats stats() const override { return *stats_.lock(); }

 private:
  static constexpr std::uint32_t kMostLost = 100'000;  ///< An hour at 30 Hz.
  static constexpr Duration kStampSlack = 1ms, kOldestStamp = 10s;

  [[nodiscard]] bool usable(const v4l2_buffer& buffer);
  void stamp(const v4l2_buffer& buffer, Frame& frame);
  [[nodiscard]] CaptureFault fault_of(int os_code) const;

  const Clock& clock_;
  const std::shared_ptr<V4l2Calls> calls_;
  const std::shared_ptr<Bell> bell_;
  std::atomic<bool> interrupted_{false};
  std::string path_;
  CaptureWish wish_;
  CaptureFormat format_;
  std::shared_ptr<V4l2Device> device_;                  ///< The capturing thread's.
  Guarded<std::shared_ptr<V4l2Device>> shared_device_;  ///< The same, for set_control().
  MonotonicTime last_frame_;
  std::uint32_t next_sequence_ = 0;
  bool has_sequence_ = false;
  std::uint64_t count_ = 0;  ///< Frames and losses since start(): the driver's 32-bit count, unwrapped.
  Guarded<CaptureStats> stats_;
};

}  // namespace nacelle::camera
