// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_component.hpp"

#include <fmt/format.h>

#include <numbers>
#include <thread>

#include "nacelle/io/serial_port.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::imu {
namespace {

Result<std::unique_ptr<io::ByteStream>, Problem> open_serial(const ImuOptions& options, const Clock& clock) {
  const io::SerialSettings settings{options.port, options.baudrate};
  auto port = options.device.required ? io::SerialPort::open(settings, clock, options.port_timeout)
                                      : io::SerialPort::open_or_await(settings, clock);
  if (!port) return err(std::move(port).error());
  return std::unique_ptr<io::ByteStream>{std::move(port).value()};
}

Duration period_of(const ImuOptions& options) { return from_seconds(1.0 / options.rate_hz); }

/// How long configure waits for a sample of a device that is there. A slow one may need more than the limit for its first.
Duration patience_of(const ImuOptions& options) {
  return options.device.required ? Duration{options.silence_limit + 2 * period_of(options)}
                                 : silence_of(period_of(options));
}

Problem no_sample(const ImuOptions& options, const ImuCounters& counters) {
  const double seconds = to_seconds(patience_of(options));
  if (counters.line.bytes == 0) {
    return {options.port, fmt::format("nothing came in {:.1f} s", seconds),
            "is the IMU connected, and is this its line?"};
  }
  if (counters.line.frames == 0) {
    return {options.port, fmt::format("{} bytes came in {:.1f} s, but no WT901 frame", counters.line.bytes, seconds),
            fmt::format("is it another device, or another speed? baudrate is {}, a new WT901 speaks 9600",
                        options.baudrate)};
  }
  return {options.port, fmt::format("{} frames came in {:.1f} s, but no whole sample", counters.line.frames, seconds),
          "the device must send 51 52 53 54 59: set configure_device, or its output with the maker's tool"};
}

}  // namespace

ImuComponent::ImuComponent(const NodeOptions& options) : ImuComponent(options, open_serial) {}

ImuComponent::ImuComponent(const NodeOptions& options, OpenLine open_line)
    : LifecycleNode("imu", options), open_line_(std::move(open_line)) {
  declare_imu_parameters(*this);
  declare_frame_use(frame_name(*this, "frame_id"), "frame_id");
  declare_device_use(get<std::string>("port"), "port");
  if (const auto read = read_imu_parameters(*this); !read) declare_problem(read.error());
  const QoS qos = QoS(10).best_effort();
  publishers_.raw = create_publisher<sensor_msgs::msg::Imu>("imu/data_raw", qos);
  publishers_.oriented = create_publisher<sensor_msgs::msg::Imu>("imu/data", qos);
  publishers_.field = create_publisher<sensor_msgs::msg::MagneticField>("imu/mag", qos);
}

ImuComponent::~ImuComponent() { close(); }

CallbackReturn ImuComponent::on_configure(const State&) {
  const auto options = read_imu_parameters(*this);
  if (!options) return refuse(options.error());
  options_ = *options;
  auto line = open_line_(options_, steady_clock());
  if (!line) return refuse(line.error());
  line_ = std::move(line).value();
  const bool is_there = !line_->is_away();
  if (const auto set_up = is_there ? set_up_device() : Result<void, io::StreamFault>{}; !set_up) {
    close();
    return refuse(Problem{options_.port, fmt::format("the IMU cannot be set up: {}", io::explain(set_up.error())),
                          "is it connected?"});
  }
  calibrated_ = !options_.calibrate_gyro;
  watch_ = std::make_unique<DeviceWatch>(
      *this, options_.device,
      DeviceWatch::Settings{options_.port, silence_of(period_of(options_)), "IMU_SILENT", options_.silence_limit},
      steady_clock().now());
  stream_ = std::make_unique<ImuStream>(options_, steady_clock(), publishers_, get_logger(), *watch_);
  if (!is_there) watch_->lose(std::string(io::explain(io::StreamFault::NotFound)));
  // Checking the line a few times per limit detects silence in time.
  const Duration look = std::min<Duration>(options_.silence_limit / 4 + Duration{1}, 100ms);
  reader_ = std::make_unique<io::ReaderThread>(
      *line_, steady_clock(), *stream_,
      io::ReaderThread::Options{.name = "imu_rx",
                                .silence = look,
                                .set_up = [this] { return set_up_device(); },
                                .on_exception = [this](const std::string& text) { fault("READER_ENDED", text); }});
  if (!is_there || stream_->wait_for_sample(patience_of(options_))) return CallbackReturn::SUCCESS;
  // Bytes that are no samples come from another device, or at another speed: no wait mends that.
  const ImuCounters counters = stream_->counters();
  if (!options_.device.required && counters.line.bytes == 0) return CallbackReturn::SUCCESS;
  const Problem problem = no_sample(options_, counters);
  close();
  return refuse(problem);
}

Result<void, io::StreamFault> ImuComponent::set_up_device() {
  if (!options_.configure_device) return {};
  // Not saved: the settings are given at every start, and the device's flash wears.
  for (const Wt901Command& command : {unlock_command(), mask_command(kOutputMask), *rate_command(options_.rate_hz)}) {
    if (auto written = line_->write(command); !written) return written;
    if (options_.command_pause > Duration::zero()) std::this_thread::sleep_for(options_.command_pause);
  }
  return {};
}

Result<void, Problem> ImuComponent::calibrate() {
  // Room for one that was spoilt by a last movement, and for the rest that follows it.
  const Duration limit =
      2 * from_seconds(static_cast<double>(options_.calibration_samples) / options_.rate_hz) + options_.silence_limit;
  const auto bias = stream_->take_calibration(limit);
  const double deg = 180.0 / std::numbers::pi;
  if (bias) {
    calibrated_ = true;
    get_logger().info("gyro bias {:.3f} {:.3f} {:.3f} deg/s, scatter {:.3f} deg/s over {} samples",
                      bias->mean_rps[0] * deg, bias->mean_rps[1] * deg, bias->mean_rps[2] * deg, bias->stddev_rps * deg,
                      options_.calibration_samples);
    return {};
  }
  Problem problem{"gyro calibration", "", "keep the robot still and activate again, or set calibrate_gyro to false"};
  switch (bias.error()) {
    case CalibrationFault::TooFewSamples:
      problem.what =
          fmt::format("fewer than {} samples came in {:.1f} s", options_.calibration_samples, to_seconds(limit));
      problem.way_out = "is the line disturbed? the counters are in the log";
      break;
    case CalibrationFault::Moving:
      problem.what =
          fmt::format("the robot moves: the gyro scatters by more than {} rad/s", options_.calibration_max_stddev);
      break;
    case CalibrationFault::Turning:
      problem.what = fmt::format("the robot turns: the gyro shows more than {} rad/s", options_.calibration_max_bias);
      break;
  }
  return err(problem);
}

CallbackReturn ImuComponent::on_activate(const State&) {
  const bool may_be_absent = !options_.device.required && options_.device.lost == DeviceLost::Wait;
  if (!calibrated_ && !(may_be_absent && watch_->is_lost())) {
    // It may also go away meanwhile.
    if (const auto calibrated = calibrate(); !calibrated && !(may_be_absent && watch_->is_lost()))
      return refuse(calibrated.error());
  }
  if (!calibrated_) stream_->calibrate_later();
  stream_->set_active(true);
  return CallbackReturn::SUCCESS;
}

CallbackReturn ImuComponent::on_deactivate(const State&) {
  stream_->set_active(false);
  log_counters();
  return CallbackReturn::SUCCESS;
}

CallbackReturn ImuComponent::on_cleanup(const State&) {
  close();
  return CallbackReturn::SUCCESS;
}

CallbackReturn ImuComponent::on_shutdown(const State&) {
  close();
  return CallbackReturn::SUCCESS;
}

CallbackReturn ImuComponent::on_error(const State&) {
  if (stream_) log_counters();
  close();
  return CallbackReturn::SUCCESS;
}

void ImuComponent::close() {
  reader_.reset();
  stream_.reset();
  watch_.reset();
  line_.reset();
}

void ImuComponent::log_counters() const {
  const ImuCounters counters = stream_->counters();
  const auto reader = reader_->stats();
  get_logger().info(
      "{} samples published of {} ({} incomplete); {} bytes, {} frames, {} of other types, {} bad checksums, {} bytes "
      "skipped; the "
      "line broke {} times",
      counters.published, counters.samples.samples, counters.samples.incomplete, counters.line.bytes,
      counters.line.frames, counters.samples.foreign_frames, counters.line.bad_checksums, counters.line.skipped_bytes,
      reader.breaks);
}

}  // namespace nacelle::imu
