// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>

#include "diff_drive/model/edge_counter.hpp"
#include "diff_drive/port/wheel_encoders.hpp"
#include "nacelle/io/gpio_lines.hpp"

namespace nacelle::diff_drive {

/// Encoders on GPIO lines, whose edges this program counts.
///
/// The kernel notes each edge with its time and its number, so nothing is lost while the program is late, as long as read() is called before
/// the kernel's memory of 1024 edges is full. The program is not woken for each.
class EdgeEncoders final : public WheelEncoders {
 public:
  /// The request has the left wheel's lines first: A, or A and B; then as many of the right one. Precondition: the lines can be read.
  EdgeEncoders(std::unique_ptr<io::GpioInputs> lines, bool has_b);

  [[nodiscard]] bool read(WheelCount& left, WheelCount& right) override;
  void drive(int left, int right) override;
  [[nodiscard]] bool reopen() override { return lines_->reopen() && begin(); }
  [[nodiscard]] Duration longest_rest() const override { return kRest; }
  [[nodiscard]] Stats stats() const override;

  /// Both wheels together may make 200,000 edges per second then.
  static constexpr Duration kRest = 5ms;

 private:
  bool begin();
  void count(const io::GpioEdge& edge);

  const std::unique_ptr<io::GpioInputs> lines_;
  const unsigned lines_a_wheel_;
  std::array<EdgeCounter, 2> wheels_;
  std::array<io::GpioEdge, io::GpioInputs::kKept> edges_{};
  std::uint32_t sequence_ = 0;
};

}  // namespace nacelle::diff_drive
