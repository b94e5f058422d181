// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/serial_base_port.hpp"

#include <fmt/format.h>

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
    case io::StreamFault::LineDown: return BaseFault::LineDown;
    case io::StreamFault::BusOff: return BaseFault::BusOff;
    default: return BaseFault::LineRefused;
  }
}

/// Ears for what was sent before the start.
class Deaf final : public BoardEars {
 public:
  void on_wheels(const WheelReading&, std::uint64_t) override {}
  void on_voltage(double) override {}
  void on_fault(const char*) override {}
};

}  // namespace

SerialBasePort::SerialBasePort(std::unique_ptr<io::ByteStream> line, std::unique_ptr<MotorBoard> board,
                               const Clock& clock, const Settings& settings)
    : line_(std::move(line)),
      board_(std::move(board)),
      clock_(clock),
      settings_(settings),
      travel_({max_wheel_rate(), settings.restart_slack_rad, board_->position_wrap_rad()}) {
  const ByteView separator = board_->separator();
  const ByteView stop = board_->stop_frame();
  safe_stop_bytes_ = separator.size() + stop.size();
  NACELLE_EXPECT(safe_stop_bytes_ <= safe_stop_.size(), "a stop frame fits into 64 bytes");
  std::copy(stop.begin(), stop.end(), std::copy(separator.begin(), separator.end(), safe_stop_.begin()));
}

double SerialBasePort::max_wheel_rate() const {
  return std::min(settings_.max_wheel_rate_rps, board_->max_wheel_rate());
}

Result<void, BaseFault> SerialBasePort::start() {
  // Bytes that waited in the line were sent before it was opened: their time of receipt would be wrong. A bounded
  // number of reads, so that a board that never pauses cannot hold us.
  Deaf deaf;
  for (int reads = 0; reads < 16; ++reads) {
    const auto bytes = line_->read_until({});
    if (!bytes) {
      // Reported before this start: the bus may be back since.
      const bool may_be_over = bytes.error() == io::StreamFault::BusOff || bytes.error() == io::StreamFault::LineDown;
      if (may_be_over && line_->reopen()) continue;
      return err(fault_of(bytes.error()));
    }
    if (bytes.value().empty()) break;
    received_at_ = clock_.now();
    feed(bytes.value(), deaf);
  }
  const std::uint64_t lost = board_->stats().lost;
  board_->restart();
  lost_before_ += board_->stats().lost - lost;  // half a frame, which says nothing
  travel_.pause();

  // The board may be in the middle of a frame that an earlier owner began.
  line_torn_ = true;
  if (const auto stopped = stop(); !stopped) return stopped;
  for (std::size_t i = 0;; ++i) {
    const ByteView frame = board_->setup_frame(i);
    if (frame.empty()) return {};
    if (const auto sent = send(frame); !sent) return sent;
  }
}

Result<void, BaseFault> SerialBasePort::reopen() {
  if (const auto opened = line_->reopen(); !opened) return err(fault_of(opened.error()));
  heard_ = {};  // another device may have been plugged in
  lost_before_ = board_->stats().lost;
  return start();
}

void SerialBasePort::feed(ByteView bytes, BoardEars& ears) {
  heard_.bytes += bytes.size();
  if (settings_.expected && !heard_.first.is_full()) heard_.first.add(bytes);
  board_->feed(bytes, received_at_, ears);
}

std::string SerialBasePort::why_no_state(Duration waited) const {
  if (!settings_.expected || heard_.frames > 0) return {};
  // It is the board, but a part of it says nothing, such as the second of two VESCs.
  const bool is_understood = heard_.bytes > 0 && board_->stats().lost == lost_before_;
  if (is_understood && io::recognise(heard_.first.view()) == nullptr) return {};
  const Problem why = io::why_no_frames(*settings_.expected, heard_, waited);
  return fmt::format("{}; {}", why.what, why.way_out);
}

void SerialBasePort::rest_until(MonotonicTime deadline) {
  static_cast<void>(io::wait_readable(-1, bell_, clock_, deadline));
}

Result<void, BaseFault> SerialBasePort::send_requests() {
  if (is_stuck_) return {};
  const ByteView request = board_->next_request(clock_.now());
  if (request.empty()) return {};
  const auto sent = send(request);
  // The next command finds the stuck line again, and counts it.
  if (!sent && sent.error() == BaseFault::LineStuck) return {};
  return sent;
}

Result<void, BaseFault> SerialBasePort::read_until(MonotonicTime deadline, WheelStateSink& sink) {
  const std::uint64_t before = stats_.states;
  // A chunk need not end a frame: go on until one does or the time is over.
  do {
    if (const auto asked = send_requests(); !asked) return asked;
    const auto bytes = line_->read_until(deadline);
    if (!bytes) return err(fault_of(bytes.error()));
    received_at_ = clock_.now();
    chunk_end_ = board_->stats().bytes + bytes.value().size();
    sink_ = &sink;
    if (!bytes.value().empty()) feed(bytes.value(), *this);
    board_->assume_wheels(received_at_, *this);
    sink_ = nullptr;
    if (bytes.value().empty()) return {};
  } while (stats_.states == before);
  return {};
}

void SerialBasePort::on_wheels(const WheelReading& reading, std::uint64_t first_byte) {
  // The board looked at its wheels before the first byte of this frame; those of later frames in the chunk came after it.
  const auto since = static_cast<std::int64_t>(chunk_end_ - first_byte);
  travel_.advance(reading, received_at_ - settings_.byte_time * since);
  ++stats_.states;
  ++heard_.frames;
  sink_->on_wheel_state({travel_.left_rad(), travel_.right_rad(), reading.rates, voltage_v_, travel_.captured_at()});
}

void SerialBasePort::on_fault(const char* fault) { sink_->on_board_fault(fault); }

Result<void, BaseFault> SerialBasePort::write(const WheelRates& rates) {
  const double most = max_wheel_rate();
  // A product a rounding above the limit is no wish for more than the board takes.
  const auto is_sendable = [most](double rate_rps) {
    return std::isfinite(rate_rps) && std::abs(rate_rps) <= most * (1.0 + 1e-9);
  };
  if (!is_sendable(rates.left_rps) || !is_sendable(rates.right_rps)) return err(BaseFault::NotSendable);
  const WheelRates within{std::clamp(rates.left_rps, -most, most), std::clamp(rates.right_rps, -most, most)};
  return send_command(board_->speed_frame(within), within, false);
}

Result<void, BaseFault> SerialBasePort::stop() { return send_command(board_->stop_frame(), {}, true); }

Result<void, BaseFault> SerialBasePort::send_command(ByteView frame, const WheelRates& rates, bool is_stop) {
  const bool waits = line_->unsent() > 0;
  const bool is_late = waits && clock_.now() > gone_by_ + kTakenWithin;
  is_stuck_ = is_late;
  // A slow line is still at the last one: this one's turn is the next cycle, so that no queue grows.
  if (waits && !is_late && (!is_stop || is_stopped_)) return {};
  // A pty does not report unsent bytes. Before the first of several stops, all of them are dropped.
  if (waits || (is_stop && !is_stopped_)) drop_unsent();
  const auto sent = send(frame);
  is_stopped_ = is_stop && sent;
  if (!sent) return sent;
  board_->on_commanded(clock_.now(), rates);
  ++stats_.commands;
  if (!is_late) return {};
  // The board, or the adapter, takes no bytes. Sent bytes stay in the queue meanwhile.
  ++stats_.stuck;
  return err(BaseFault::LineStuck);
}

void SerialBasePort::drop_unsent() {
  line_->drop_unsent();
  line_torn_ = true;
  gone_by_ = clock_.now();
}

Result<void, BaseFault> SerialBasePort::send(ByteView frame) {
  if (line_torn_) {
    if (const auto ended = line_->write(board_->separator()); !ended) return err(fault_of(ended.error()));
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

BasePort::Stats SerialBasePort::stats() const {
  Stats stats = stats_;
  stats.bytes_in = board_->stats().bytes;
  stats.bytes_lost = board_->stats().lost;
  stats.board_restarts = travel_.restarts();
  return stats;
}

}  // namespace nacelle::diff_drive
