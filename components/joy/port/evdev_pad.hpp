// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <memory>

#include "joy/port/pad_search.hpp"

namespace nacelle::joy {

/// A gamepad of the kernel's (evdev). Other programs may read it at the same time.
class EvdevPad final : public PadPort {
 public:
  /// Errors: a Problem that says what is there instead, or which group is missing.
  [[nodiscard]] static Result<std::unique_ptr<PadPort>, Problem> open(const PadWish& wish, const Clock& clock);
  /// As open(), but an absent pad is no error: is_away() until reopen() finds it.
  [[nodiscard]] static Result<std::unique_ptr<PadPort>, Problem> open_or_await(const PadWish& wish, const Clock& clock);

  [[nodiscard]] Result<PadInfo, io::StreamFault> inspect() override;
  [[nodiscard]] Result<ByteView, io::StreamFault> read_until(MonotonicTime deadline) override;
  [[nodiscard]] Result<void, io::StreamFault> write(ByteView) override { return err(io::StreamFault::WriteFailed); }
  void interrupt() noexcept override { bell_.ring(); }
  /// Looks for the pad again; another one that fits the wish will do.
  [[nodiscard]] Result<void, io::StreamFault> reopen() override;
  [[nodiscard]] bool is_away() const noexcept override { return away_.load(std::memory_order_acquire); }
  [[nodiscard]] int descriptor() const noexcept override { return device_.number(); }

 private:
  EvdevPad(PadWish wish, const Clock& clock, io::Descriptor device, std::string path, bool away);

  const PadWish wish_;
  const Clock& clock_;
  io::Descriptor device_;  // of the null device while it is away
  std::string path_;
  std::atomic<bool> away_;
  Bell bell_;
  std::array<std::uint8_t, std::size_t{64} * 24> buffer_{};  // the kernel keeps about 64 events for each reader
};

}  // namespace nacelle::joy
