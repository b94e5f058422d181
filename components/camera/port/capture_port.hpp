// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "camera/model/pattern_scene.hpp"
#include "camera/model/pixel_format.hpp"
#include "nacelle/base/buffer.hpp"
#include "nacelle/base/bytes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::camera {

/// Whose memory a device writes its frames into.
enum class FrameMemory : std::uint8_t {
  Mapped,   ///< The driver's own, mapped. Every camera has it.
  Own,      ///< This process's. Drivers whose DMA needs contiguous memory refuse it.
  Imported  ///< Another device's: CaptureWish::imports.
};

/// Buffers that always stay queued with the device: one that it fills and one that it turns to next. A frame whose buffer would be one of
/// them is copied instead of lent.
inline constexpr std::uint32_t kAlwaysQueued = 2;

/// What the user asks a camera for.
struct CaptureWish {
  std::string device = "/dev/video0";
  FourCc pixel_format = kYuyv;
  std::uint32_t width = 640, height = 480;
  std::uint32_t period_num = 1,
                period_den = 30;  ///< Time per frame in seconds, as a fraction. 0/x leaves the device's.
  FrameMemory memory = FrameMemory::Mapped;
  std::vector<int>
      imports{};  ///< With FrameMemory::Imported: dma-bufs of at least a frame's size, the caller's, open until close().
  bool export_frames = false;  ///< Each frame has a dma-buf for other devices. Only of mapped memory.
};

/// What the camera gives.
struct CaptureFormat {
  FourCc pixel_format = 0;
  std::uint32_t width = 0, height = 0;
  std::uint32_t bytes_per_line = 0;   ///< 0 for compressed frames.
  std::size_t frame_bytes = 0;        ///< Of a whole frame; the most that one takes if compressed.
  Duration frame_period{};            ///< Zero if the device does not say.
  bool fills_offered_memory = false;  ///< The port has no memory of its own: next() needs `offered`.
  std::optional<Pinhole> lens;        ///< Of a synthetic picture only.
  std::string camera_name;            ///< "hd_webcam": lower case, as in the names of calibration files.
  std::vector<std::string> remarks;   ///< One sentence per setting in which the device deviates from the request.
};

/// One picture.
struct Frame {
  ByteSpan bytes;            ///< As the device wrote them; in the offered memory or in the device's.
  ReleaseHook give_back{};   ///< Call it once when `bytes` is no longer used, from any thread. Null for offered memory.
  std::uint64_t sequence{};  ///< Counts the frames that were lost, too.
  std::uint64_t lost{};      ///< Frames missing right before this one.
  WallTime captured;         ///< When the sensor's exposure began (or ended, if the device says only that).
  WallTime received;         ///< When we got it.
  std::uint32_t
      spare_buffers{};  ///< Left with the device while this frame is out; lend the frame if more than kAlwaysQueued.
  int dma_buf = -1;     ///< Of this memory, imported or exported; valid until give_back. -1: none.

  /// Calls give_back, if there is one.
  void return_memory() const {
    if (give_back.release != nullptr) give_back.release(give_back.context);
  }
};

/// Why there is no frame.
enum class CaptureFault : std::uint8_t {
  NoFrame,  ///< The deadline passed, or interrupt() was called. The stream continues.
  Broken,   ///< The driver lost the stream: close(), then open() and start() again.
  Gone      ///< The device was pulled out: close(), then the same when it is back.
};
[[nodiscard]] const char* to_text(CaptureFault fault);

/// The driver delivered frames + damaged + torn; it lost `lost` frames itself. The counters survive close().
struct CaptureStats {
  std::uint64_t frames{};           ///< Handed out.
  std::uint64_t lost{};             ///< Gaps in the driver's count.
  std::uint64_t damaged{};          ///< Flagged as damaged by the driver, skipped.
  std::uint64_t torn{};             ///< Shorter than a frame, skipped.
  std::uint64_t starved{};          ///< Times when every buffer was with readers.
  std::uint64_t doubtful_stamps{};  ///< The driver's time made no sense; the time of receipt was taken.
};

/// A setting of the device (brightness, exposure...).
struct Control {
  std::uint32_t id{};
  std::string name;  ///< As v4l2_camera names its parameter: "power_line_frequency".
  bool is_switch{};  ///< A yes or no.
  bool read_only{};
  std::int64_t least{}, most{}, value{};
  std::uint64_t step{};
};

/// A camera, opened and streaming.
///
/// Order: open(), start(), next()..., close(). Frames may outlive all of that; their memory stays readable until the
/// hook was called.
/// Threads: one at a time, except interrupt() and set_control(): any. Allocates: next() nothing.
class CapturePort {
 public:
  CapturePort() = default;
  CapturePort(const CapturePort&) = delete;
  CapturePort& operator=(const CapturePort&) = delete;
  virtual ~CapturePort() = default;

  /// Opens the device and agrees on a format: the nearest that it has, with a remark where that is not the wish.
  /// Errors: a CameraFault (camera_fault.hpp).
  [[nodiscard]] virtual Result<CaptureFormat, Problem> open(const CaptureWish& wish) = 0;
  [[nodiscard]] virtual Result<void, Problem> start() = 0;
  /// Blocks until the next picture. Only ports with fills_offered_memory use `offered`, which must then hold frame_bytes.
  [[nodiscard]] virtual Result<Frame, CaptureFault> next(MonotonicTime deadline, ByteSpan offered) = 0;
  /// Makes a waiting next() return, or the next one if none waits.
  virtual void interrupt() noexcept = 0;
  /// Ends the stream and lets the device go. A closed port may be closed again.
  virtual void close() = 0;

  /// What can be set on the open device.
  [[nodiscard]] virtual std::vector<Control> controls() = 0;
  [[nodiscard]] virtual Result<void, Problem> set_control(const Control& control, std::int64_t value) = 0;
  [[nodiscard]] virtual CaptureStats stats() const = 0;
};

}  // namespace nacelle::camera
