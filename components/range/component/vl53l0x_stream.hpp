// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <memory>

#include "nacelle/io/byte_stream.hpp"
#include "range/component/vl53l0x.hpp"

namespace nacelle::range {

/// The results of a VL53L0X as a stream: 12 bytes each (Vl53l0xDecoder), as soon as the device has a new one.
///
/// Between results the device is left alone; near the time of the next one it is asked every few milliseconds.
/// Threads: as ByteStream; no writes. What prepares the device is called on the reading thread, or while there is none.
class Vl53l0xStream final : public io::ByteStream {
 public:
  Vl53l0xStream(std::unique_ptr<io::RegisterBus> bus, const Vl53l0x::Settings& settings, const Clock& clock);

  [[nodiscard]] Result<ByteView, io::StreamFault> read_until(MonotonicTime deadline) override;
  /// Errors: always WriteFailed.
  [[nodiscard]] Result<void, io::StreamFault> write(ByteView) override { return err(io::StreamFault::WriteFailed); }
  void interrupt() noexcept override { bus_->interrupt(); }
  [[nodiscard]] Result<void, io::StreamFault> reopen() override;
  [[nodiscard]] bool is_away() const noexcept override {
    return lost_.load(std::memory_order_relaxed) || bus_->is_away();
  }
  [[nodiscard]] int descriptor() const noexcept override { return -1; }

  [[nodiscard]] Vl53l0x& device() { return device_; }
  /// The device did not answer: everything fails with NotFound until reopen(). Before reading starts.
  void start_away() { lost_ = true; }

  /// How often it is asked when a result is due.
  static constexpr Duration kLook = 4ms;

 private:
  std::unique_ptr<io::RegisterBus> bus_;
  const Duration period_;
  const Clock& clock_;
  Vl53l0x device_;
  MonotonicTime next_;
  std::array<std::uint8_t, Vl53l0xDecoder::kRecordBytes> record_{};
  std::atomic<bool> lost_{false};
};

}  // namespace nacelle::range
