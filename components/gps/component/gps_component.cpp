// SPDX-License-Identifier: Apache-2.0
#include "gps/component/gps_component.hpp"

#include <fmt/format.h>

#include "nacelle/io/line_signature.hpp"
#include "nacelle/io/serial_port.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::gps {
namespace {

Result<std::unique_ptr<io::ByteStream>, Problem> open_serial(const GpsOptions& options, const Clock& clock) {
  const io::SerialSettings settings{options.port, options.baud};
  auto port = options.device.required ? io::SerialPort::open(settings, clock, options.port_timeout)
                                      : io::SerialPort::open_or_await(settings, clock);
  if (!port) return err(std::move(port).error());
  return std::unique_ptr<io::ByteStream>{std::move(port).value()};
}

constexpr Duration kPeriod = 1s;  // until the receiver's own is known

/// How long configure waits for a sentence of a device that is there. The first burst may be torn.
Duration patience_of(const GpsOptions& options) {
  return options.device.required ? options.silence_limit : std::min<Duration>(options.silence_limit, kPeriod * 3 / 2);
}

Problem no_sentence(const GpsOptions& options, const GpsCounters& counters, const io::FirstBytes& first) {
  const io::ExpectedDevice expected{
      .path = options.port,
      .name = "NMEA 0183",
      .usual_baud = 9600,
      .baud = options.baud,
      .baud_parameter = "baud",
      .when_silent = "is the receiver powered, and is this its line?",
      .otherwise =
          fmt::format("is it another device, another speed (baud is {}; 4800, 38400 and 115200 are usual too), or "
                      "set to a binary protocol?",
                      options.baud)};
  const io::HeardOnLine heard{counters.line.bytes, counters.line.sentences, counters.line.bad_checksums, first};
  return io::why_no_frames(expected, heard, patience_of(options));
}

}  // namespace

GpsComponent::GpsComponent(const NodeOptions& options) : GpsComponent(options, open_serial) {}

GpsComponent::GpsComponent(const NodeOptions& options, OpenLine open_line)
    : LifecycleNode("gps", options), open_line_(std::move(open_line)) {
  declare_gps_parameters(*this);
  declare_frame_use(frame_name(*this, "frame_id"), "frame_id");
  declare_device_use(get<std::string>("port"), "port");
  if (const auto read = read_gps_parameters(*this); !read) declare_problem(read.error());
  publishers_.fix = create_publisher<sensor_msgs::msg::NavSatFix>("fix", QoS(10));
  publishers_.velocity = create_publisher<geometry_msgs::msg::TwistStamped>("vel", QoS(10));
  publishers_.time = create_publisher<sensor_msgs::msg::TimeReference>("time_reference", QoS(10));
}

GpsComponent::~GpsComponent() { close(); }

CallbackReturn GpsComponent::on_configure(const State&) {
  const auto options = read_gps_parameters(*this);
  if (!options) return refuse(options.error());
  auto line = open_line_(*options, steady_clock());
  if (!line) return refuse(line.error());
  line_ = std::move(line).value();
  watch_ = std::make_unique<DeviceWatch>(
      *this, options->device,
      DeviceWatch::Settings{options->port, silence_of(kPeriod), "GPS_SILENT", options->silence_limit},
      steady_clock().now());
  stream_ = std::make_unique<GpsStream>(*options, steady_clock(), publishers_, get_logger(), *watch_);
  const bool is_there = !line_->is_away();
  if (!is_there) watch_->lose(std::string(io::explain(io::StreamFault::NotFound)));
  // Checking the line a few times per limit detects silence in time.
  const Duration look = std::min<Duration>(options->silence_limit / 4 + Duration{1}, 100ms);
  reader_ = std::make_unique<io::ReaderThread>(
      *line_, steady_clock(), *stream_,
      io::ReaderThread::Options{.name = "gps_rx", .silence = look, .on_exception = [this](const std::string& text) {
                                  fault("READER_ENDED", text);
                                }});
  if (!is_there || stream_->wait_for_sentence(patience_of(*options))) return CallbackReturn::SUCCESS;
  // Bytes that are no sentences come from another device, or at another speed: no wait mends that.
  const GpsCounters counters = stream_->counters();
  if (!options->device.required && counters.line.bytes == 0) return CallbackReturn::SUCCESS;
  const Problem problem = no_sentence(*options, counters, reader_->first_bytes());
  close();
  return refuse(problem);
}

CallbackReturn GpsComponent::on_activate(const State&) {
  stream_->set_active(true);
  return CallbackReturn::SUCCESS;
}

CallbackReturn GpsComponent::on_deactivate(const State&) {
  stream_->set_active(false);
  log_counters();
  return CallbackReturn::SUCCESS;
}

CallbackReturn GpsComponent::on_cleanup(const State&) {
  close();
  return CallbackReturn::SUCCESS;
}

CallbackReturn GpsComponent::on_shutdown(const State&) {
  close();
  return CallbackReturn::SUCCESS;
}

CallbackReturn GpsComponent::on_error(const State&) {
  if (stream_) log_counters();
  close();
  return CallbackReturn::SUCCESS;
}

void GpsComponent::close() {
  reader_.reset();
  stream_.reset();
  watch_.reset();
  line_.reset();
}

void GpsComponent::log_counters() const {
  const GpsCounters counters = stream_->counters();
  get_logger().info(
      "{} fixes published; {} bytes, {} sentences ({} of other kinds, {} malformed), {} bad checksums, {} broken, {} "
      "bytes "
      "skipped; the line broke {} times",
      counters.published, counters.line.bytes, counters.line.sentences, counters.other, counters.malformed,
      counters.line.bad_checksums, counters.line.broken, counters.line.skipped_bytes, reader_->stats().breaks);
}

}  // namespace nacelle::gps
