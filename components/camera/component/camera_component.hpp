// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "camera/component/camera_options.hpp"
#include "camera/component/capture_loop.hpp"
#include "camera/port/capture_port.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "sensor_msgs/srv/set_camera_info.hpp"

namespace nacelle::camera {

/// Publishes the images of a V4L2 camera, of one of libcamera, or a test pattern (video_device: pattern), on ~/image_raw and
/// ~/camera_info.
/// Serves ~/set_camera_info while active, as camera_info_manager does.
///
/// JPEGs (pixel_format MJPG or JPEG) are also published as they come, on ~/image_raw/compressed, and decoded while ~/image_raw has a reader.
/// Parameters have v4l2_camera's names (camera_options.hpp), one more per control of the device. on_configure opens the
/// device and agrees on a format, on_activate streams: the thread "camera_rx" captures and publishes. A pulled cable
/// or an absent device does not end it (DEVICE_LOST, an open fault): the thread waits for the device and continues.
/// With output_encoding equal to what the camera sends, Image.data is the driver's buffer; its release hook is code of
/// this library, which therefore stays loaded while such an image lives.
/// Frame:   headers are in camera_frame_id, the optical frame.
/// Threads: the component's executor.
class CameraComponent final : public LifecycleNode {
 public:
  /// Makes the port for a source (V4l2, Libcamera or Pattern).
  using PortMaker = std::function<std::unique_ptr<CapturePort>(Source, const Clock&)>;

  explicit CameraComponent(const NodeOptions& options);
  CameraComponent(const NodeOptions& options, PortMaker make_port);
  ~CameraComponent() override { stop_thread(); }

  /// Zeros while unconfigured.
  [[nodiscard]] CaptureLoopStats stats() const { return loop_ ? loop_->stats() : CaptureLoopStats{}; }

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;
  CallbackReturn on_shutdown(const State&) override { return let_go(); }
  CallbackReturn on_error(const State&) override { return let_go(); }

 private:
  void declare_control_overrides();
  void declare_controls(std::vector<Control> controls);
  void on_reopened();
  /// The controls of a device that came late, declared on the executor.
  void declare_late_controls();
  /// Whether waiting for the device may help after open() failed.
  [[nodiscard]] bool may_wait(Source source, const std::string& device, const Problem& why) const;
  void undeclare_controls();
  void apply_controls();
  SetParametersResult set_controls(const std::vector<Parameter>& parameters);
  void set_camera_info(const sensor_msgs::srv::SetCameraInfo::Request& request,
                       sensor_msgs::srv::SetCameraInfo::Response& response);
  CallbackReturn let_go();
  void run();
  void stop_thread();
  bool pause_until(MonotonicTime time);

  const PortMaker make_port_;
  const CameraOptions options_;
  std::vector<std::string>
      given_controls_;  ///< Overrides that are no parameter of ours: controls of the device, presumably.
  std::vector<std::string> found_controls_;  ///< Declared while configured.
  std::vector<Control> controls_;
  Guarded<std::vector<std::pair<Control, std::int64_t>>>
      chosen_;  ///< What was set, for the next time the device opens.
  std::shared_ptr<Publisher<sensor_msgs::msg::Image>> images_;
  std::shared_ptr<Publisher<sensor_msgs::msg::CompressedImage>> compressed_;  ///< Null if no JPEGs are asked for.
  std::shared_ptr<Publisher<sensor_msgs::msg::CameraInfo>> infos_;
  std::shared_ptr<Service<sensor_msgs::srv::SetCameraInfo>> set_camera_info_;
  OnSetParametersCallbackHandle::SharedPtr on_set_;
  DeviceOptions device_;
  std::unique_ptr<DeviceWatch> watch_;  ///< Null: of a pattern.
  std::unique_ptr<CapturePort> port_;
  std::unique_ptr<CaptureLoop> loop_;
  std::atomic<bool> waits_for_controls_{false};
  Guarded<std::optional<std::vector<Control>>> late_controls_;
  std::shared_ptr<Timer> late_controls_timer_;  ///< While the device was not there yet.
  Mutex mutex_;
  std::condition_variable stop_asked_;
  bool stop_ NACELLE_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace nacelle::camera
