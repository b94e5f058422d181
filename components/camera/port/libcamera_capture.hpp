// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "camera/port/capture_port.hpp"
#include "nacelle/base/bell.hpp"
#include "nacelle/base/guarded.hpp"

namespace libcamera {
class CameraConfiguration;
}

namespace nacelle::camera {

class LibcameraStream;

/// A camera of libcamera: the Raspberry Pi's CSI cameras, whose exposure, white balance and colours are computed on this computer.
///
/// CaptureWish::device is "libcamera" or "libcamera:ID" (libcamera_search.hpp). A frame is the camera's dma-buf, mapped; nothing is copied.
/// Stamps are the sensor's. Controls are libcamera's of one number: "ExposureTime" is exposure_time; those with a point count
/// thousandths and say so, "AnalogueGain" is analogue_gain_milli.
/// Threads: as CapturePort; libcamera has a thread of its own while the camera is open. The clock outlives this object.
/// Source:  libcamera 0.4, its headers' documentation.
class LibcameraCapture final : public CapturePort {
 public:
  /// kAlwaysQueued, one that is being copied while those stay queued, and three for readers; a pipeline may give more or fewer.
  static constexpr unsigned kBuffers = kAlwaysQueued + 4;
  /// Nothing for this many frame times, and for a second: the stream is Broken.
  static constexpr int kSilentPeriods = 10;

  explicit LibcameraCapture(const Clock& clock);
  ~LibcameraCapture() override;

  [[nodiscard]] Result<CaptureFormat, Problem> open(const CaptureWish& wish) override;
  [[nodiscard]] Result<void, Problem> start() override;
  [[nodiscard]] Result<Frame, CaptureFault> next(MonotonicTime deadline, ByteSpan offered) override;
  void interrupt() noexcept override;
  void close() override;
  [[nodiscard]] std::vector<Control> controls() override { return controls_; }
  [[nodiscard]] Result<void, Problem> set_control(const Control& control, std::int64_t value) override;
  [[nodiscard]] CaptureStats stats() const override { return *stats_.lock(); }

 private:
  static constexpr std::uint32_t kMostLost = 100'000;  ///< An hour at 30 Hz.

  void stamp(std::int64_t stamp_ns, Frame& frame);

  const Clock& clock_;
  const std::shared_ptr<Bell> bell_;
  std::atomic<bool> interrupted_{false};
  std::string name_;
  CaptureFormat format_;
  std::unique_ptr<::libcamera::CameraConfiguration> configuration_;
  std::vector<Control> controls_;
  std::shared_ptr<LibcameraStream> stream_;                  ///< The capturing thread's.
  Guarded<std::shared_ptr<LibcameraStream>> shared_stream_;  ///< The same, for set_control().
  MonotonicTime last_frame_;
  std::uint32_t next_sequence_ = 0;
  bool has_sequence_ = false;
  std::uint64_t count_ = 0;  ///< Frames and losses since start(): the camera's 32-bit count, unwrapped.
  Guarded<CaptureStats> stats_;
};

}  // namespace nacelle::camera
