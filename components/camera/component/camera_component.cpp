// SPDX-License-Identifier: Apache-2.0
#include "camera/component/camera_component.hpp"

#include <pthread.h>

#include <algorithm>
#include <filesystem>

#include "camera/component/calibration.hpp"
#include "camera/port/pattern_source.hpp"
#include "camera/port/v4l2_capture.hpp"
#include "nacelle/qos/presets.hpp"

namespace nacelle::camera {
namespace {

// The one place that chooses the real world.
std::unique_ptr<CapturePort> make_real_port(Source source, const Clock& clock) {
  if (source == Source::Pattern) return std::make_unique<PatternSource>(clock);
  return std::make_unique<V4l2Capture>(clock);
}

constexpr Duration kTurn = 200ms;  // how long the thread looks for a frame before it looks at anything else

}  // namespace

CameraComponent::CameraComponent(const NodeOptions& options) : CameraComponent(options, make_real_port) {}

CameraComponent::CameraComponent(const NodeOptions& options, PortMaker make_port)
    : LifecycleNode("camera", options), make_port_(std::move(make_port)), options_(declare_options(*this)) {
  declare_control_overrides();
  declare_frame_use(options_.camera_frame_id, "camera_frame_id");
  if (options_.source != "pattern") declare_device_use(options_.video_device, "video_device");
  if (const auto setup = validated(options_, get_fully_qualified_name()); !setup) declare_problem(setup.error());
  if (const auto file = check_calibration(options_.camera_info_url); !file) declare_problem(file.error());
  add_on_set_parameters_callback([this](const std::vector<Parameter>& parameters) { return set_controls(parameters); });
  images_ = create_publisher<sensor_msgs::msg::Image>("~/image_raw", SensorDataQoS(QoS(2)));
  infos_ = create_publisher<sensor_msgs::msg::CameraInfo>("~/camera_info", SensorDataQoS(QoS(2)));
}

Source CameraComponent::choose_source(const CameraSetup& setup) const {
  if (setup.source != Source::Auto) return setup.source;
  std::error_code ignored;
  if (std::filesystem::exists(setup.wish.device, ignored)) return Source::V4l2;
  get_logger().warn(
      "no camera at {}: showing a pattern instead; set source to pattern to say that this is meant, or to v4l2 to "
      "require the camera",
      setup.wish.device);
  return Source::Pattern;
}

CallbackReturn CameraComponent::on_configure(const State&) {
  auto setup = validated(options_, get_fully_qualified_name());
  if (!setup) return refuse(setup.error());
  const Source source = choose_source(*setup);
  CaptureLoop::Settings settings;
  settings.wish = setup->wish;
  if (source == Source::Pattern) {
    settings.wish.device = "pattern";
    settings.wish.pixel_format = setup->output->code;
  }
  settings.output = setup->output;
  settings.frame_id = options_.camera_frame_id;
  settings.camera_info_url = options_.camera_info_url;
  settings.use_capture_time = options_.use_v4l2_buffer_timestamps;
  settings.stamp_offset = Duration{options_.timestamp_offset_ns};
  port_ = make_port_(source, get_clock());
  loop_ = std::make_unique<CaptureLoop>(
      CaptureLoop::Surroundings{*port_, get_clock(), get_logger(), *images_, *infos_, [this] { apply_controls(); }},
      std::move(settings));
  if (auto opened = loop_->open(); !opened) {
    let_go();
    return refuse(opened.error());
  }
  declare_controls();
  const CaptureFormat& format = loop_->format();
  get_logger().info("{}: {}x{} {} as {}", format.camera_name, format.width, format.height, to_text(format.pixel_format),
                    setup->output->encoding);
  return CallbackReturn::SUCCESS;
}

CallbackReturn CameraComponent::on_activate(const State&) {
  // After a deactivation the device was let go, so that others could use it.
  if (!loop_->is_open()) {
    if (auto opened = loop_->open(); !opened) return refuse(opened.error());
    apply_controls();
  }
  if (auto started = loop_->start(); !started) {
    loop_->close();
    return refuse(started.error());
  }
  stop_ = false;
  thread_ = std::thread([this] { run(); });
  return CallbackReturn::SUCCESS;
}

CallbackReturn CameraComponent::on_deactivate(const State&) {
  stop_thread();
  loop_->close();
  return CallbackReturn::SUCCESS;
}

CallbackReturn CameraComponent::on_cleanup(const State&) { return let_go(); }

CallbackReturn CameraComponent::let_go() {
  stop_thread();
  if (loop_) loop_->close();
  loop_.reset();
  port_.reset();
  undeclare_controls();
  return CallbackReturn::SUCCESS;
}

void CameraComponent::run() {
  pthread_setname_np(pthread_self(), "camera_rx");
  try {
    for (;;) {
      {
        const std::lock_guard lock{mutex_};
        if (stop_) return;
      }
      const auto turn = loop_->turn(get_clock().now() + kTurn);
      if (turn == CaptureLoop::Turn::Outage && !pause_until(loop_->resume_at())) return;
    }
  } catch (const std::exception& problem) {
    // Out of memory, say: this thread ends here, and the host does the rest.
    fault("CAPTURE_FAILED", problem.what());
  }
}

bool CameraComponent::pause_until(MonotonicTime time) {
  std::unique_lock lock{mutex_};
  return !stop_asked_.wait_for(lock, std::max(time - get_clock().now(), Duration::zero()), [this] { return stop_; });
}

void CameraComponent::stop_thread() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock{mutex_};
    stop_ = true;
  }
  stop_asked_.notify_all();
  port_->interrupt();
  thread_.join();
}

}  // namespace nacelle::camera
