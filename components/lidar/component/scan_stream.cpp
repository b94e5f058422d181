// SPDX-License-Identifier: Apache-2.0
#include "lidar/component/scan_stream.hpp"

#include <fmt/format.h>

#include <numbers>

#include "nacelle/io/serial_port.hpp"

namespace nacelle::lidar {
namespace {

/// A motor at rest reaches its speed in this time. Source: a second or two of the makers' drivers, and a margin.
constexpr Duration kSpinUp = 4s;

}  // namespace

ScanStream::ScanStream(const LidarOptions& options, const Clock& clock, io::ByteStream& line,
                       std::shared_ptr<Publisher<sensor_msgs::msg::LaserScan>> publisher, const Logger& logger,
                       DeviceWatch& watch)
    : options_(options),
      clock_(clock),
      byte_time_(io::byte_time(options.port_baudrate)),
      line_(line),
      publisher_(std::move(publisher)),
      logger_(logger),
      watch_(watch),
      protocol_(make_protocol(options)),
      arrival_(protocol_->knows_its_rate() ? io::ArrivalFilter::Steps::Steady : io::ArrivalFilter::Steps::Nominal),
      assembler_(options.scan) {}

void ScanStream::on_bytes(ByteView bytes, MonotonicTime received) {
  received_ = received;
  protocol_->feed(bytes, *this);
  converse(received);
  watch_silence(received);
}

void ScanStream::on_sweep(const Sweep& sweep, std::size_t bytes_after) {
  const Duration on_line = byte_time_ * static_cast<std::int64_t>(bytes_after + sweep.packet_bytes) + sweep.age;
  const MonotonicTime last_beam = arrival_.settle(received_, on_line, sweep.since_last);
  assembler_.add(sweep, last_beam, [this](const Scan& scan) { publish(scan); });
  watch_.heard(received_);
  patient_until_ = {};  // it measures: from now on silence is a loss
}

/// Does what the protocol asks for, and tells the waiting threads where that has got to.
void ScanStream::converse(MonotonicTime now) {
  const bool wanted = active_.load(std::memory_order_relaxed);
  if (std::exchange(wanted_, wanted) != wanted) {
    protocol_->want(wanted);
    if (wanted && protocol_->is_commanded()) patient_until_ = now + kSpinUp;
  }
  while (const auto action = protocol_->next_action(now)) {
    // A line that breaks says so at the next read.
    if (action->data_terminal_ready) static_cast<void>(line_.set_data_terminal_ready(*action->data_terminal_ready));
    if (!action->bytes.empty() && !line_.write(action->bytes)) break;
  }
  report();
}

void ScanStream::report() {
  const LockGuard lock{mutex_};
  // Not settled on what was wanted a moment ago.
  const bool is_settled = protocol_->is_settled() && wanted_ == active_.load(std::memory_order_relaxed);
  counters_ = {protocol_->stats(), assembler_.stats(), published_};
  const bool news = is_settled != is_settled_ || protocol_->refusal() != refusal_;
  is_settled_ = is_settled;
  if (!news) return;
  refusal_ = protocol_->refusal();
  identity_ = protocol_->identity();
  settled_.notify_all();
}

void ScanStream::publish(const Scan& scan) {
  if (!active_.load(std::memory_order_relaxed) || !arrival_.is_settled()) return;
  auto message = publisher_->borrow();
  if (!message) return;  // every pooled scan is still being read; the publisher counted it
  const auto points = static_cast<double>(scan.ranges_m.size());
  const double increment_rad = 2.0 * std::numbers::pi / points;
  // Both clocks are read here, so that a step of the wall clock cannot come between measuring and stamping.
  const WallTime stamp = clock_.wall_now() - (clock_.now() - scan.first_beam);
  message->header.stamp = stamp;
  message->header.frame_id = options_.frame_id;
  message->angle_min = 0.0F;
  message->angle_max = static_cast<float>(2.0 * std::numbers::pi - increment_rad);
  message->angle_increment = static_cast<float>(increment_rad);
  message->time_increment = static_cast<float>(to_seconds(scan.turn) / points);
  message->scan_time = static_cast<float>(to_seconds(scan.turn));
  message->range_min = static_cast<float>(options_.scan.range_min_m);
  message->range_max = static_cast<float>(options_.scan.range_max_m);
  message->ranges.assign(scan.ranges_m.begin(), scan.ranges_m.end());
  // Left empty where the device measures none, as the message's definition asks.
  message->intensities.assign(scan.intensities.begin(),
                              scan.has_intensities ? scan.intensities.end() : scan.intensities.begin());
  publisher_->publish(std::move(message));
  ++published_;
}

void ScanStream::watch_silence(MonotonicTime now) {
  // A device that we asked to be silent counts as present until its line breaks.
  const bool rests =
      !is_broken_ && protocol_->is_commanded() && (!wanted_ || now < patient_until_) && protocol_->refusal().empty();
  if (rests && (wanted_ || protocol_->is_settled())) watch_.heard(now);
  if (!protocol_->refusal().empty()) watch_.lose(protocol_->refusal());
  watch_.look(now, [this] {
    const LineStats line = protocol_->stats();
    return fmt::format("{} bytes came so far, {} frames, {} bad checksums", line.bytes, line.frames,
                       line.bad_checksums);
  });
}

void ScanStream::on_silence(MonotonicTime now) {
  converse(now);
  watch_silence(now);
}

void ScanStream::on_break(io::StreamFault fault, MonotonicTime) {
  is_broken_ = true;
  watch_.lose(std::string(io::explain(fault)));
  protocol_->restart();
  assembler_.restart();
  arrival_.restart();
}

void ScanStream::on_return(MonotonicTime now) {
  logger_.info("{}: the line is back", options_.port_name);
  is_broken_ = false;
  patient_until_ = now + kSpinUp;
  protocol_->restart();  // what was asked meanwhile was not heard
  converse(now);
}

void ScanStream::stop_device() {
  if (!protocol_->is_commanded()) return;
  active_.store(false, std::memory_order_relaxed);
  converse(clock_.now());
}

void ScanStream::set_active(bool active) {
  active_.store(active, std::memory_order_relaxed);
  if (!protocol_->is_commanded()) return;
  const LockGuard lock{mutex_};
  is_settled_ = false;  // until the reading thread has seen it
}

bool ScanStream::wait_until_settled(Duration limit) {
  UniqueLock lock{mutex_};
  return settled_.wait_for(lock.raw(), limit, [this]() NACELLE_REQUIRES(mutex_) {
    return is_settled_ || !refusal_.empty();
  }) && refusal_.empty();
}

std::string ScanStream::refusal() const {
  const LockGuard lock{mutex_};
  return refusal_;
}

std::string ScanStream::identity() const {
  const LockGuard lock{mutex_};
  return identity_;
}

LidarCounters ScanStream::counters() const {
  const LockGuard lock{mutex_};
  return counters_;
}

}  // namespace nacelle::lidar
