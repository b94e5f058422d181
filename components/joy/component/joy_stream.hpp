// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <sensor_msgs/msg/joy.hpp>

#include "joy/component/joy_options.hpp"
#include "joy/port/pad_port.hpp"
#include "joy/protocol/input_event.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/io/reader_thread.hpp"

namespace nacelle::joy {

/// What the reading thread counted.
struct JoyCounters {
  InputEventDecoder::Stats line{};
  std::uint64_t groups{};     ///< Events of one moment, ended by SYN_REPORT.
  std::uint64_t overruns{};   ///< Times that the kernel dropped events (SYN_DROPPED) and the state was read anew.
  std::uint64_t published{};  ///< Messages, of which ...
  std::uint64_t neutral{};    ///< ... so many said that the pad was lost or the node deactivated.
};

/// From events to published messages, on the reading thread.
///
/// A message of a change is stamped with the kernel's time of its events, a repeated one with the time of publication. When the pad is lost,
/// or the node deactivated, one message with all buttons up and all axes 0 is published, and nothing after it.
/// Allocates: nothing while the pad is there, once the publisher's messages have their size.
class JoyStream final : public io::ByteSink {
 public:
  JoyStream(const JoyOptions& options, const Clock& clock, PadPort& pad,
            std::shared_ptr<Publisher<sensor_msgs::msg::Joy>> publisher, const Logger& logger, DeviceWatch& watch);

  void on_bytes(ByteView bytes, MonotonicTime received) override;
  void on_silence(MonotonicTime now) override;
  void on_break(io::StreamFault fault, MonotonicTime now) override;
  void on_refusal(io::StreamFault fault) override { watch_.lose(std::string(io::explain(fault))); }
  void on_return(MonotonicTime now) override;
  [[nodiscard]] MonotonicTime look_at(MonotonicTime latest) const override;

  /// Reads what the pad has and how it stands. Before the reading thread starts.
  void begin(MonotonicTime now);
  /// Messages leave only while it is active. Threads: any.
  void set_active(bool active);
  /// Threads: any.
  [[nodiscard]] JoyCounters counters() const;

 private:
  void take(const InputEvent& event, MonotonicTime received) NACELLE_REQUIRES(mutex_);
  void load(MonotonicTime now) NACELLE_REQUIRES(mutex_);
  void publish(MonotonicTime at, MonotonicTime now) NACELLE_REQUIRES(mutex_);
  void publish_neutral(MonotonicTime now) NACELLE_REQUIRES(mutex_);
  [[nodiscard]] bool may_publish() const NACELLE_REQUIRES(mutex_) { return active_ && is_there_; }

  const JoyOptions options_;
  const Clock& clock_;
  PadPort& pad_;
  const std::shared_ptr<Publisher<sensor_msgs::msg::Joy>> publisher_;
  const Logger& logger_;
  DeviceWatch& watch_;

  mutable Mutex mutex_;  // set_active() publishes from another thread
  InputEventDecoder decoder_ NACELLE_GUARDED_BY(mutex_);
  PadState state_ NACELLE_GUARDED_BY(mutex_);
  JoyPacer pacer_ NACELLE_GUARDED_BY(mutex_);
  JoyCounters counters_ NACELLE_GUARDED_BY(mutex_);
  PadState::Change change_ NACELLE_GUARDED_BY(mutex_) = PadState::Change::None;  // in the group under way
  MonotonicTime changed_at_ NACELLE_GUARDED_BY(mutex_){};  // the newest change that was not published
  bool drops_ NACELLE_GUARDED_BY(mutex_) = false;          // events, until the end of the group
  bool is_there_ NACELLE_GUARDED_BY(mutex_) = false;
  bool active_ NACELLE_GUARDED_BY(mutex_) = false;
};

}  // namespace nacelle::joy
