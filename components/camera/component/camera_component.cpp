// SPDX-License-Identifier: Apache-2.0
#include "camera/component/camera_component.hpp"

#include <pthread.h>

#include <algorithm>
#include <filesystem>

#include "camera/component/calibration.hpp"
#include "camera/port/camera_fault.hpp"
#include "camera/port/pattern_source.hpp"
#include "camera/port/port_library.hpp"
#include "camera/port/v4l2_capture.hpp"
#include "nacelle/base/expect.hpp"
#include "nacelle/qos/presets.hpp"

namespace nacelle::camera {
namespace {

// The one place that chooses the real world.
std::unique_ptr<CapturePort> make_real_port(Source source, const Clock& clock) {
  if (source == Source::Pattern) return std::make_unique<PatternSource>(clock);
  if (source == Source::Libcamera) return make_port_of(port_library_path(kLibcamera), clock);
  return std::make_unique<V4l2Capture>(clock);
}

constexpr Duration kFaultAfter = 2s;  // with device_lost: fault
constexpr Duration kTurn = 100ms;     // how long the thread looks for a frame before it looks at anything else

}  // namespace

CameraComponent::CameraComponent(const NodeOptions& options) : CameraComponent(options, make_real_port) {}

CameraComponent::CameraComponent(const NodeOptions& options, PortMaker make_port)
    : LifecycleNode("camera", options), make_port_(std::move(make_port)), options_(declare_options(*this)) {
  declare_control_overrides();
  declare_frame_use(options_.camera_frame_id, "camera_frame_id");
  if (options_.video_device != kPattern) declare_device_use(options_.video_device, "video_device");
  if (const auto setup = validated(options_, get_fully_qualified_name()); !setup) declare_problem(setup.error());
  if (const auto device = read_device_parameters(*this); !device) declare_problem(device.error());
  if (const auto file = check_calibration(options_.camera_info_url); !file) declare_problem(file.error());
  on_set_ = add_on_set_parameters_callback(
      [this](const std::vector<Parameter>& parameters) { return set_controls(parameters); });
  images_ = create_publisher<sensor_msgs::msg::Image>("~/image_raw", SensorDataQoS(QoS(2)));
  if (is_jpeg(parse_fourcc(options_.pixel_format).value_or(0))) {
    compressed_ = create_publisher<sensor_msgs::msg::CompressedImage>("~/image_raw/compressed", SensorDataQoS(QoS(2)));
  }
  infos_ = create_publisher<sensor_msgs::msg::CameraInfo>("~/camera_info", SensorDataQoS(QoS(2)));
  using sensor_msgs::srv::SetCameraInfo;
  set_camera_info_ = create_service<SetCameraInfo>(
      "~/set_camera_info", [this](const SetCameraInfo::Request& request, SetCameraInfo::Response& response) {
        set_camera_info(request, response);
      });
}

CallbackReturn CameraComponent::on_configure(const State&) {
  auto setup = validated(options_, get_fully_qualified_name());
  if (!setup) return refuse(setup.error());
  // The device, which also asks for it, may be absent now.
  if (const auto file = check_calibration(options_.camera_info_url); !file) return refuse(file.error());
  const Source source = setup->source;
  CaptureLoop::Settings settings;
  settings.wish = setup->wish;
  if (source == Source::Pattern) settings.wish.pixel_format = setup->output->code;
  settings.output = setup->output;
  settings.frame_id = options_.camera_frame_id;
  settings.camera_info_url = options_.camera_info_url;
  settings.use_capture_time = options_.use_v4l2_buffer_timestamps;
  settings.stamp_offset = Duration{options_.timestamp_offset_ns};
  const auto device = read_device_parameters(*this);
  if (!device) return refuse(device.error());
  device_ = *device;
  port_ = make_port_(source, steady_clock());
  if (source != Source::Pattern) {
    // Its silence follows from the frame rate that the device agrees to.
    watch_ = std::make_unique<DeviceWatch>(
        *this, device_,
        DeviceWatch::Settings{.device = setup->wish.device, .fault_code = "CAMERA_SILENT", .fault_after = kFaultAfter},
        steady_clock().now());
  }
  loop_ = std::make_unique<CaptureLoop>(
      CaptureLoop::Surroundings{*port_, steady_clock(), get_logger(), *images_, *infos_, [this] { on_reopened(); },
                                watch_.get(), compressed_.get()},
      std::move(settings));
  if (auto opened = loop_->open(); !opened) {
    if (may_wait(source, setup->wish.device, opened.error())) {
      loop_->await_device(opened.error());
      waits_for_controls_ = true;
      late_controls_timer_ = create_wall_timer(kTurn, [this] { declare_late_controls(); });
      return CallbackReturn::SUCCESS;
    }
    let_go();
    return refuse(opened.error());
  }
  declare_controls(port_->controls());
  const CaptureFormat& format = loop_->format();
  get_logger().info("{}: {}x{} {} as {}", format.camera_name, format.width, format.height, to_text(format.pixel_format),
                    setup->output->encoding);
  return CallbackReturn::SUCCESS;
}

void CameraComponent::set_camera_info(const sensor_msgs::srv::SetCameraInfo::Request& request,
                                      sensor_msgs::srv::SetCameraInfo::Response& response) {
  NACELLE_EXPECT(loop_ != nullptr, "the host answers requests of active nodes only");
  const auto stored = loop_->set_calibration(request.camera_info);
  response.success = stored.has_value();
  response.status_message = stored ? "stored in " + *stored : stored.error().text();
  if (stored) {
    get_logger().info("calibration: {}", std::string_view{response.status_message});
  } else {
    get_logger().warn("calibration refused: {}", std::string_view{response.status_message});
  }
}

// Absent is not the same as unusable: rights, another program or a wrong node are not mended by waiting.
bool CameraComponent::may_wait(Source source, const std::string& device, const Problem& why) const {
  if (device_.required || source == Source::Pattern) return false;
  if (source == Source::Libcamera) return why.code == CameraFault::NotThere;
  std::error_code ignored;
  return !std::filesystem::exists(device, ignored);
}

void CameraComponent::on_reopened() {
  if (!waits_for_controls_) return apply_controls();
  *late_controls_.lock() = port_->controls();
  waits_for_controls_ = false;
}

void CameraComponent::declare_late_controls() {
  auto controls = std::exchange(*late_controls_.lock(), std::nullopt);
  if (!controls) return;
  late_controls_timer_->cancel();
  declare_controls(std::move(*controls));
}

CallbackReturn CameraComponent::on_activate(const State&) {
  // After a deactivation the device was released, so that other programs could use it.
  if (!loop_->is_open() && !loop_->is_awaiting()) {
    if (auto opened = loop_->open(); !opened) {
      const auto setup = validated(options_, get_fully_qualified_name());
      if (!setup || !may_wait(setup->source, options_.video_device, opened.error())) return refuse(opened.error());
      loop_->await_device(opened.error());
    } else {
      on_reopened();
    }
  }
  if (!loop_->is_awaiting()) {
    if (auto started = loop_->start(); !started) {
      loop_->close();
      return refuse(started.error());
    }
    if (watch_) watch_->heard(steady_clock().now());  // before, no frame was to come
  }
  {
    const LockGuard lock(mutex_);
    stop_ = false;
  }
  thread_ = std::thread([this] { run(); });
  return CallbackReturn::SUCCESS;
}

CallbackReturn CameraComponent::on_deactivate(const State&) {
  stop_thread();
  loop_->close();
  if (watch_) watch_->heard(steady_clock().now());  // the thread does not run until the next activation
  return CallbackReturn::SUCCESS;
}

CallbackReturn CameraComponent::on_cleanup(const State&) { return let_go(); }

CallbackReturn CameraComponent::let_go() {
  stop_thread();
  if (loop_) loop_->close();
  loop_.reset();
  watch_.reset();
  port_.reset();
  late_controls_timer_.reset();
  waits_for_controls_ = false;
  late_controls_.lock()->reset();
  undeclare_controls();
  return CallbackReturn::SUCCESS;
}

void CameraComponent::run() {
  pthread_setname_np(pthread_self(), "camera_rx");
  try {
    for (;;) {
      {
        const LockGuard lock{mutex_};
        if (stop_) return;
      }
      const auto turn = loop_->turn(steady_clock().now() + kTurn);
      if (turn == CaptureLoop::Turn::Outage && !pause_until(loop_->resume_at())) return;
    }
  } catch (const std::exception& problem) {
    // Out of memory, say: this thread ends here, and the host does the rest.
    fault("CAPTURE_FAILED", problem.what());
  }
}

bool CameraComponent::pause_until(MonotonicTime time) {
  UniqueLock lock{mutex_};
  return !stop_asked_.wait_for(lock.raw(), std::max(time - steady_clock().now(), Duration::zero()),
                               [this]() NACELLE_REQUIRES(mutex_) { return stop_; });
}

void CameraComponent::stop_thread() {
  if (!thread_.joinable()) return;
  {
    const LockGuard lock{mutex_};
    stop_ = true;
  }
  stop_asked_.notify_all();
  port_->interrupt();
  thread_.join();
}

}  // namespace nacelle::camera
