// SPDX-License-Identifier: Apache-2.0
#include "lidar/component/lidar_component.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "nacelle/io/line_signature.hpp"
#include "nacelle/io/serial_port.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::lidar {
namespace {

Result<std::unique_ptr<io::ByteStream>, Problem> open_serial(const LidarOptions& options, const Clock& clock) {
  const io::SerialSettings settings{options.port_name, options.port_baudrate};
  auto port = options.device.required ? io::SerialPort::open(settings, clock, options.port_timeout)
                                      : io::SerialPort::open_or_await(settings, clock);
  if (!port) return err(std::move(port).error());
  return std::unique_ptr<io::ByteStream>{std::move(port).value()};
}

constexpr Duration kTurn = 100ms;  // most LiDARs turn at 10 Hz
/// A device answers within milliseconds; one that the host's adapter has just powered needs more.
constexpr Duration kConversation = 5s;
/// A stop is two short writes.
constexpr Duration kStop = 500ms;

/// How long configure waits for a device that is there: for a frame, or for its answers.
Duration patience_of(const LidarOptions& options, bool is_commanded) {
  if (is_commanded) return std::max(options.silence_limit, kConversation);
  return options.device.required ? options.silence_limit : silence_of(kTurn);
}

Problem no_frame(const LidarOptions& options, bool is_commanded, const LidarCounters& counters,
                 const io::FirstBytes& first) {
  const io::ExpectedDevice expected{.path = options.port_name,
                                    .name = std::string{options.model.name},
                                    .usual_baud = options.model.baud,
                                    .baud = options.port_baudrate,
                                    .baud_parameter = "port_baudrate",
                                    .when_silent = is_commanded
                                                       ? "is the LiDAR powered, and is this its line?"
                                                       : "is the LiDAR powered and turning, and is this its line?"};
  const io::HeardOnLine heard{counters.line.bytes, counters.line.frames, counters.line.bad_checksums, first};
  return io::why_no_frames(expected, heard, patience_of(options, is_commanded));
}

}  // namespace

LidarComponent::LidarComponent(const NodeOptions& options) : LidarComponent(options, open_serial) {}

LidarComponent::LidarComponent(const NodeOptions& options, OpenLine open_line)
    : LifecycleNode("lidar", options), open_line_(std::move(open_line)) {
  declare_lidar_parameters(*this);
  declare_frame_use(frame_name(*this, "frame_id"), "frame_id");
  declare_device_use(get<std::string>("port_name"), "port_name");
  if (const auto read = read_lidar_parameters(*this); !read) declare_problem(read.error());
  publisher_ = create_publisher<sensor_msgs::msg::LaserScan>(get<std::string>("topic_name"), QoS(5).best_effort());
}

LidarComponent::~LidarComponent() { close(); }

CallbackReturn LidarComponent::on_configure(const State&) {
  const auto options = read_lidar_parameters(*this);
  if (!options) return refuse(options.error());
  auto line = open_line_(*options, steady_clock());
  if (!line) return refuse(line.error());
  line_ = std::move(line).value();
  watch_ = std::make_unique<DeviceWatch>(
      *this, options->device,
      DeviceWatch::Settings{options->port_name, silence_of(kTurn), "LIDAR_SILENT", options->silence_limit},
      steady_clock().now());
  stream_ = std::make_unique<ScanStream>(*options, steady_clock(), *line_, publisher_, get_logger(), *watch_);
  const bool is_there = !line_->is_away();
  if (!is_there) watch_->lose(std::string(io::explain(io::StreamFault::NotFound)));
  if (is_there) stream_->begin();
  // Checking the line a few times per limit detects silence in time.
  const Duration look = std::min<Duration>(options->silence_limit / 4 + Duration{1}, 100ms);
  reader_ = std::make_unique<io::ReaderThread>(
      *line_, steady_clock(), *stream_,
      io::ReaderThread::Options{.name = "lidar_rx", .silence = look, .on_exception = [this](const std::string& text) {
                                  fault("READER_ENDED", text);
                                }});
  const bool is_commanded = stream_->is_commanded();
  if (!is_there) return CallbackReturn::SUCCESS;
  if (stream_->wait_until_settled(patience_of(*options, is_commanded))) {
    if (const std::string identity = stream_->identity(); !identity.empty())
      get_logger().info("{}: {}", options->port_name, identity);
    return CallbackReturn::SUCCESS;
  }
  // Bytes that are no frames come from another device, or at another speed: no wait mends that.
  const LidarCounters counters = stream_->counters();
  const std::string refusal = stream_->refusal();
  if (refusal.empty() && !options->device.required && counters.line.bytes == 0) return CallbackReturn::SUCCESS;
  const Problem problem =
      refusal.empty() ? no_frame(*options, is_commanded, counters, reader_->first_bytes())
                      : Problem{options->port_name, refusal, "see docs/hardware.md; a power cycle clears its faults"};
  close();
  return refuse(problem);
}

CallbackReturn LidarComponent::on_activate(const State&) {
  stream_->set_active(true);
  line_->interrupt();  // a commanded device is started at once
  return CallbackReturn::SUCCESS;
}

CallbackReturn LidarComponent::on_deactivate(const State&) {
  stream_->set_active(false);
  line_->interrupt();
  // The request to stop also goes to a silent device: perhaps only its answers are lost.
  if (stream_->is_commanded() && !stream_->wait_until_settled(kStop) && !watch_->is_lost())
    get_logger().warn("the LiDAR was not seen to stop: it may still turn");
  log_counters();
  return CallbackReturn::SUCCESS;
}

CallbackReturn LidarComponent::on_cleanup(const State&) {
  close();
  return CallbackReturn::SUCCESS;
}

CallbackReturn LidarComponent::on_shutdown(const State&) {
  close();
  return CallbackReturn::SUCCESS;
}

CallbackReturn LidarComponent::on_error(const State&) {
  if (stream_) log_counters();
  close();
  return CallbackReturn::SUCCESS;
}

void LidarComponent::close() {
  reader_.reset();
  if (stream_) stream_->stop_device();
  stream_.reset();
  watch_.reset();
  line_.reset();
}

void LidarComponent::log_counters() const {
  const LidarCounters counters = stream_->counters();
  const auto reader = reader_->stats();
  get_logger().info(
      "{} scans published of {} turns ({} dropped); {} bytes, {} frames, {} implausible, {} bad checksums, {} bytes "
      "skipped; the line broke {} times",
      counters.published, counters.turns.scans, counters.turns.dropped_turns, counters.line.bytes, counters.line.frames,
      counters.line.implausible, counters.line.bad_checksums, counters.line.skipped_bytes, reader.breaks);
}

}  // namespace nacelle::lidar
