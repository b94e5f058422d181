// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "camera/component/image_maker.hpp"
#include "camera/port/capture_port.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/io/backoff.hpp"
#include "nacelle/node/device_watch.hpp"
#include "nacelle/node/publisher.hpp"
#include "sensor_msgs/msg/camera_info.hpp"
#include "sensor_msgs/msg/compressed_image.hpp"
#include "sensor_msgs/msg/image.hpp"

namespace nacelle::camera {

/// Every frame of the port is published, not decoded, undecodable, or met no message (no_message also counts the wait for one).
struct CaptureLoopStats {
  std::uint64_t published{};    ///< Image and camera_info both.
  std::uint64_t compressed{};   ///< JPEGs published as they came, whether they were also decoded or not.
  std::uint64_t not_decoded{};  ///< JPEGs while nobody read the image.
  std::uint64_t adopted{};      ///< Of these: the reader sees the driver's own buffer.
  std::uint64_t copied{};       ///< Of these: copied, because readers hold all other buffers.
  std::uint64_t undecodable{};  ///< Broken JPEGs.
  std::uint64_t no_message{};   ///< The topic's pool was dry.
  std::uint64_t outages{};      ///< Times the stream broke.
  std::uint64_t returns{};      ///< Times it came back: outages, or one less while it is away.
};

/// From the port to the topics: one frame a turn, and the way back after a pulled cable.
///
/// It has no thread and waits only inside the port, so that a test can play any story.
/// Threads: turn() from one thread at a time, which the publishers belong to; stats() from any.
/// Allocates: nothing per frame.
class CaptureLoop {
 public:
  struct Settings {
    CaptureWish wish;
    const PixelFormat* output = nullptr;
    std::string frame_id;
    std::string camera_info_url;
    bool use_capture_time = true;
    Duration stamp_offset{};
    Duration first_pause = 100ms;  ///< Before the first attempt to open a lost device; doubles after each failure.
  };
  /// What the loop needs around it. All outlive it.
  struct Surroundings {
    CapturePort& port;
    const Clock& clock;
    const Logger& logger;
    Publisher<sensor_msgs::msg::Image>& images;
    Publisher<sensor_msgs::msg::CameraInfo>& infos;
    std::function<void()> on_reopened;  ///< Sets the controls again. Called before the stream starts.
    DeviceWatch* watch = nullptr;       ///< Is notified whether frames arrive; may be null.
    Publisher<sensor_msgs::msg::CompressedImage>* compressed = nullptr;  ///< For JPEGs as they come; may be null.
  };

  CaptureLoop(Surroundings surroundings, Settings settings)
      : around_(std::move(surroundings)), settings_(std::move(settings)), backoff_(settings_.first_pause) {}

  /// Opens the device, checks that its frames can be converted to the requested encoding, and logs the port's remarks.
  [[nodiscard]] Result<void, Problem> open();
  /// Threads: any.
  [[nodiscard]] bool is_open() const { return open_.load(std::memory_order_acquire); }
  [[nodiscard]] Result<void, Problem> start();
  /// Also ends the wait for an absent device.
  void close();
  /// Instead of open() and start(), for a device that is absent: turn() opens it when it is there.
  void await_device(const Problem& why);
  [[nodiscard]] bool is_awaiting() const { return away_; }

  enum class Turn : std::uint8_t { Frame, Nothing, Outage };
  /// Takes and publishes a frame if one comes before the deadline. While the device is away, attempts to open it when
  /// it is time to; the caller then waits until resume_at().
  Turn turn(MonotonicTime deadline);
  [[nodiscard]] MonotonicTime resume_at() const { return resume_at_; }

  /// Stores a calibration in the file of camera_info_url, and publishes it from the next frame on. Returns the file's path. Blocks
  /// until the disk has the file, the stream does not.
  /// Errors: as store_calibration(), and CalibrationFault::NoStream before the first open(); the earlier calibration stays.
  /// Threads: any.
  [[nodiscard]] Result<std::string, Problem> set_calibration(const sensor_msgs::msg::CameraInfo& info);

  [[nodiscard]] CaptureLoopStats stats() const { return *stats_.lock(); }
  [[nodiscard]] const CaptureFormat& format() const { return format_; }

 private:
  void publish(const Frame& frame);
  void publish_jpeg(const Frame& frame, const builtin_interfaces::msg::Time& stamp);
  void lose(CaptureFault fault);
  bool bring_back();
  void look_for_silence();

  Surroundings around_;
  const Settings settings_;
  CaptureFormat format_;
  std::unique_ptr<ImageMaker> maker_;
  Mutex calibration_;  ///< Held while the file is read or written, so that the two cannot cross.
  CaptureFormat calibrated_
      NACELLE_GUARDED_BY(calibration_);  ///< format_ for set_calibration(); no width: not known yet.
  Guarded<sensor_msgs::msg::CameraInfo> info_;
  Loan<sensor_msgs::msg::Image> image_;  ///< Borrowed before the frame comes, for ports that draw into it.
  std::atomic<bool> open_{false};
  bool away_ = false;
  bool said_why_ = false;
  MonotonicTime resume_at_;
  io::Backoff backoff_;
  Guarded<CaptureLoopStats> stats_;
};

}  // namespace nacelle::camera
