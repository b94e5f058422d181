// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_component.hpp"

#include <fmt/format.h>

#include <numbers>

#include "nacelle/io/line_signature.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::imu {
namespace {

Duration period_of(const ImuOptions& options) { return from_seconds(1.0 / options.rate_hz); }

/// How long configure waits for a sample of a device that is there. A slow one may need more than the limit for its first.
Duration patience_of(const ImuOptions& options) {
  return options.device.required ? Duration{options.silence_limit + 2 * period_of(options)}
                                 : silence_of(period_of(options));
}

Problem no_sample(const ImuOptions& options, const ImuCounters& counters, const io::FirstBytes& first) {
  const double seconds = to_seconds(patience_of(options));
  const auto& device = counters.device;
  if (device.frames == 0) {
    const io::ExpectedDevice expected{.path = options.port,
                                      .name = std::string{options.traits->name},
                                      .usual_baud = options.model == ImuModel::Wt901 ? 9600U : 115200U,
                                      .baud = options.baudrate,
                                      .baud_parameter = "baudrate",
                                      .when_silent = "is the IMU connected, and is this its line?"};
    return io::why_no_frames(expected, {device.bytes, device.frames, device.bad_checksums, first},
                             patience_of(options));
  }
  if (options.model != ImuModel::Wt901) {
    return {options.port, fmt::format("{} answers came in {:.1f} s, but no reading", device.frames, seconds),
            "the chip does not measure; take its power away for a moment"};
  }
  return {options.port, fmt::format("{} frames came in {:.1f} s, but no whole sample", device.frames, seconds),
          "the device must send 51 52 53 54 59: set configure_device, or its output with the maker's tool"};
}

std::string vector_text(const Vector3& v) { return fmt::format("({:.3f} {:.3f} {:.3f})", v[0], v[1], v[2]); }

}  // namespace

ImuComponent::ImuComponent(const NodeOptions& options) : ImuComponent(options, ImuPorts::real()) {}

ImuComponent::ImuComponent(const NodeOptions& options, ImuPorts ports)
    : LifecycleNode("imu", options), ports_(std::move(ports)) {
  declare_imu_parameters(*this);
  declare_frame_use(frame_name(*this, "frame_id"), "frame_id");
  const auto read = read_imu_parameters(*this);
  if (!read) declare_problem(read.error());
  const ImuOptions declared = read ? *read : ImuOptions{};
  // A bus is shared; a chip on it is not.
  const std::string port = get<std::string>("port");
  declare_device_use(declared.traits->is_on_i2c ? fmt::format("{} address 0x{:02x}", port, declared.address) : port,
                     "port");
  const QoS qos = QoS(10).best_effort();
  publishers_.raw = create_publisher<sensor_msgs::msg::Imu>("imu/data_raw", qos);
  if (declared.publish_orientation) publishers_.oriented = create_publisher<sensor_msgs::msg::Imu>("imu/data", qos);
  if (declared.traits->has_magnetometer)
    publishers_.field = create_publisher<sensor_msgs::msg::MagneticField>("imu/mag", qos);
  if (declared.traits->has_thermometer)
    publishers_.temperature = create_publisher<sensor_msgs::msg::Temperature>("imu/temperature", qos);
}

ImuComponent::~ImuComponent() { close(); }

bool ImuComponent::set_up_at_start(Problem& problem) {
  const auto set_up = device_.set_up();
  if (set_up) return true;
  problem =
      Problem{options_.port, fmt::format("the IMU cannot be set up: {}", set_up.error().what), set_up.error().way_out};
  // A chip that does not answer may come later; one that says that it is another never becomes the right one.
  const bool may_come = device_.polled != nullptr && set_up.error().fault != io::StreamFault::NotUsable;
  if (options_.device.required || !may_come) return false;
  device_.polled->start_away();
  watch_->lose(set_up.error().what);
  return true;
}

CallbackReturn ImuComponent::on_configure(const State&) {
  const auto options = read_imu_parameters(*this);
  if (!options) return refuse(options.error());
  options_ = *options;
  auto device = open_imu(options_, steady_clock(), ports_);
  if (!device) return refuse(device.error());
  device_ = std::move(device).value();
  calibrated_ = !options_.calibrate_gyro;
  watch_ = std::make_unique<DeviceWatch>(
      *this, options_.device,
      DeviceWatch::Settings{options_.port, silence_of(period_of(options_)), "IMU_SILENT", options_.silence_limit},
      steady_clock().now());
  if (Problem problem; !device_.line->is_away() && !set_up_at_start(problem)) {
    close();
    return refuse(problem);
  }
  stream_ = std::make_unique<ImuStream>(options_, *device_.reader, steady_clock(), publishers_, get_logger(), *watch_);
  const bool is_there = !device_.line->is_away();
  if (!is_there && !watch_->is_lost()) watch_->lose(std::string(io::explain(io::StreamFault::NotFound)));
  // Checking the line a few times per limit detects silence in time.
  const Duration look = std::min<Duration>(options_.silence_limit / 4 + Duration{1}, 100ms);
  reader_ = std::make_unique<io::ReaderThread>(
      *device_.line, steady_clock(), *stream_,
      io::ReaderThread::Options{.name = "imu_rx",
                                .silence = look,
                                .set_up =
                                    [this] {
                                      const auto done = device_.set_up();
                                      return done ? Result<void, io::StreamFault>{} : err(done.error().fault);
                                    },
                                .on_exception = [this](const std::string& text) { fault("READER_ENDED", text); }});
  if (!is_there || stream_->wait_for_sample(patience_of(options_))) return CallbackReturn::SUCCESS;
  // Bytes that are no samples come from another device, or at another speed: no wait mends that.
  const ImuCounters counters = stream_->counters();
  if (!options_.device.required && counters.device.bytes == 0) return CallbackReturn::SUCCESS;
  const Problem problem = no_sample(options_, counters, reader_->first_bytes());
  close();
  return refuse(problem);
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
  const RestFault& rest = bias.error();
  const std::string read =
      fmt::format("gyro {} rad/s, scatter {:.4f} rad/s; accelerometer {} m/s^2", vector_text(rest.mean_rps),
                  rest.stddev_rps, vector_text(rest.acceleration_mps2));
  switch (rest.fault) {
    case CalibrationFault::TooFewSamples:
      problem.what =
          fmt::format("fewer than {} samples came in {:.1f} s", options_.calibration_samples, to_seconds(limit));
      problem.way_out = "is the line disturbed? the counters are in the log";
      break;
    case CalibrationFault::Moving:
      problem.what = fmt::format("the robot moves: the gyro scatters by more than {} rad/s ({})",
                                 options_.calibration_max_stddev, read);
      break;
    case CalibrationFault::Turning:
      problem.what =
          fmt::format("the robot turns: the gyro shows more than {} rad/s ({})", options_.calibration_max_bias, read);
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
  device_ = {};
}

void ImuComponent::log_counters() const {
  const ImuCounters counters = stream_->counters();
  const auto& device = counters.device;
  get_logger().info(
      "{} samples published of {} ({} incomplete); {} bytes, {} frames, {} of other types, {} bad checksums, {} bytes "
      "skipped, {} transfers tried again; the line broke {} times",
      counters.published, device.samples, device.incomplete, device.bytes, device.frames, device.foreign_frames,
      device.bad_checksums, device.skipped_bytes, device_.polled == nullptr ? 0 : device_.polled->retries(),
      reader_->stats().breaks);
}

}  // namespace nacelle::imu
