// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/waveshare_serial_port.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nacelle/base/expect.hpp"

namespace nacelle::diff_drive {
namespace {

// For an adapter that collects bytes, and a thread that runs late.
constexpr Duration kTakenWithin = 10ms;

BaseFault fault_of(io::StreamFault fault) {
  switch (fault) {
    case io::StreamFault::HungUp:
    case io::StreamFault::NotFound: return BaseFault::LineLost;
    case io::StreamFault::WouldBlock: return BaseFault::LineStuck;
    default: return BaseFault::LineRefused;
  }
}

}  // namespace

WaveshareSerialPort::WaveshareSerialPort(std::unique_ptr<io::ByteStream> line, const Clock& clock, Settings settings)
    : line_(std::move(line)), clock_(clock), settings_(settings) {
  NACELLE_EXPECT(settings.wheel_radius_m > 0.0, "a wheel has a radius");
}

Result<void, BaseFault> WaveshareSerialPort::start() {
  // Bytes that waited in the line were sent before it was opened: their time of receipt would be wrong. A bounded
  // number of reads, so that a board that never pauses cannot hold us.
  for (int reads = 0; reads < 16; ++reads) {
    const auto bytes = line_->read_until({});
    if (!bytes) return err(fault_of(bytes.error()));
    if (bytes.value().empty()) break;
    decoder_.feed(bytes.value(), [](const BaseFeedback&) {});
  }
  decoder_.restart();
  told_bytes_ = decoder_.stats().feedback_bytes;
  has_state_ = false;

  // The board may be in the middle of a line that an earlier owner began.
  line_torn_ = true;
  if (const auto stopped = stop(); !stopped) return stopped;
  if (const auto sent = send(printer_.echo(false)); !sent) return sent;
  if (const auto sent = send(printer_.continuous_feedback(true)); !sent) return sent;
  if (settings_.motor_watchdog.count() > 0) return send(printer_.motor_watchdog(settings_.motor_watchdog));
  return {};
}

Result<void, BaseFault> WaveshareSerialPort::reopen() {
  if (const auto opened = line_->reopen(); !opened) return err(fault_of(opened.error()));
  return start();
}

void WaveshareSerialPort::rest_until(MonotonicTime deadline) {
  static_cast<void>(io::wait_readable(-1, bell_, clock_, deadline));
}

Result<void, BaseFault> WaveshareSerialPort::read_until(MonotonicTime deadline, WheelStateSink& sink) {
  const std::uint64_t before = stats_.states;
  // A chunk need not end a line: go on until one does or the time is over.
  do {
    const auto bytes = line_->read_until(deadline);
    if (!bytes) return err(fault_of(bytes.error()));
    if (bytes.value().empty()) return {};
    const MonotonicTime received_at = clock_.now();
    const std::uint64_t chunk_end = decoder_.stats().bytes + bytes.value().size();
    decoder_.feed(bytes.value(), [&](const BaseFeedback& feedback) {
      ++stats_.states;
      sink.on_wheel_state(to_wheel_state(feedback, capture_time(received_at, chunk_end)));
    });
  } while (stats_.states == before);
  return {};
}

Result<void, BaseFault> WaveshareSerialPort::write(const WheelRates& rates) {
  // A product a rounding above 2.0 m/s is no wish for more than the board takes.
  constexpr double kRounding_mps = 1e-9;
  const auto rim_mps = [this](double rate_rps) {
    const double mps = rate_rps * settings_.wheel_radius_m;
    const double limited = std::clamp(mps, -kWaveshareMaxWheelSpeed_mps, kWaveshareMaxWheelSpeed_mps);
    return std::abs(mps - limited) <= kRounding_mps ? limited : mps;
  };
  const auto frame = printer_.wheel_speeds(rim_mps(rates.left_rps), rim_mps(rates.right_rps));
  if (!frame) return err(BaseFault::NotSendable);
  return send_speed(frame.value());
}

Result<void, BaseFault> WaveshareSerialPort::stop() { return send_speed(kWaveshareStopFrame); }

Result<void, BaseFault> WaveshareSerialPort::send_speed(ByteView frame) {
  const bool is_stop = frame.data() == ByteView{kWaveshareStopFrame}.data();
  const bool waits = line_->unsent() > 0;
  const bool is_late = waits && clock_.now() > gone_by_ + kTakenWithin;
  // A slow line is still at the last one: this one's turn is the next cycle, so that no queue grows.
  if (waits && !is_late && (!is_stop || is_stopped_)) return {};
  // A pty does not report unsent bytes. Before the first of several stops, all of them are dropped.
  if (waits || (is_stop && !is_stopped_)) drop_unsent();
  const auto sent = send(frame);
  is_stopped_ = is_stop && sent;
  if (!sent) return sent;
  ++stats_.commands;
  if (!is_late) return {};
  // The board, or the adapter, takes no bytes. Sent bytes stay in the queue meanwhile.
  ++stats_.stuck;
  return err(BaseFault::LineStuck);
}

void WaveshareSerialPort::drop_unsent() {
  line_->drop_unsent();
  line_torn_ = true;
  gone_by_ = clock_.now();
}

Result<void, BaseFault> WaveshareSerialPort::send(ByteView frame) {
  if (line_torn_) {
    // Ends the line that was begun; the board drops it as no JSON.
    const std::uint8_t line_end = '\n';
    if (const auto ended = line_->write({&line_end, 1}); !ended) return err(fault_of(ended.error()));
    line_torn_ = false;
  }
  const auto sent = line_->write(frame);
  gone_by_ = std::max(gone_by_, clock_.now()) + settings_.byte_time * static_cast<std::int64_t>(frame.size());
  if (sent) return {};
  // Half a command must not be followed by the rest of the queue.
  if (sent.error() == io::StreamFault::WouldBlock) {
    ++stats_.stuck;
    line_->drop_unsent();
  }
  line_torn_ = true;
  return err(fault_of(sent.error()));
}

MonotonicTime WaveshareSerialPort::capture_time(MonotonicTime received_at, std::uint64_t chunk_end) {
  // The board looked at its wheels before the first byte of this line; those of later lines in the chunk came after it.
  const WaveshareLineDecoder::Stats& seen = decoder_.stats();
  const std::uint64_t since = (seen.feedback_bytes - told_bytes_) + (chunk_end - seen.bytes);
  told_bytes_ = seen.feedback_bytes;
  const MonotonicTime captured_at = received_at - settings_.byte_time * static_cast<std::int64_t>(since);
  return has_state_ ? std::max(captured_at, last_at_) : captured_at;
}

void WaveshareSerialPort::advance(const BaseFeedback& feedback, MonotonicTime captured_at) {
  const double elapsed_s = has_state_ ? to_seconds(captured_at - last_at_) : 0.0;
  if (!feedback.left_travel_m || !feedback.right_travel_m) {
    // The oldest firmware sends speeds only.
    total_.left_m += feedback.left_mps * elapsed_s;
    total_.right_m += feedback.right_mps * elapsed_s;
    return;
  }
  const Travel now{*feedback.left_travel_m, *feedback.right_travel_m};
  if (!has_state_) {
    // The first word of the board, or the first after a pause that may have seen anything: its count is the start.
    if (stats_.states <= 1) total_ = now;
    board_ = now;
    return;
  }
  // No wheel of this board gets that far in the time: the board was reset and counts from zero again.
  const double reach_m = 2.0 * kWaveshareMaxWheelSpeed_mps * elapsed_s + 0.1;
  const double left_m = now.left_m - board_.left_m;
  const double right_m = now.right_m - board_.right_m;
  board_ = now;
  if (std::abs(left_m) > reach_m || std::abs(right_m) > reach_m) {
    ++stats_.board_restarts;
    return;
  }
  total_.left_m += left_m;
  total_.right_m += right_m;
}

WheelState WaveshareSerialPort::to_wheel_state(const BaseFeedback& feedback, MonotonicTime captured_at) {
  advance(feedback, captured_at);
  has_state_ = true;
  last_at_ = captured_at;
  const double radius_m = settings_.wheel_radius_m;
  return {total_.left_m / radius_m,
          total_.right_m / radius_m,
          {feedback.left_mps / radius_m, feedback.right_mps / radius_m},
          feedback.voltage_v,
          captured_at};
}

BasePort::Stats WaveshareSerialPort::stats() const {
  Stats stats = stats_;
  stats.bytes_in = decoder_.stats().bytes;
  stats.bytes_lost = decoder_.stats().malformed_bytes + decoder_.stats().overlong_bytes;
  return stats;
}

}  // namespace nacelle::diff_drive
