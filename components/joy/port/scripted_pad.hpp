// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "joy/port/pad_port.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/io/scripted_stream.hpp"

namespace nacelle::joy {

/// A gamepad whose events are written down beforehand: line() is the script. Threads: as ScriptedStream; set_info() from any.
class ScriptedPad final : public PadPort {
 public:
  ScriptedPad(PadInfo info, io::ScriptedStream::AtEnd at_end, io::ScriptedStream::Wait wait = {})
      : line_({}, at_end, std::move(wait)), info_(std::in_place, std::move(info)) {}

  /// The bytes that a kernel writes for one event.
  [[nodiscard]] static Bytes event(MonotonicTime at, std::uint16_t type, std::uint16_t code, std::int32_t value);

  [[nodiscard]] io::ScriptedStream& line() { return line_; }
  void set_info(PadInfo info) { *info_.lock() = std::move(info); }

  [[nodiscard]] Result<PadInfo, io::StreamFault> inspect() override;
  [[nodiscard]] Result<ByteView, io::StreamFault> read_until(MonotonicTime deadline) override {
    return line_.read_until(deadline);
  }
  [[nodiscard]] Result<void, io::StreamFault> write(ByteView) override { return err(io::StreamFault::WriteFailed); }
  void interrupt() noexcept override { line_.interrupt(); }
  [[nodiscard]] Result<void, io::StreamFault> reopen() override { return line_.reopen(); }
  [[nodiscard]] bool is_away() const noexcept override { return line_.is_away(); }
  [[nodiscard]] int descriptor() const noexcept override { return -1; }

 private:
  io::ScriptedStream line_;
  Guarded<PadInfo> info_;
};

}  // namespace nacelle::joy
